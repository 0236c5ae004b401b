"""Several scenes in one command: each stands for itself, and a table tells what became of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pipeline.production.reports import stills
from pipeline.production.run import production
from pipeline.production.run.batch import run_batch
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.progress import Reporter
from pipeline.simulation.simulate import Simulation

if TYPE_CHECKING:
    from tests.production.conftest import Studio

Pronk = Callable[..., tuple[int, str, str]]

NO_FOOTHOLD = "{kind: fractal, height: 40, unsteppable_slope_deg: 1, size: [8, 8], cells: [8, 8]}"
FLAT = "{kind: flat, size: [8, 8], cells: [8, 8], material: ground, scatter: none}"


@pytest.fixture
def short(unmade: Studio) -> str:
    """Return the text of a scene of two frames."""
    return unmade.scene.read_text().replace("frames: 8", "frames: 2")


@pytest.fixture
def folder(short: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with right scenes a and d, broken YAML, and a scene that cannot start."""
    for name in ("a", "d"):
        (tmp_path / f"{name}.yaml").write_text(short)
    (tmp_path / "bad.yaml").write_text(short.replace("seed: 3", "seed: {3"))
    (tmp_path / "wrong.yaml").write_text(
        short.replace("seed:", "sead:").replace("fps: 24", "fps: x")
    )
    (tmp_path / "fail.yaml").write_text(short.replace(FLAT, NO_FOOTHOLD))
    (tmp_path / "folder.yaml").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def table_of(err: str) -> dict[str, str]:
    """Return the rows of the table at the end of standard error, by scene."""
    lines = err.splitlines()
    first = max(i for i, line in enumerate(lines) if line.startswith("scene "))
    return {line.split()[0]: line for line in lines[first + 1 :]}


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("command", "made"),
    [
        (("simulate",), "take.zarr"),
        (("midi",), "{}.mid"),
        pytest.param(("sheet", "--count", "1"), "{}_sheet.png", marks=pytest.mark.nightly),
        pytest.param(("render",), "{}.mp4", marks=pytest.mark.nightly),
        pytest.param(("render", "--jobs", "2"), "{}.mp4", marks=pytest.mark.nightly),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_scenes_after_one_that_fails_are_made(
    pronk: Pronk, folder: Path, command: tuple[str, ...], made: str
) -> None:
    scenes = ("a", "bad", "nowhere", "fail", "folder.yaml", "d")
    code, out, err = pronk(*command, *scenes)
    assert code == 3
    for name in ("a", "d"):
        assert (folder / "out" / name / made.format(name)).exists()
    assert len(out.splitlines()) == 2
    errors = [line for line in err.splitlines() if line.startswith("error: ")]
    starts = ("bad.yaml:", "no scene is called 'nowhere'", "fail.yaml:8:", "'folder.yaml' is")
    assert len(errors) == len(starts)
    assert all(e.startswith(f"error: {s}") for e, s in zip(errors, starts, strict=True))
    rows = table_of(err)
    assert list(rows) == list(scenes)
    assert rows["a"].endswith("done")
    assert " failed: " in rows["fail"]


def test_the_table_counts_frames_and_cached_ones(pronk: Pronk, folder: Path, short: str) -> None:
    first = table_of(pronk("simulate", "a", "d")[2])
    (folder / "d.yaml").write_text(short.replace("speed: 0.6", "speed: 0.7"))
    second = table_of(pronk("simulate", "a", "d")[2])
    assert [first[name].split()[1:3] for name in ("a", "d")] == [["2", "0"], ["2", "0"]]
    assert [second[name].split()[1:3] for name in ("a", "d")] == [["2", "2"], ["2", "0"]]


@pytest.mark.parametrize(
    ("scenes", "code"),
    [
        (("a", "d"), 0),
        (("nowhere", "a"), 2),
        (("nowhere", "bad", "a"), 3),
        (("fail", "nowhere", "a"), 3),
    ],
)
def test_the_exit_code_is_the_highest(
    pronk: Pronk, folder: Path, scenes: tuple[str, ...], code: int
) -> None:
    assert pronk("check", *scenes)[0] == code


def test_quiet_leaves_the_errors_alone(pronk: Pronk, folder: Path) -> None:
    code, out, err = pronk("check", "a", "fail", "nowhere", "-q")
    assert (code, out) == (3, "")
    errors = [line for line in err.splitlines() if line.startswith("error")]
    assert [line[:12] for line in errors] == ["error: fail.", "error: no sc"]


def test_one_scene_has_no_table(pronk: Pronk, folder: Path) -> None:
    assert pronk("check", "a")[2] == ""
    assert "seconds" not in pronk("check", "fail")[2]


def test_check_tells_all_mistakes_of_all_files(pronk: Pronk, folder: Path) -> None:
    code, out, err = pronk("check", "a", "bad", "wrong", "fail", "d")
    assert code == 3
    assert [line.split(":")[0] for line in out.splitlines()] == ["a", "d"]
    for told in ("bad.yaml:6:", "wrong.yaml:5:1: sead", "wrong.yaml:3:6: fps", "fail.yaml:8:"):
        assert f"\nerror: {told}" in err or f"\n{told}" in err


def test_json_lines_name_their_scene_and_end_with_a_table(pronk: Pronk, folder: Path) -> None:
    code, out, err = pronk("simulate", "a", "bad", "--json")
    lines = [json.loads(line) for line in out.splitlines()]
    assert (code, err) == (3, "")
    *events, table = lines
    assert {event["scene"] for event in events} == {"a", "bad"}
    (error,) = [event for event in events if event["event"] == "error"]
    assert (error["scene"], error["exit_code"]) == ("bad", 3)
    assert error["problems"][0]["line"] > 0
    assert (table["event"], table["exit_code"]) == ("table", 3)
    a, bad = table["scenes"]
    assert (a["scene"], a["state"], a["frames"], a["of"], a["cached"]) == ("a", "done", 2, 2, 0)
    assert (bad["scene"], bad["state"], bad["frames"], bad["exit_code"]) == (
        "bad",
        "failed",
        None,
        3,
    )


def test_a_value_that_suits_one_scene_alone_names_the_other(
    pronk: Pronk, folder: Path, short: str
) -> None:
    (folder / "d.yaml").write_text(short.replace("bug", "ant"))
    code, out, err = pronk("check", "a", "d", "--set", "cast.bug.scale=0.5")
    assert (code, out.splitlines()[0][:9]) == (3, "a: right:")
    assert "error: d.yaml: --set cast.bug.scale=0.5" in err


def test_frames_that_nobody_can_read_are_refused_once(pronk: Pronk, folder: Path) -> None:
    code, out, err = pronk("render", "a", "d", "--frames", "one")
    assert (code, out, err.count("error: ")) == (2, "", 1)
    assert not (folder / "out").exists()


def test_frames_that_one_scene_lacks_name_it(
    pronk: Pronk, folder: Path, short: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def render(order: Order, reporter: Reporter) -> Outputs:
        return Outputs(order.out / order.name, order.name)

    monkeypatch.setattr(production, "render", render)
    (folder / "d.yaml").write_text(short.replace("frames: 2", "frames: 4"))
    code, out, err = pronk("render", "a", "d", "--frames", "1-4")
    assert (code, out) == (2, "out/d\n")
    assert "error: a.yaml: --frames '1-4': the scene has frames 1-2, no 3" in err


def test_a_defect_in_one_scene_leaves_the_others(
    pronk: Pronk, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def sheet(order: Order, *_: object) -> Path:
        if order.name == "a":
            raise KeyError("lost")
        return order.out

    monkeypatch.setattr(stills, "sheet", sheet)
    code, out, err = pronk("sheet", "a", "d")
    assert (code, out) == (4, "out\n")
    assert "error: a.yaml: a defect of pronk, please report it: KeyError('lost')" in err


def test_an_interrupt_ends_all_and_the_table_tells_what_is_done(
    pronk: Pronk, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    step = Simulation.step

    def interrupted(simulation: Simulation) -> None:
        if "out/d" in str(sorted(folder.glob("out/*"))):
            raise KeyboardInterrupt
        step(simulation)

    monkeypatch.setattr(Simulation, "step", interrupted)
    code, out, err = pronk("simulate", "a", "d", "wrong")
    assert (code, len(out.splitlines())) == (130, 1)
    *lines, last = err.splitlines()
    rows = table_of("\n".join(lines))
    assert [row.split()[-1] for row in rows.values()] == ["done", "stopped", "started"]
    assert last == "stopped; the same command keeps what is finished and goes on"


def test_an_interrupt_behind_another_error_ends_all() -> None:
    worked: list[str] = []

    def work(name: str, reporter: Reporter) -> None:
        worked.append(name)
        raise ValueError("torn") from KeyboardInterrupt()

    with pytest.raises(ValueError, match="torn"):
        run_batch(["one", "two"], work, Reporter(), lambda *_: None, find=Path)
    assert worked == ["one"]


TROUPES = """\
pronk: 1
duration: 1
cast:
  - {name: bug, figure: beetle, walk: {gait: tripod, stride: 50, speed: 0.9}}
  - {name: bee, figure: beetle, at: [1, 1], walk: {gait: tripod, body_height: 9}}
  - {name: roo, figure: kangaroo, at: [2, 1], pronk: {distance: 9, height: 0.001, speed: 100}}
light: studio
"""


def test_check_tells_what_none_of_several_performers_can_do(pronk: Pronk, folder: Path) -> None:
    (folder / "many.yaml").write_text(TROUPES)
    code, out, err = pronk("check", "many")
    assert (code, out) == (3, "")
    for place in ("many.yaml:4:", "many.yaml:5:", "many.yaml:6:"):
        assert place in err


def test_check_tells_of_all_creatures_without_foothold(pronk: Pronk, folder: Path) -> None:
    text = (folder / "fail.yaml").read_text()
    (folder / "fail.yaml").write_text(
        text.replace("materials:", "  - {name: bee, figure: beetle, walk: {}}\nmaterials:")
    )
    code, _, err = pronk("check", "fail")
    assert code == 3
    for place in ("cast[0].at: leg l1 of 'bug' finds no", "cast[1].at: leg l1 of 'bee' finds no"):
        assert place in err
