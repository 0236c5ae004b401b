"""Every shipped scene moves like its golden; `make goldens` writes it where it is meant not to."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import PronkError
from pipeline.production.motion_golden import compare, read_golden
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene
from pipeline.spec.shipped import SUFFIX, library, shipped_scenes

MOTION = Path(__file__).parents[1] / "goldens" / "motion"

LONG = 100_000
"""Steps times nodes; more than that takes some three seconds to simulate."""


def _is_long(name: str) -> bool:
    try:
        golden = read_golden(MOTION / f"{name}.json")
    except PronkError:
        return False
    facts = golden.facts
    return bool(facts["frames"] * facts["steps"] * len(golden.nodes) > LONG)


SCENES = [
    pytest.param(name, marks=[pytest.mark.slow] if _is_long(name) else [])
    for name in shipped_scenes()
]


@pytest.mark.parametrize("name", SCENES)
def test_a_shipped_scene_moves_like_its_golden(name: str) -> None:
    golden = read_golden(MOTION / f"{name}.json")
    verdict = compare(golden, simulate(load_scene(library() / (name + SUFFIX))))
    assert verdict.passed, f"{verdict}\nif that is meant: make goldens SCENES={name}"
    assert golden.scene == name


def test_every_golden_has_a_scene() -> None:
    assert {path.stem for path in MOTION.glob("*.json")} == set(shipped_scenes())


def test_goldens_are_small_enough_for_version_control() -> None:
    for path in MOTION.glob("*.json"):
        marks = len(read_golden(path).marks)
        assert path.stat().st_size < 75_000 + 120 * marks, path
