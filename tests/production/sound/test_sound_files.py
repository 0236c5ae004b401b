"""Files beside MIDI and WAV, checked by independent readers: tables, labels, edit lists."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
import wave
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest
import symusic

from audio.config.sound import Sound
from audio.score import Marker, Score, ScoreEvent
from pipeline.errors import SceneError
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.production import score_only
from pipeline.production.run.progress import Reporter
from pipeline.production.sound.cue_files import (
    audacity_labels,
    edit_list,
    timecode,
    timecode_base,
    write_cues,
)
from pipeline.production.sound.event_files import events_csv, events_jsonl
from pipeline.production.sound.score_builder import film_markers
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import OrderRecord, Take
from render.shot import CameraPose
from tests.audio.soundfont_writer import sf2

if TYPE_CHECKING:
    from pathlib import Path

    from tests.production.conftest import Studio

NTSC = [Fraction(n * 1000, 1001) for n in (24, 30, 60)]
RATES = [Fraction(n) for n in (24, 25, 30, 48, 50, 60)] + NTSC
AHEAD = CameraPose((0.0, 0.0, 0.0), (0.0, 0.0, -5.0))


def event(frame: int, **fields: object) -> ScoreEvent:
    return replace(ScoreEvent(frame, Fraction(0), "footfall", "Käfer", "l1", "terrain"), **fields)  # type: ignore[arg-type]


def scored(events: tuple[ScoreEvent, ...] = (), **fields: object) -> Score:
    facts: dict[str, object] = {"rate": Fraction(24), "frames": 240, "sound": Sound(), **fields}
    return Score(events=events, **facts)  # type: ignore[arg-type]


# --- events ------------------------------------------------------------------------


def test_csv_and_json_lines_agree(take: Take) -> None:
    named = tuple(replace(e, who='Käfer "甲", 1') for e in take.events)
    renamed = replace(take, events=named)
    lines = [json.dumps(json.loads(line)) for line in events_jsonl(renamed).splitlines()]
    rows = list(csv.DictReader(io.StringIO(events_csv(renamed).decode(), newline="")))
    assert len(rows) == len(lines) > 0
    for line, row in zip(lines, rows, strict=True):
        record = json.loads(line)
        place = [float(row.pop(axis)) for axis in ("x", "y", "z")]
        assert place == record.pop("place")
        assert row == {name: str(value) for name, value in record.items()}


def test_without_events_the_csv_has_only_its_header(take: Take) -> None:
    none = replace(take, events=())
    assert events_jsonl(none) == b""
    assert events_csv(none).count(b"\n") == 1


def test_a_sustained_event_has_a_duration(take: Take) -> None:
    rolls = replace(take.events[0], track=(4, 22))
    (record,) = map(json.loads, events_jsonl(replace(take, events=(rolls,))).splitlines())
    assert record["duration"] == 18 / 4 / 24


# --- markers -----------------------------------------------------------------------


def test_markers_are_at_the_first_frames_of_cuts_but_not_of_the_film(
    unmade: Studio, take: Take
) -> None:
    cuts = "[{}, {start: 0.05, view: side}, {start: 0.0625, follow: bug, view: top}, {start: 9}]"
    scene = unmade.load(f"camera={cuts}")
    # The second cut is never visible: both start on frame 3 at 24 frames a second.
    assert film_markers(scene, take) == (Marker(3, "cut", "top of bug"),)


def test_markers_are_at_script_instructions_also_after_waits(unmade: Studio) -> None:
    scene = unmade.load(
        "frames=72",
        "cast.bug.walk.path=[[0.2, 0]]",
        "script=[{at: 0.05, who: bug, do: {speed: 0.5}},"
        " {when: {arrived: bug}, who: bug, do: {turn_deg: 90}},"
        " {at: 99, who: bug, do: stop}]",
    )
    take = simulate(scene)
    first, second = film_markers(scene, take)
    assert first == Marker(3, "script", "bug: speed 0.5")
    assert (second.kind, second.text) == ("script", "bug: turn_deg 90")
    assert 3 < second.frame <= 72
    assert [one.text for one in take.orders] == ["speed 0.5", "turn_deg 90"]


SHOWN_AND_LATE = (("stop", 28), ("walk", 29))
"""Instructions, and the steps from which they were given."""


def test_an_instruction_after_the_last_frame_has_no_marker(unmade: Studio, take: Take) -> None:
    late = replace(
        take,
        orders=(
            OrderRecord("bug", "stop", 28, 28, "begun"),
            OrderRecord("bug", "walk", 29, 29, "begun"),
        ),
    )
    assert film_markers(unmade.load(), late) == (Marker(8, "script", "bug: stop"),)


# --- labels ------------------------------------------------------------------------


def test_labels_are_seconds_tab_seconds_tab_text() -> None:
    score = scored(
        (event(25), event(49, cause="roll", duration=0.5, part="", other="")),
        markers=(Marker(13, "cut", "side\tof\nbug"),),
    )
    assert audacity_labels(score).decode() == (
        "0.500000\t0.500000\tcut: side of bug\n"
        "1.000000\t1.000000\tfootfall: Käfer.l1 > terrain\n"
        "2.000000\t2.500000\troll: Käfer\n"
    )


def test_labels_are_at_the_times_of_the_sounds() -> None:
    exact = scored((event(25, time=Fraction(95, 96)),), subframe=True)
    assert audacity_labels(exact).startswith(b"0.989583\t")


def test_muted_events_have_no_label_and_no_locator() -> None:
    score = scored((event(25),), sound=Sound.model_validate({"voices": [{"mute": True}]}))
    assert audacity_labels(score) == b""
    assert b"LOC" not in (edit_list(score, "f.mp4") or b"")


# --- edit lists ----------------------------------------------------------------------


@pytest.mark.sample(1)
@pytest.mark.parametrize("rate", RATES, ids=str)
def test_another_reader_reads_the_edit_list_to_the_frame(rate: Fraction) -> None:
    count = timecode_base(rate)
    assert count is not None
    frames = 3700 * count
    sounds = (1, 2, count, count + 1, 60 * count, 60 * count + 1, 3601 * count, frames)
    cuts = (count * 7, count * 61)
    score = scored(
        tuple(map(event, sounds)),
        rate=rate,
        frames=frames,
        title="Über Stock",
        markers=(
            *(Marker(frame, "cut", "x") for frame in cuts),
            Marker(count * 70, "script", "Käfer: go_to [3, 4]"),
        ),
    )
    text = (edit_list(score, "tiny.mp4") or b"").decode()
    otio = pytest.importorskip("opentimelineio", reason="there is no wheel for this Python")
    timeline = otio.adapters.read_from_string(text, "cmx_3600", rate=count)
    assert timeline.name == "Über Stock"
    (track,) = timeline.tracks
    assert [clip.name for clip in track] == ["tiny.mp4"] * 3
    lengths = [clip.source_range.duration.value for clip in track]
    assert np.cumsum([0, *lengths]).tolist() == [0, *(cut - 1 for cut in cuts), frames]
    marks = [
        (mark.marked_range.start_time.rescaled_to(count).value + 1, mark.color, mark.name)
        for clip in track
        for mark in clip.markers
    ]
    assert [f for f, _, name in marks if name == "footfall: Käfer.l1 > terrain"] == list(sounds)
    assert (count * 70, "GREEN", "script: Käfer: go_to [3, 4]") in marks


def test_timecode_counts_frames() -> None:
    assert timecode(0, 24) == "00:00:00:00"
    assert timecode(86_399 * 25 + 24, 25) == "23:59:59:24"
    for frames in (29, 30, 1799, 1800, 107_999, 108_000):
        hours, minutes, seconds, rest = map(int, timecode(frames, 30).split(":"))
        assert ((hours * 60 + minutes) * 60 + seconds) * 30 + rest == frames


@pytest.mark.parametrize("rate", ["1", "240", "49/2", "120000/1001", "12345/1001"])
def test_rates_without_timecode_have_no_edit_list(rate: str) -> None:
    assert edit_list(scored(rate=Fraction(rate)), "f.mp4") is None


def test_a_film_of_more_than_a_day_has_no_edit_list() -> None:
    day = 24 * 3600 * 2
    assert edit_list(scored(rate=Fraction(2), frames=day), "f.mp4") is not None
    assert edit_list(scored(rate=Fraction(2), frames=day + 1), "f.mp4") is None


def test_an_outdated_edit_list_is_deleted(tmp_path: Path) -> None:
    outputs = Outputs(tmp_path, "f")
    assert write_cues(outputs, scored(), "f.mp4")
    assert not write_cues(outputs, scored(), "f.mp4")
    assert outputs.edit_list.exists()
    assert write_cues(outputs, scored(rate=Fraction(240)), "f.mp4")
    assert not outputs.edit_list.exists()


# --- the command ----------------------------------------------------------------------


def onsets(studio: Studio) -> list[Fraction]:
    """Return the times of the notes [s]."""
    score = symusic.Score.from_midi((studio.made / "tiny.mid").read_bytes())
    tick = Fraction(score.tempos[0].mspq, score.ticks_per_quarter * 1_000_000)
    return sorted(note.time * tick for track in score.tracks for note in track.notes)


def test_subframe_notes_and_sounds_have_the_times_of_their_causes(
    studio: Studio, film: Studio, pronk: Callable[..., tuple[int, str, str]]
) -> None:
    quiet = ("--set", "sound.ambience=none")
    code, _, _ = pronk("midi", studio.scene, "--out", studio.made.parent, "--subframe", *quiet)
    assert code == 0
    lines = (studio.made / "events.jsonl").read_text(encoding="utf-8").splitlines()
    times = {json.loads(line)["time"] for line in lines}
    found = onsets(studio)
    assert {min(times, key=lambda t: abs(t - at)) for at in map(float, found)} == times
    assert all(min(abs(t - float(at)) for t in times) <= 0.5 / 960 for at in found)
    with wave.open(str(studio.made / "tiny.wav")) as file:
        raw = np.frombuffer(file.readframes(file.getnframes()), np.uint8).reshape(-1, 6)
    assert np.flatnonzero(raw.any(axis=1))[0] == round(min(times) * 48_000)
    assert json.loads((studio.made / "manifest.json").read_text())["midi"]["subframe"] is True
    studio.render()
    assert studio.contents() == film.contents()


@pytest.mark.parametrize("fps", ["24", '"30000/1001"', "60"])
def test_a_scene_without_sounds_has_a_silent_score(
    unmade: Studio, tmp_path: Path, fps: str
) -> None:
    studio = unmade.copied(tmp_path / "studio")
    score_only(studio.order(f"fps={fps}", "cast=[{name: bug, figure: beetle}]"), Reporter())
    assert onsets(studio) == []
    assert (studio.made / "events.jsonl").read_bytes() == b""
    assert (studio.made / "tiny_labels.txt").read_bytes() == b""
    assert b"00:00:00:08" in (studio.made / "tiny.edl").read_bytes()


def test_a_rate_without_timecode_is_noted_once(
    unmade: Studio, tmp_path: Path, pronk: Callable[..., tuple[int, str, str]]
) -> None:
    studio = unmade.copied(tmp_path / "studio")
    code, _, err = pronk("midi", studio.scene, "--out", studio.made.parent, "--set", "fps=240")
    assert code == 0
    assert err.count("no edit list") == 1
    assert not (studio.made / "tiny.edl").exists()
    assert all(at * 240 == int(at * 240) for at in onsets(studio))


@pytest.mark.skipif(
    importlib.util.find_spec("tinysoundfont") is None, reason="tinysoundfont is not installed"
)
def test_a_soundfont_that_fails_while_it_plays_is_an_error_of_the_scene(
    unmade: Studio, tmp_path: Path
) -> None:
    studio = unmade.copied(tmp_path / "studio")
    font = studio.folder / "a.sf2"
    font.write_bytes(sf2(np.sin(np.arange(400))))
    text = studio.scene.read_text("utf-8") + "sound: {soundfont: a.sf2}\n"
    studio.scene.write_text(text, "utf-8")
    order = studio.order()
    score_only(order, Reporter())
    before = studio.made.joinpath("tiny.wav").read_bytes()
    damaged = bytearray(font.read_bytes())
    at = damaged.index(b"phdr") + 8 + 24
    damaged[at : at + 2] = b"\xff\x7f"
    # Since it was checked.
    font.write_bytes(damaged)
    with pytest.raises(SceneError, match="crashes its reader") as refused:
        score_only(order, Reporter())
    (problem,) = refused.value.problems
    assert (problem.file, problem.path) == (str(studio.scene), "sound.soundfont")
    assert problem.line == len(text.splitlines())
    assert studio.made.joinpath("tiny.wav").read_bytes() == before
