"""Compiled functions: they match Python, are cached for the user, and load with bodies only."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pipeline.simulation.dynamics.compiled import bound
from pipeline.simulation.dynamics.free_motion import rotate_freely
from pipeline.simulation.spatial import Array

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


@pytest.mark.nightly
def test_compiled_code_matches_python() -> None:
    compiled, plain = (
        np.frombuffer(bytes.fromhex(run_python(DROP_BODIES, NUMBA_DISABLE_JIT=flag)))
        for flag in ("0", "1")
    )
    # Flights agree to the last bit. Times of impacts agree within their tolerance, which later
    # motion amplifies.
    np.testing.assert_allclose(compiled, plain, rtol=0, atol=1e-4)
    assert (compiled == plain).mean() > 0.6


def test_a_bound_call_goes_on_from_what_the_last_one_left() -> None:
    def bodies() -> tuple[Array, Array, Array, Array]:
        q, w = np.array([[1.0, 0.0, 0.0, 0.0]]), np.array([[0.3, -2.0, 1.0]])
        inertia = np.diag([0.1, 0.2, 0.4])[None].copy()
        return q, w, inertia, np.linalg.inv(inertia)

    plain, held = bodies(), bodies()
    turn = bound(rotate_freely, *held, 0.01)
    for _ in range(3):
        rotate_freely(*plain, 0.01)
        turn()
        for one, other in zip(plain, held, strict=True):
            assert np.array_equal(one, other)
    assert not np.array_equal(held[0], bodies()[0])


def test_a_bound_call_takes_its_further_arguments_anew() -> None:
    q, inertia = np.array([[1.0, 0.0, 0.0, 0.0]]), np.diag([0.1, 0.2, 0.4])[None].copy()
    w, inverse = np.array([[0.3, -2.0, 1.0]]), np.linalg.inv(inertia)
    plain, held = q.copy(), q.copy()
    turn = bound(rotate_freely, held, w.copy(), examples=(inertia, inverse, 0.0))
    for dt in (0.01, 0.03):
        rotate_freely(plain, w, inertia, inverse, dt)
        turn(inertia, inverse, dt)
        assert np.array_equal(plain, held)
    assert not np.array_equal(held, q)


COMPILE_ONE = """
import numpy as np
from pipeline.simulation.code_samples import code_folder
from pipeline.simulation.compilation import CompilationObserver, observed
from pipeline.simulation.dynamics.free_motion import rotate_freely

class Printer(CompilationObserver):
    def begin(self, room, functions): print("begin", room, functions)
    def advance(self): print("one")
    def end(self): print("end")
    def warn(self, text): print("warn", text)

q, one = np.array([[1.0, 0.0, 0.0, 0.0]]), np.eye(3)[None]
with observed(Printer()):
    rotate_freely(q, np.ones((1, 3)), one, one, 0.01)
print(q.sum())
print(code_folder())
"""


@pytest.mark.nightly
def test_compiled_code_is_stored_and_a_damaged_file_replaced(tmp_path: Path) -> None:
    def lines() -> list[str]:
        return run_python(
            COMPILE_ONE, XDG_CACHE_HOME=str(tmp_path), NUMBA_CACHE_DIR=""
        ).splitlines()

    begin, *ones, end, result, folder = lines()
    functions = len(ones)
    assert (begin, end) == (f"begin bodies {functions}", "end")
    assert functions > 5
    assert set(ones) == {"one"}
    assert Path(folder).is_relative_to(tmp_path / "pronk" / "compiled")
    assert lines() == [result, folder]
    (file,) = Path(folder).iterdir()
    whole = file.read_bytes()
    for damaged in (b"", whole[:-100], whole[:5000] + b"x" + whole[5001:]):
        file.write_bytes(damaged)
        assert lines() == [begin, *ones, end, result, folder]
        assert lines() == [result, folder]


@pytest.mark.nightly
def test_where_nothing_can_be_stored_it_works_with_a_warning(tmp_path: Path) -> None:
    # No folder can be made below a file.
    (tmp_path / "file").touch()
    out = run_python(COMPILE_ONE, XDG_CACHE_HOME=str(tmp_path / "file"), NUMBA_CACHE_DIR="")
    (warning,) = [line for line in out.splitlines() if line.startswith("warn")]
    assert f"{tmp_path}/file/pronk/compiled" in warning
    assert "set XDG_CACHE_HOME to a folder that is writable" in warning


@pytest.mark.nightly
def test_all_of_it_can_be_compiled_ahead(tmp_path: Path) -> None:
    code = """
from pipeline.production.run.compile_progress import compile_ahead
from pipeline.production.run.progress import Reporter
from pipeline.simulation.simulate import simulate
from pipeline.spec import library, load_scene
compile_ahead(Reporter())
print(compile_ahead(Reporter()))
from pipeline.production.run.compile_progress import compile_progress
with compile_progress(Reporter()) as progress:
    for name in ("dice", "boulders", "dominoes", "ragdolls_stairs", "sitting_circle"):
        scene = load_scene(library() / f"{name}.yaml", ["duration=0.5"])
        simulate(scene)
print(progress.functions)
"""
    ready, functions = run_python(
        code, XDG_CACHE_HOME=str(tmp_path), NUMBA_CACHE_DIR=""
    ).splitlines()
    assert ready.endswith(": up to date")
    assert functions == "0"


@pytest.mark.sample(1)
@pytest.mark.parametrize("cast", ["{figure: beetle, walk: {}}", "{prop: {shape: ball}}"])
@pytest.mark.nightly
def test_scenes_without_bodies_load_no_compiler(cast: str) -> None:
    code = (
        "import sys, pipeline.cli\n"
        "from pipeline.simulation.simulate import Simulation\n"
        "from pipeline.spec import read_scene\n"
        f"Simulation(read_scene('pronk: 1\\nduration: 1\\ncast: [{cast}]')).step()\n"
        "print('numba' in sys.modules)"
    )
    assert run_python(code).strip() == "False"
