"""Song files: MIDI files of others on the beats of the scene; broken ones are refused."""

from __future__ import annotations

import io
from fractions import Fraction
from pathlib import Path
from typing import Any

import mido
import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.music.song_file import MAX_NOTES, parse_song
from audio.notes import notes_of
from audio.tempo_plan import tempo_plan
from pipeline.errors import SceneError
from pipeline.foreign_files.safe_file import ForeignFileError
from pipeline.spec import load_scene


def song_bytes(tempos: Any = ((0, 582_524),), kind: int = 1) -> bytes:
    """Return a file of a bass and a drum, four beats long, as mido writes it."""
    file = mido.MidiFile(type=kind, ticks_per_beat=480)
    track = mido.MidiTrack()
    now = 0
    for tick, tempo in tempos:
        track.append(mido.MetaMessage("set_tempo", tempo=tempo, time=tick - now))
        now = tick
    notes = mido.MidiTrack()
    notes.append(mido.Message("program_change", channel=2, program=33))
    notes.append(mido.Message("control_change", channel=2, control=10, value=32))
    for beat, key in enumerate((40, 43, 45, 47)):
        notes.append(mido.Message("note_on", channel=2, note=key, velocity=90))
        notes.append(mido.Message("note_on", channel=9, note=36, velocity=100))
        notes.append(mido.Message("note_off", channel=9, note=36, time=120))
        # Note-on of velocity 0 ends a note, too.
        off = "note_off" if beat % 2 else "note_on"
        notes.append(mido.Message(off, channel=2, note=key, velocity=0, time=360))
    file.tracks += [track, notes] if kind else [notes]
    out = io.BytesIO()
    file.save(file=out)
    return out.getvalue()


def song_score(score_of: Any, data: bytes, sound: Any = None, **fields: Any) -> Any:
    """Return a score of five seconds with a song."""
    config = {"music": {"file": "song.mid", "loop": False}, **(sound or {})}
    return score_of(sound=config, frames=120, song=parse_song(data), **fields)


def test_a_song_has_its_notes_instruments_and_tempo(score_of: Any) -> None:
    song = parse_song(song_bytes())
    assert song.tempo == 103
    score = song_score(score_of, song_bytes())
    plan = tempo_plan(score)
    assert plan.source == "song"
    notes = notes_of(score)
    bass = [note for note in notes if not note.drum]
    assert [(note.pitch, note.program) for note in bass] == [(k, 33) for k in (40, 43, 45, 47)]
    assert [note.onset for note in bass] == [Fraction(60 * beat, 103) for beat in range(4)]
    assert bass[0].pan == pytest.approx(-0.508, abs=0.01)
    assert {note.pitch for note in notes if note.drum} == {36}
    assert {note.event.who for note in notes} == {"music 3 fingered bass", "music 10 drums"}


def test_a_file_of_one_track_is_read() -> None:
    song = parse_song(song_bytes(kind=0))
    # Without a tempo a file has 120 beats a minute.
    assert song.tempo == 120
    assert len(song.notes) == 8


def test_a_song_follows_the_tempo_of_the_scene(score_of: Any) -> None:
    score = song_score(score_of, song_bytes(), {"tempo_bpm": 60, "first_bar": 1})
    onsets = sorted({note.onset for note in notes_of(score)})
    assert onsets == [1, 2, 3, 4]


def test_changes_of_tempo_are_heard_where_the_scene_has_none(score_of: Any) -> None:
    data = song_bytes(((0, 500_000), (960, 1_000_000)))
    onsets = sorted({note.onset for note in notes_of(song_score(score_of, data))})
    assert onsets == [0, Fraction(1, 2), 1, 2]


def test_a_song_loops_at_a_bar(score_of: Any) -> None:
    sound = {"tempo_bpm": 240, "music": {"file": "song.mid"}}
    onsets = sorted({note.onset for note in notes_of(song_score(score_of, song_bytes(), sound))})
    assert onsets == [Fraction(beat, 4) for beat in range(20)]


def header(kind: int = 1, tracks: int = 1, division: int = 480) -> bytes:
    """Return the header of a file."""
    numbers = b"".join(number.to_bytes(2) for number in (kind, tracks, division))
    return b"MThd" + (6).to_bytes(4) + numbers


def track(data: bytes) -> bytes:
    """Return a track of some bytes."""
    return b"MTrk" + len(data).to_bytes(4) + data


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is no MIDI file"),
        (b"\x89PNG" + bytes(40), "is no MIDI file"),
        (header(kind=2), "type 2"),
        (header(division=0xE728), "SMPTE"),
        (header(division=0), "SMPTE"),
        (header(tracks=2000), "has 2000 tracks"),
        (header(), "ends after 0 tracks of 1"),
        (header() + b"MTrk\xff\xff\xff\xff", "ends early"),
        (header() + track(b"\x00\x90\x40"), "ends within an event"),
        (header() + track(b"\x00\x40\x40"), "data without an event"),
        (header() + track(b"\xff\xff\xff\xff\xff"), "more than four bytes"),
        (header() + track(b"\x00\xff\x51\x03\x00\x00\x00"), "a tempo that is none"),
        (header() + track(b"\x00\xf4"), "0xf4"),
        (header() + track(b"\x00\x90\x40\xff"), "cut off"),
        (header() + track(b"\x00\xff\x2f\x00"), "without notes"),
        (header() + track(b"\x00\x90" + b"\x40\x40\x00" * (MAX_NOTES + 2)), "more than"),
    ],
)
def test_a_broken_song_is_refused_in_one_line(data: bytes, message: str) -> None:
    with pytest.raises(ForeignFileError) as error:
        parse_song(data)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@given(st.data())
def test_no_damage_does_more_than_be_refused(draw: Any) -> None:
    data = bytearray(song_bytes())
    for _ in range(draw.draw(st.integers(1, 6))):
        at = draw.draw(st.integers(0, len(data) - 1))
        data[at] = draw.draw(st.integers(0, 255))
    del data[draw.draw(st.integers(1, len(data))) :]
    try:
        song = parse_song(bytes(data))
    except ForeignFileError:
        return
    assert all(note.end > note.tick >= 0 for note in song.notes)


SCENE = "pronk: 1\nduration: 1\ncast: [{figure: beetle, name: bug}]\nsound:\n  music: {file: %s}\n"


def test_a_scene_names_a_song_beside_it(tmp_path: Path) -> None:
    (tmp_path / "song.mid").write_bytes(song_bytes())
    scene = tmp_path / "scene.yaml"
    scene.write_text(SCENE % "song.mid", encoding="utf-8")
    music = load_scene(scene).sound.music
    assert music is not None
    assert music.file == str(tmp_path / "song.mid")
    (tmp_path / "song.mid").write_bytes(b"no song")
    with pytest.raises(SceneError, match=r"'song\.mid' is no MIDI file") as error:
        load_scene(scene)
    assert "scene.yaml:5:" in str(error.value)
    scene.write_text(SCENE % "sung.mid", encoding="utf-8")
    with pytest.raises(SceneError, match=r"'sung\.mid' is no file in"):
        load_scene(scene)
