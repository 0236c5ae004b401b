"""Compiled loops: as plain Python, kept in the user's cache, loaded for bodies alone."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

FALL = """
from tests.simulation.dynamics.test_terrain_bodies import DT, drops
import numpy as np
bouncing = drops(np.random.default_rng(5), 12, "hills")
bouncing.state.v[:, 1] = -5.0
seen = sum(len(bouncing.advance(DT)) for _ in range(20))
assert seen > 2, seen
state = bouncing.state
print(np.concatenate([x.ravel() for x in (state.p, state.q, state.v, state.w)]).tobytes().hex())
"""


def told(code: str, **environment: str) -> str:
    """Return what a process of its own prints."""
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
def test_machine_code_does_what_python_does() -> None:
    compiled, plain = (
        np.frombuffer(bytes.fromhex(told(FALL, NUMBA_DISABLE_JIT=word))) for word in ("0", "1")
    )
    # In flight to the last bit. Where an impact is found to a part of its tolerance, what
    # comes after it may differ by as much, times the turning.
    np.testing.assert_allclose(compiled, plain, rtol=0, atol=1e-4)
    assert (compiled == plain).mean() > 0.6


ENTRY = """
import numpy as np
from pipeline.simulation.dynamics.compiled import is_cached
from pipeline.simulation.dynamics.free_motion import rotate_freely
q, one = np.array([[1.0, 0.0, 0.0, 0.0]]), np.eye(3)[None]
before = is_cached("dynamics")
rotate_freely(q, np.ones((1, 3)), one, one, 0.01)
print(rotate_freely.stats.cache_path, before, is_cached("dynamics"))
"""


@pytest.mark.slow
def test_machine_code_is_kept_in_the_users_cache(tmp_path: Path) -> None:
    where, *made = told(ENTRY, XDG_CACHE_HOME=str(tmp_path), NUMBA_CACHE_DIR="").split()
    assert made == ["False", "True"]
    assert Path(where).is_relative_to(tmp_path / "pronk" / "compiled")
    assert list(Path(where).glob("*.nbc"))


@pytest.mark.slow
def test_where_nothing_can_be_kept_it_works_all_the_same(tmp_path: Path) -> None:
    # No folder can be made below a file.
    (tmp_path / "file").touch()
    where = told(ENTRY, XDG_CACHE_HOME=str(tmp_path / "file"), NUMBA_CACHE_DIR="")
    assert where.split() == ["None", "False", "False"]


@pytest.mark.parametrize("cast", ["{figure: beetle, walk: {}}", "{prop: {shape: ball}}"])
def test_scenes_without_bodies_load_no_compiler(cast: str) -> None:
    code = (
        "import sys, pipeline.cli\n"
        "from pipeline.simulation.simulate import Simulation\n"
        "from pipeline.spec import read_scene\n"
        f"Simulation(read_scene('pronk: 1\\nduration: 1\\ncast: [{cast}]')).step()\n"
        "print('numba' in sys.modules)"
    )
    assert told(code).strip() == "False"
