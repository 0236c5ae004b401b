"""Notes to the author: where they come from, how they are told, and `--strict`."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pipeline.production.run.file_records import content_digest
from pipeline.production.run.film_end import notes_after_end
from pipeline.production.run.notes import MAX_LINES, Note, read_notes, summary
from pipeline.production.run.production import render
from pipeline.production.run.progress import Reporter
from pipeline.spec import read_scene

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.production.conftest import Studio

Pronk = Callable[..., tuple[int, str, str]]

EDGE = """\
pronk: 1
duration: 1
terrain: {kind: flat, size: [2.5, 2.5], cells: [10, 10]}
cast:
  - {name: bug, figure: beetle, scale: 0.6, walk: {gait: tripod, cycle: 0.3, speed: 0.9}}
script:
  - {at: 9, who: bug, do: stop}
light: studio
film: {size: [64, 36], samples: 1, depth: 2, denoise: "off"}
"""

STOPPED = Note("stopped", "simulation", "bug.l1", 2.125, 52, "no foothold ahead")
DARK = Note("black", "picture", "picture", 0.0, 1, "no pixel is brighter than 1%")


@pytest.fixture
def edge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a scene on which there are two notes, and one without."""
    (tmp_path / "edge.yaml").write_text(EDGE)
    wide = EDGE.replace("[2.5, 2.5]", "[9, 9]").replace("at: 9", "at: 0.5")
    (tmp_path / "wide.yaml").write_text(wide)
    monkeypatch.chdir(tmp_path)
    return tmp_path


class Recording(Reporter):
    """Keeps the notes."""

    def __init__(self) -> None:
        self.told: list[Note] = []

    def notes(self, scene: str, notes: Sequence[Note], manifest: Path | None) -> None:
        """Keep them."""
        self.told += notes


# --- the summary ------------------------------------------------------------------


def test_a_line_says_what_happened_to_whom_and_when() -> None:
    assert summary([STOPPED]) == ["bug.l1 stopped at 2.1 s: no foothold ahead"]
    lost = replace(STOPPED, kind="order_given_up", part="kid", text="could not grab ball: too wide")
    assert summary([lost]) == ["kid at 2.1 s: could not grab ball: too wide"]


def test_equal_notes_have_one_line() -> None:
    parts = [replace(STOPPED, part=f"bug.l{i}", seconds=float(i)) for i in range(1, 6)]
    (line,) = summary(parts)
    assert line == "bug.l1, bug.l2, bug.l3 and 2 more stopped from 1.0 s on: no foothold ahead"
    (line,) = summary([STOPPED, replace(STOPPED, seconds=3.0)])
    assert line == "bug.l1 stopped from 2.1 s on, 2 times: no foothold ahead"


def test_more_than_ten_lines_are_counted() -> None:
    notes = [replace(STOPPED, text="reason " + "abcdefghijklmnopqrst"[i // 2]) for i in range(40)]
    lines = summary(notes, "out/a/manifest.json")
    assert len(lines) == MAX_LINES == 10
    assert lines[-1] == "and 22 more in out/a/manifest.json"
    assert len(summary(notes[:20])) == MAX_LINES


def test_the_manifest_gives_notes_back_and_skips_lines_of_earlier_versions() -> None:
    placed = replace(STOPPED, place="edge.yaml:7")
    entries = json.loads(json.dumps([STOPPED.facts, placed.facts]))
    assert read_notes(["bug: stopped at step 3: why", *entries, {"kind": "x"}]) == [STOPPED, placed]
    assert read_notes(None) == []


# --- runs -------------------------------------------------------------------------


def test_a_run_tells_its_notes_again_when_the_take_is_up_to_date(pronk: Pronk, edge: Path) -> None:
    told = [
        "edge: 2 notes",
        "  edge.yaml:7: bug: stop: never given; the film ends at 1 s",
        "  bug.l1 stopped at 0.3 s: no foothold ahead, at [0.73, 0.00]",
    ]
    for _ in range(2):
        code, _, err = pronk("simulate", "edge")
        assert code == 0
        assert err.splitlines()[-3:] == told
    manifest = json.loads((edge / "out/edge/manifest.json").read_text())
    never, stopped = manifest["notes"]
    assert (never["kind"], never["source"], never["place"]) == (
        "order_never_given",
        "scene",
        "edge.yaml:7",
    )
    assert (stopped["kind"], stopped["part"], stopped["frame"]) == ("stopped", "bug.l1", 8)
    assert stopped["seconds"] == pytest.approx(28 / 96, abs=1e-3)


def test_a_run_without_notes_tells_none(pronk: Pronk, edge: Path) -> None:
    code, _, err = pronk("simulate", "wide", "--strict")
    assert code == 0
    assert "note" not in err
    assert json.loads((edge / "out/wide/manifest.json").read_text())["notes"] == []


def test_json_has_a_line_with_a_kind_for_each_note(pronk: Pronk, edge: Path) -> None:
    lines = [json.loads(line) for line in pronk("simulate", "edge", "--json")[1].splitlines()]
    notes = [line for line in lines if line["event"] == "note" and "kind" in line]
    assert [(n["kind"], n["source"], n["scene"]) for n in notes] == [
        ("order_never_given", "scene", "edge"),
        ("stopped", "simulation", "edge"),
    ]


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("command", [("midi",), ("simulate",), ("render",)], ids=lambda c: c[0])
def test_strict_stops_after_the_simulation_and_leaves_earlier_outputs(
    pronk: Pronk, edge: Path, command: tuple[str, ...]
) -> None:
    (edge / "edge.yaml").write_text(EDGE.replace("[2.5, 2.5]", "[9, 9]").replace("at: 9", "at: 0"))
    assert pronk("simulate", "edge", "--strict")[0] == 0
    manifest = edge / "out/edge/manifest.json"
    entries = json.loads(manifest.read_text())
    made = [p for p in (edge / "out").rglob("*") if p.is_file() and p != manifest]
    files = {p: p.read_bytes() for p in made}
    (edge / "edge.yaml").write_text(EDGE)
    code, out, err = pronk(*command, "edge", "wide", "--strict", "--set", "seed=4", "-q")
    assert (code, out) == (1, "")
    assert err.splitlines()[0] == "error: edge.yaml: 2 notes, and --strict allows none"
    assert "  bug.l1 stopped at 0.3 s: no foothold ahead, at [0.73, 0.00]" in err
    assert {p: p.read_bytes() for p in files} == files
    new = {path.name for path in (edge / "out/edge").iterdir()} - {path.name for path in files}
    assert new == {"take.zarr", "take_refused.zarr", "manifest.json"}
    after = json.loads(manifest.read_text())
    after["files"].pop("take_refused.zarr")
    assert {**after, "seal": ""} == {**entries, "seal": ""}
    assert (edge / "out/wide/take.zarr").exists()


def test_a_refused_take_is_not_simulated_again(pronk: Pronk, edge: Path) -> None:
    made = edge / "out/edge"
    for _ in range(2):
        code, _, err = pronk("simulate", "edge", "--strict")
        assert code == 1
        assert {path.name for path in made.iterdir()} == {"take_refused.zarr", "manifest.json"}
        record = json.loads((made / "manifest.json").read_text())["files"]["take_refused.zarr"]
        assert record["digest"] == content_digest(made / "take_refused.zarr")
    assert "take is up to date" in err
    code, _, err = pronk("simulate", "edge")
    assert code == 0
    assert "take is up to date" in err
    names = {path.name for path in made.iterdir()}
    assert names == {"take.zarr", "events.csv", "events.jsonl", "manifest.json"}
    files = json.loads((made / "manifest.json").read_text())["files"]
    assert {*files} == names - {"manifest.json"}


def test_a_damaged_refused_take_is_found_and_made_again(pronk: Pronk, edge: Path) -> None:
    assert pronk("simulate", "edge", "--strict")[0] == 1
    refused = edge / "out/edge/take_refused.zarr"
    digest = content_digest(refused)
    for path in refused.rglob("*"):
        if path.is_file() and path.suffix != ".json":
            path.write_bytes(path.read_bytes()[:-1] + b"x")
    code, _, err = pronk("verify", "edge")
    assert code == 1
    assert "take_refused.zarr: is not as it was written" in err
    code, _, err = pronk("simulate", "edge", "--strict")
    assert code == 1
    assert "; it is made again" in err
    assert content_digest(refused) == digest


def test_strict_refuses_a_stored_take_too(pronk: Pronk, edge: Path) -> None:
    assert pronk("simulate", "edge")[0] == 0
    code, out, _ = pronk("midi", "edge", "--strict", "--json")
    error = json.loads(out.splitlines()[-1])
    assert (code, error["event"], error["exit_code"]) == (1, "error", 1)
    assert [note["kind"] for note in error["notes"]] == ["order_never_given", "stopped"]
    assert not (edge / "out/edge/edge.mid").exists()


@pytest.mark.nightly
def test_check_simulates_only_if_asked(pronk: Pronk, edge: Path) -> None:
    quick, through = pronk("check", "edge")[2], pronk("check", "edge", "--simulate")[2]
    assert "never given" in quick
    assert "stopped" not in quick
    assert "bug.l1 stopped at 0.3 s" in through
    assert pronk("check", "edge", "wide", "--simulate", "--strict")[0] == 1
    assert pronk("check", "wide", "--simulate", "--strict")[0] == 0
    assert not (edge / "out").exists()


def test_notes_on_pictures_stay_until_a_run_tells_them_anew(studio: Studio) -> None:
    manifest = studio.made / "manifest.json"
    entries = json.loads(manifest.read_text())
    second = replace(DARK, frame=2, seconds=0.042)
    entries["notes"] = [DARK.facts, second.facts, replace(DARK, frame=99).facts]
    manifest.write_text(json.dumps(entries))
    reporter = Recording()
    render(studio.order(frames="2-3"), reporter)
    assert reporter.told == []
    assert read_notes(json.loads(manifest.read_text())["notes"]) == [DARK]
    render(studio.order(frames="1-2"), reporter)
    assert reporter.told == []
    assert read_notes(json.loads(manifest.read_text())["notes"]) == []


# --- what begins when the film is over --------------------------------------------

SCENE = """\
pronk: 1
duration: 2
cast:
  - {name: bug, figure: beetle, walk: {}}
  - name: lamp
    prop: {shape: box, size: [1, 1, 1]}
    keyframes:
      - {at: 0, position: [0, 1, 0]}
      - {at: 3, position: [1, 1, 0]}
      - {at: 3, scale: 2}
      - {at: 4, position: [0, 1, 0]}
      - {at: 5, position: [0, 1, 0], ease: hold}
  - name: cup
    prop: {shape: ball, radius: 0.1}
    held:
      - {by: bug.l1, at: 1, until: 1.5}
      - {by: bug.l1, at: 2.5}
script:
  - {at: 1.99, who: bug, do: stop}
  - {at: 1.97, who: bug, do: walk}
  - {when: {arrived: bug}, who: bug, do: walk}
camera:
  - {follow: bug}
  - {start: 1.95, follow: bug}
  - {start: 1.96, follow: bug}
"""


def test_what_begins_after_the_end_is_told_with_its_line() -> None:
    notes = notes_after_end(read_scene(SCENE))
    lines = SCENE.splitlines()
    told = {lines[int(note.place.split(":")[1]) - 1].strip(): note.kind for note in notes}
    assert told == {
        "- {at: 4, position: [0, 1, 0]}": "never_begins",
        "- {at: 5, position: [0, 1, 0], ease: hold}": "never_begins",
        "- {by: bug.l1, at: 2.5}": "never_begins",
        "- {at: 1.99, who: bug, do: stop}": "order_never_given",
        "- {start: 1.96, follow: bug}": "never_begins",
    }
    assert {note.frame for note in notes} == {None}


POSES = """\
pronk: 1
duration: 2
cast:
  - name: bug
    figure: beetle
    pose:
      - {at: 1, limb: l1, reach: [0.5, 0.1, -0.3]}
      - {at: 3, limb: l1, reach: [0.5, 0.2, -0.3]}
      - {at: 4, limb: l1, reach: [0.5, 0.1, -0.3]}
      - {at: 2.4, limb: r1, reach: [0.5, 0.1, 0.3], blend: 0.5}
      - {at: 2.6, limb: r2, reach: [0.5, 0.1, 0.3], blend: 0.5}
      - {at: 5, release: l1, blend: 4}
"""


def test_poses_begin_at_the_key_before_or_with_their_blend() -> None:
    keys = sorted(POSES.splitlines()[6:], key=lambda line: float(line.split()[2].strip(",")))
    text = "\n".join([*POSES.splitlines()[:6], *keys])
    lines = text.splitlines()
    notes = notes_after_end(read_scene(text))
    times = [lines[int(note.place.split(":")[1]) - 1].split()[2] for note in notes]
    assert times == ["2.6,", "4,", "5,"]


@pytest.mark.parametrize(
    ("member", "part"),
    [
        ("{name: roo, figure: kangaroo, pronk: {start: 2}}", "roo: pronk"),
        ("{name: eve, dancer: torso, start: 2.5}", "eve: dance"),
    ],
)
def test_a_start_after_the_end_is_told(member: str, part: str) -> None:
    text = f"pronk: 1\nduration: 2\ncast:\n  - {member}\n"
    (note,) = notes_after_end(read_scene(text))
    assert (note.part, note.place, note.kind) == (part, "scene:4", "never_begins")
    assert not notes_after_end(read_scene(text.replace("start: 2", "start: 1")))
