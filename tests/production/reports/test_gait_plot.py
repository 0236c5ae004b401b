"""Gait plots: planned and measured stances."""

from __future__ import annotations

import io
import json
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pipeline import cli
from pipeline.commands import options
from pipeline.errors import UsageError
from pipeline.production.reports.gait_plot import (
    CreatureStances,
    creature_stances,
    gait_svg,
    walkers_of,
)
from pipeline.production.reports.plot_files import png_of
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array
from pipeline.spec import Scene, read_scene

pytestmark = pytest.mark.nightly

HEAD = "pronk: 1\nduration: 2\nterrain: {kind: flat, size: [60, 60]}\ncast:\n"
CAST = """\
- {name: bug, figure: beetle, at: [0, 5], walk: {gait: ripple, speed: 0.7}}
- {name: statue, figure: camel, at: [0, -9]}
- {name: mare, figure: horse, walk: {gait: rotary gallop, speed: 7}}
- {name: pip, figure: person, at: [0, -5], walk: {gait: run, duty: 0.3, speed: 2.5}}
- {name: looper, figure: inchworm, at: [0, 9], walk: {}}
"""


def stances(scene: Scene) -> list[CreatureStances]:
    take = simulate(scene)
    return [creature_stances(scene, name, take) for name in walkers_of(scene)]


@pytest.fixture(scope="module")
def creatures() -> list[CreatureStances]:
    """Stances of a beetle, a horse and a person."""
    return stances(read_scene(HEAD + CAST))


def samples(spans: Array, times: Array) -> Array:
    """Return which of regular moments lie within intervals."""
    inside = (times[:, None] >= spans[:, 0]) & (times[:, None] < spans[:, 1])
    result: Array = inside.any(axis=-1)
    return result


@pytest.mark.slow
def test_there_is_a_panel_for_every_creature_that_walks_on_legs(
    creatures: list[CreatureStances],
) -> None:
    assert [creature.name for creature in creatures] == ["bug", "mare", "pip"]
    assert [creature.gait for creature in creatures] == ["ripple", "rotary gallop", "run"]
    assert [leg.name for leg in creatures[1].legs] == ["l1", "l2", "r1", "r2"]


def test_measured_stances_match_the_gait(creatures: list[CreatureStances]) -> None:
    """Measured touchdowns are exact to a fraction of a step, lift-offs to a row of the take."""
    row = 1.0 / 96.0
    for creature in creatures:
        for leg in creature.legs:
            assert leg.planned.shape == leg.actual.shape
            begins, ends = (leg.actual - leg.planned).T
            assert np.abs(begins[leg.planned[:, 0] > 0.0]).max() < 1e-9
            assert np.abs(ends).max() <= row


def test_flights_are_the_times_without_bars(creatures: list[CreatureStances]) -> None:
    times = np.linspace(0.0, 1.99, 1999)
    for creature in creatures:
        down = np.any([samples(leg.planned, times) for leg in creature.legs], axis=0)
        assert np.mean(samples(creature.flights, times) == ~down) > 0.995
    assert not len(creatures[0].flights)
    assert len(creatures[1].flights) >= 4


def test_duty_factors_match_the_bars(creatures: list[CreatureStances]) -> None:
    """Of the person: 30 % of each whole cycle."""
    for leg in creatures[2].legs:
        begins, ends = leg.planned.T
        lengths, cycles = (ends - begins)[1:-1], np.diff(begins[1:])
        assert np.allclose(lengths[: len(cycles)] / cycles[: len(lengths)], 0.3, atol=1e-6)


def test_a_halted_creature_stands_to_the_end() -> None:
    member = "- {name: bug, figure: beetle, scale: 0.5, at: [2.2, 0], walk: {gait: tripod}}\n"
    scene = read_scene(HEAD.replace("2\n", "6\n", 1).replace("60, 60", "6, 6") + member)
    (bug,) = stances(scene)
    for leg in bug.legs:
        assert leg.actual[-1, 1] >= 6.0
        assert leg.actual[-1, 0] < 3.0


def test_the_svg_has_a_bar_for_every_contact(creatures: list[CreatureStances]) -> None:
    svg = gait_svg("Title & all", creatures, 2.0, 24.0)
    root = ET.fromstring(svg)
    filled = [e for e in root.iter("{http://www.w3.org/2000/svg}rect") if e.get("fill-opacity")]
    seen = sum(
        int((spans[:, 0] < 2.0).sum())
        for creature in creatures
        for leg in creature.legs
        for spans in (leg.planned, leg.actual)
    )
    assert len(filled) == seen
    texts = {e.text for e in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"Title & all", "mare", "rotary gallop", "r2", "frame 1", "1 s", "40"} <= texts
    picture = np.asarray(Image.open(io.BytesIO(png_of(svg))).convert("RGB"), dtype=float)
    assert picture.std() > 10.0


@pytest.mark.parametrize(
    "cast",
    [
        "- {figure: horse}\n",
        "- {figure: inchworm, walk: {}}\n",
    ],
)
def test_a_scene_without_walkers_is_refused(cast: str) -> None:
    with pytest.raises(UsageError, match=r"nobody in this scene walks on legs.*walk: \{\}"):
        walkers_of(read_scene(HEAD + cast))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, which holds scenes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cli, "listen", lambda: None)
    monkeypatch.setattr(options.CURRENT, "options", options.Verbosity())
    bug = "- {name: bug, figure: beetle, walk: {}}\n"
    (tmp_path / "play.yaml").write_text(HEAD + bug)
    (tmp_path / "still.yaml").write_text(HEAD + "- {figure: beetle}\n")
    (tmp_path / "wrong.yaml").write_text(HEAD + "- {figure: beetle, walk: {gait: canter}}\n")
    return tmp_path


def called(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Run a command and return its exit code."""
    monkeypatch.setattr(sys, "argv", ["pronk", *arguments])
    with pytest.raises(SystemExit) as end:
        cli.main()
    return int(end.value.code or 0)


def test_gait_plot_command_writes_both_pictures_and_keeps_the_take(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert called(monkeypatch, "plot", "gait", "play", "-q") == 0
    files = [folder / "out" / "play" / f"play_gait.{end}" for end in ("svg", "png")]
    before = [file.read_bytes() for file in files]
    assert (folder / "out" / "play" / "take.zarr").is_dir()
    capfd.readouterr()
    assert called(monkeypatch, "plot", "gait", "play", "--json") == 0
    assert "up to date" in capfd.readouterr().out
    assert [file.read_bytes() for file in files] == before


@pytest.mark.parametrize(
    ("name", "code", "phrase"),
    [
        ("still", 2, "nobody in this scene walks"),
        ("wrong", 3, "wrong.yaml:5:33: cast[0].walk.gait: a gait 'canter' needs two pairs"),
        ("gone", 2, "gone"),
    ],
)
def test_gait_plot_command_refuses_with_one_message(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    name: str,
    code: int,
    phrase: str,
) -> None:
    assert called(monkeypatch, "plot", "gait", name) == code
    captured = capfd.readouterr()
    assert phrase in captured.err
    assert "Traceback" not in captured.err
    assert called(monkeypatch, "plot", "gait", name, "--json") == code
    assert json.loads(capfd.readouterr().out.splitlines()[-1])["exit_code"] == code
    assert not (folder / "out" / name).exists()


@pytest.mark.nightly
def test_planned_stances_follow_a_change_of_gait() -> None:
    member = "- {name: mare, figure: horse, walk: {gait: walk}}\n"
    script = "script: [{at: 1.5, who: mare, do: {gait: trot}}, {at: 5, who: mare, do: stop}]\n"
    (mare,) = stances(read_scene(HEAD.replace("2\n", "5\n", 1) + member + script))
    assert mare.gait == "walk → trot"
    for leg in mare.legs:
        assert leg.planned.shape == leg.actual.shape
        begins, ends = (leg.actual - leg.planned).T
        assert np.abs(begins[leg.planned[:, 0] > 0.0]).max() < 2e-3
        assert np.abs(ends).max() < 2.0 / 96.0


def test_a_raised_leg_has_no_bars() -> None:
    member = "- {name: pip, figure: person, walk: {gait: walk}}\n"
    do = "{gait: hop, legs: [r1]}"
    script = f"script: [{{at: 1, who: pip, do: {do}}}, {{at: 3, who: pip, do: {{gait: walk}}}}]\n"
    (pip,) = stances(read_scene(HEAD.replace("2\n", "6\n", 1) + member + script))
    left = next(leg for leg in pip.legs if leg.name == "l1")
    assert left.planned.shape == left.actual.shape
    assert np.max(left.planned[1:, 0] - left.planned[:-1, 1]) > 1.0
    assert len(pip.flights) > 2
