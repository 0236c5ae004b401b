"""Goldens hold on every class of processor: chaotic scenes up to the step where they diverge."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.processor import RELATED, REQUIRED_FLAGS, processor_flags
from pipeline.production.goldens.motion_comparison import compare
from pipeline.production.goldens.motion_file import read_golden
from pipeline.production.goldens.motion_golden import MotionGolden
from pipeline.production.goldens.motion_sensitivity import predictable_steps
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import load_scene
from pipeline.spec.scene_library import SUFFIX, library, shipped_scenes

ROOT = Path(__file__).parents[3]
MOTION = ROOT / "tests" / "goldens" / "motion"

COMPARE = """
import sys
import pipeline
from pathlib import Path
from pipeline.production.goldens.motion_comparison import compare
from pipeline.production.goldens.motion_file import read_golden
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene
from pipeline.spec.library_search import SUFFIX, library
for name in sys.argv[2:]:
    golden = read_golden(Path(sys.argv[1], name + ".json"))
    verdict = compare(golden, simulate(load_scene(library() / (name + SUFFIX))))
    print(name, "passed" if verdict.passed else "failed", verdict, sep=": ")
"""

needs_avx2 = pytest.mark.skipif(
    not processor_flags() >= REQUIRED_FLAGS, reason="the processor has no AVX2, or is no x86-64"
)


def verdicts(scenes: list[str], **variables: str) -> dict[str, str]:
    """Return scene -> verdict of a process whose kernels `variables` alone select.

    The verdict is its first line, "passed: ..." or "failed: ...".
    """
    clean = {name: value for name, value in os.environ.items() if name not in RELATED}
    done = subprocess.run(
        [sys.executable, "-c", COMPARE, str(MOTION), *scenes],
        env={**clean, **variables},
        capture_output=True,
        text=True,
        check=True,
    )
    lines = [line.split(": ", 1) for line in done.stdout.splitlines() if line[:1].strip()]
    return {name: rest for name, rest in lines if name in scenes}


def dispatched_units() -> str:
    """Return the vector units of this machine that numpy dispatches to, in numpy's syntax."""
    show = "import numpy; print(*numpy.show_config(mode='dicts')['SIMD Extensions']['found'])"
    clean = {name: value for name, value in os.environ.items() if name not in RELATED}
    command = [sys.executable, "-c", show]
    return subprocess.run(
        command, env=clean, capture_output=True, text=True, check=True
    ).stdout.strip()


@pytest.mark.nightly
@needs_avx2
def test_goldens_are_identical_where_the_environment_names_the_held_kernels() -> None:
    found = verdicts(["dominoes", "through_the_wall"], OPENBLAS_CORETYPE="Haswell")
    assert len(found) == 2
    assert all("identical" in verdict for verdict in found.values()), found


@pytest.mark.slow
@needs_avx2
@pytest.mark.parametrize(
    "scenes",
    [
        pytest.param(["ragdolls_stairs", "through_the_wall"], marks=pytest.mark.nightly),
        pytest.param(shipped_scenes(), marks=pytest.mark.nightly),
    ],
    ids=["two chaotic scenes", "all scenes"],
)
def test_goldens_hold_on_another_class_of_processor(scenes: list[str]) -> None:
    found = verdicts(scenes, NPY_DISABLE_CPU_FEATURES=dispatched_units())
    assert found.keys() == set(scenes)
    failed = [verdict for verdict in found.values() if not verdict.startswith("passed")]
    assert not failed, "\n".join(failed)


@pytest.mark.nightly
@pytest.mark.parametrize("name", shipped_scenes())
def test_goldens_say_up_to_which_step_their_motion_is_predictable(name: str) -> None:
    scene = load_scene(library() / (name + SUFFIX))
    step = predictable_steps(scene, simulate(scene))
    recorded = read_golden(MOTION / f"{name}.json").predictable
    assert (step is None) == (recorded is None)


@pytest.fixture(scope="module")
def golden() -> MotionGolden:
    return read_golden(MOTION / "dominoes.json")


@pytest.fixture(scope="module")
def elsewhere(golden: MotionGolden) -> Take:
    """Return the golden's take as if another class of processor had made it."""
    take = simulate(load_scene(library() / ("dominoes" + SUFFIX)))
    versions = {**take.header.versions, "machine": "another"}
    return replace(take, header=replace(take.header, versions=versions))


def moved(take: Take, first_step: int, metres: float) -> Take:
    """Return `take` with every node lifted by `metres` from `first_step` on."""
    positions = np.array(take.positions)
    positions[first_step * take.header.samples // take.header.steps :, :, 1] += metres
    return replace(take, positions=positions)


@pytest.mark.nightly
def test_a_chaotic_take_is_compared_up_to_its_horizon(
    golden: MotionGolden, elsewhere: Take
) -> None:
    assert golden.predictable is not None
    late = moved(elsewhere, golden.predictable + 8, 0.01)
    assert compare(golden, late).passed
    assert not compare(golden, moved(elsewhere, golden.predictable - 8, 0.01)).passed
    at_home = replace(late, header=replace(late.header, versions=golden.versions))
    assert not compare(golden, at_home).passed


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["energy", "space", "rest", "counts", "life"])
@pytest.mark.nightly
def test_a_chaotic_take_keeps_its_invariants(
    golden: MotionGolden, elsewhere: Take, fault: str
) -> None:
    assert golden.predictable is not None
    take = elsewhere
    if fault == "energy":
        take = moved(take, golden.predictable + 8, 1.0)
    elif fault == "space":
        positions = np.array(take.positions)
        positions[-40:, 0, 0] += 30.0
        take = replace(take, positions=positions)
    elif fault == "rest":
        positions = np.array(take.positions)
        positions[-2:, :, 2] += np.array([[0.0], [0.02]])
        take = replace(take, positions=positions)
    elif fault == "counts":
        kept = tuple(c for i, c in enumerate(take.contacts) if i % 2 or c.step < golden.predictable)
        take = replace(take, contacts=kept)
    else:
        alive = np.array(take.alive)
        alive[-1, 0] = False
        take = replace(take, alive=alive)
    verdict = compare(golden, take)
    assert not verdict.passed
    assert {difference.kind for difference in verdict.differences} == {"invariant"}
