"""Compiled functions: they match Python, are cached for the user, and load with bodies only."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

DROP_BODIES = """
from tests.simulation.dynamics.test_terrain_bodies import DT, build_random_drop
import numpy as np
falling = build_random_drop(np.random.default_rng(5), 12, "hills")
falling.state.v[:, 1] = -5.0
seen = sum(len(falling.advance(DT)) for _ in range(20))
assert seen > 2, seen
state = falling.state
print(np.concatenate([x.ravel() for x in (state.p, state.q, state.v, state.w)]).tobytes().hex())
"""


def run_python(code: str, **environment: str) -> str:
    """Return the output of a new Python process."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        cwd=Path(__file__).parents[3],
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_compiled_code_matches_python() -> None:
    compiled, plain = (
        np.frombuffer(bytes.fromhex(run_python(DROP_BODIES, NUMBA_DISABLE_JIT=flag)))
        for flag in ("0", "1")
    )
    # Flights agree to the last bit. Times of impacts agree within their tolerance, which later
    # motion amplifies.
    np.testing.assert_allclose(compiled, plain, rtol=0, atol=1e-4)
    assert (compiled == plain).mean() > 0.6


COMPILE_ONE = """
import numpy as np
from pipeline.simulation.dynamics.compiled import is_cached
from pipeline.simulation.dynamics.free_motion import rotate_freely
q, one = np.array([[1.0, 0.0, 0.0, 0.0]]), np.eye(3)[None]
before = is_cached("dynamics")
rotate_freely(q, np.ones((1, 3)), one, one, 0.01)
print(rotate_freely.stats.cache_path, before, is_cached("dynamics"))
"""


@pytest.mark.slow
def test_compiled_code_is_stored_in_the_users_cache(tmp_path: Path) -> None:
    folder, *is_cached = run_python(
        COMPILE_ONE, XDG_CACHE_HOME=str(tmp_path), NUMBA_CACHE_DIR=""
    ).split()
    assert is_cached == ["False", "True"]
    assert Path(folder).is_relative_to(tmp_path / "pronk" / "compiled")
    assert list(Path(folder).glob("*.nbc"))


@pytest.mark.slow
def test_compilation_works_without_a_writable_cache(tmp_path: Path) -> None:
    # No folder can be made below a file.
    (tmp_path / "file").touch()
    output = run_python(COMPILE_ONE, XDG_CACHE_HOME=str(tmp_path / "file"), NUMBA_CACHE_DIR="")
    assert output.split() == ["None", "False", "False"]


@pytest.mark.parametrize("cast", ["{figure: beetle, walk: {}}", "{prop: {shape: ball}}"])
def test_scenes_without_bodies_load_no_compiler(cast: str) -> None:
    code = (
        "import sys, pipeline.cli\n"
        "from pipeline.simulation.simulate import Simulation\n"
        "from pipeline.spec import read_scene\n"
        f"Simulation(read_scene('pronk: 1\\nduration: 1\\ncast: [{cast}]')).step()\n"
        "print('numba' in sys.modules)"
    )
    assert run_python(code).strip() == "False"
