"""Every shipped scene moves like its golden; `make goldens` writes it where it is meant not to."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from pipeline.errors import PronkError
from pipeline.production.goldens.motion_comparison import compare
from pipeline.production.goldens.motion_file import read_golden
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene
from pipeline.spec.scene_library import SUFFIX, library, shipped_scenes

MOTION = Path(__file__).parents[2] / "goldens" / "motion"

LONG, LONGEST = 30_000, 60_000
"""Steps times nodes; more than that take about a second to simulate, and about two."""


def _tier(name: str) -> list[pytest.MarkDecorator]:
    try:
        golden = read_golden(MOTION / f"{name}.json")
    except PronkError:
        return []
    work = golden.facts["frames"] * golden.facts["steps"] * len(golden.nodes)
    if work > LONGEST:
        return [pytest.mark.nightly]
    return [pytest.mark.slow] if work > LONG else []


SCENES = [pytest.param(name, marks=_tier(name)) for name in shipped_scenes()]


@pytest.mark.sample(14)
@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_a_shipped_scene_moves_like_its_golden(name: str) -> None:
    golden = read_golden(MOTION / f"{name}.json")
    verdict = compare(golden, simulate(load_scene(library() / (name + SUFFIX))))
    assert verdict.passed, f"{verdict}\nif that is meant: make goldens SCENES={name}"
    assert golden.scene == name


def test_every_golden_has_a_scene() -> None:
    assert {path.stem for path in MOTION.glob("*.json")} == set(shipped_scenes())


@pytest.mark.slow
def test_goldens_are_small_enough_for_version_control() -> None:
    for path in MOTION.glob("*.json"):
        marks = len(read_golden(path).marks)
        assert path.stat().st_size < 130_000 + 120 * marks, path


@pytest.fixture
def update(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ModuleType:
    """Return the script that writes goldens, at work in another folder."""
    path = MOTION.parent / "update.py"
    spec = importlib.util.spec_from_file_location("update", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "MOTION", tmp_path)
    return module


@pytest.mark.nightly
def test_only_outdated_goldens_are_written(update: ModuleType, tmp_path: Path) -> None:
    path = tmp_path / "first_steps.json"
    assert "written" in update.update("first_steps", False)
    fresh = path.read_bytes()
    # The golden names another machine; it passes and is kept.
    path.write_bytes(fresh.replace(b'"machine": "', b'"machine": "another '))
    assert "written" not in update.update("first_steps", False)
    assert path.read_bytes() != fresh
    path.write_bytes(fresh[:999])
    assert "cut short" in update.update("first_steps", False)
    assert path.read_bytes() == fresh
    (tmp_path / "gone.json").write_bytes(fresh)
    assert update.orphans() == [tmp_path / "gone.json"]


def test_a_name_that_is_no_scene_is_refused(
    update: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["update.py", "first_stps"])
    assert update.main() == 2
    assert "did you mean 'first_steps'" in capsys.readouterr().err
