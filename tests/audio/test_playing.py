"""Swing, sustain pedal and slides of music: in the file, exact, and in the sound."""

from __future__ import annotations

import io
from fractions import Fraction
from pathlib import Path
from typing import Any

import mido
import numpy as np
import pytest
from pydantic import ValidationError

from audio.config.sound import Sound
from audio.controller_curves import bend_curve
from audio.dsp import Signal
from audio.instruments.bent_tone import bent, read_seconds
from audio.layouts import STEREO
from audio.midi_file import midi_bytes, write_midi
from audio.music.piece import Bar
from audio.music.song_file import parse_song
from audio.music.swing import Swing
from audio.music_mix import mix_music
from audio.notes import Note, notes_of
from audio.tempo_plan import tempo_plan
from audio.time_grid import SAMPLE_RATE

PEDAL = 64


def music(line: Any, section: dict[str, Any] | None = None, **words: Any) -> dict[str, Any]:
    """Return the sound of a piano that plays a line at 120 beats a minute."""
    return {
        "tempo_bpm": 120,
        "scale": "C major",
        "music": {
            "parts": {"lead": {"instrument": "acoustic grand piano", "gate": 0.5}},
            "sections": {"a": {"play": {"lead": line}, **(section or {})}},
            **words,
        },
    }


def played(score: Any) -> list[Note]:
    """Return the notes of the music in the order of time."""
    return sorted((n for n in notes_of(score) if n.is_music), key=lambda n: (n.onset, n.pitch))


def beats(score: Any) -> list[Fraction]:
    return [note.onset * 2 for note in played(score)]


def messages(score: Any) -> list[tuple[int, mido.Message]]:
    """Return the messages of the track of the music with their ticks."""
    *_, track = mido.MidiFile(file=io.BytesIO(midi_bytes(score)), charset="utf-8").tracks
    now, found = 0, []
    for message in track:
        now += message.time
        found.append((now, message))
    return found


def test_the_second_of_two_eighths_comes_late(score_of: Any) -> None:
    third = Fraction(1, 6)
    swung = beats(score_of(sound=music("0*8", swing=2 / 3), frames=48))
    expected = [k + third * (place == 1) + Fraction(place, 2) for k in range(4) for place in (0, 1)]
    # A tick of this score is 1/960 of a beat or less.
    assert np.allclose(
        [float(beat) for beat in swung], [float(beat) for beat in expected], atol=6e-4
    )
    even = beats(score_of(sound=music("0*8", {"swing": 0.5}, swing=0.66), frames=48))
    assert even == [Fraction(k, 2) for k in range(8)]


def test_swung_notes_last_until_the_next_and_triplets_are_even(score_of: Any) -> None:
    notes = played(score_of(sound=music("[0 1]!2 [0 1 2] 0", swing=0.6), frames=48))
    assert [round(note.seconds * 4, 3) for note in notes] == [0.6, 0.4] * 2 + [0.333] * 3 + [1.0]
    assert [round(float(n.onset * 2), 3) for n in notes[4:7]] == [2.0, 2.333, 2.667]


def test_swing_moves_halves_of_a_step_and_keeps_bars() -> None:
    bars = [Bar(Fraction(0), Fraction(7, 2)), Bar(Fraction(7, 2), Fraction(7, 2))]
    swing = Swing(Fraction(3, 5), Fraction(1, 2))
    moved = [swing.beat(Fraction(k, 4), bars) for k in range(14)]
    assert moved[:5] == [0, Fraction(3, 10), Fraction(3, 5), Fraction(4, 5), 1]
    # The last eighth of seven has no second.
    assert moved[12:] == [3, Fraction(13, 4)]
    assert swing.beat(Fraction(7, 2), bars) == Fraction(7, 2)
    assert moved == sorted(moved)


def test_the_pedal_goes_down_before_its_notes_and_comes_up_at_its_stroke(score_of: Any) -> None:
    score = score_of(sound=music({"notes": "C4 E4 G4 C5", "pedal": "x.xo"}, loop=False), frames=96)
    grid = tempo_plan(score).grid
    beat = grid.ticks_per_beat
    found = messages(score)
    pedal = [(tick, m.value) for tick, m in found if m.is_cc(PEDAL)]
    assert pedal == [(0, 127), (2 * beat, 0), (2 * beat, 127), (3 * beat, 0)]
    kinds = [m.type for tick, m in found if tick == 2 * beat]
    assert kinds.index("control_change") < kinds.index("note_on")
    # Keys are let go where they were, and sound on until the pedal comes up.
    notes = played(score)
    assert [note.seconds for note in notes] == [0.25] * 4
    assert [note.rings for note in notes] == [1.0, 0.5, 0.5, None]
    channels = {m.channel for _, m in found if m.type == "note_on"}
    assert {m.channel for _, m in found if m.is_cc(PEDAL)} == channels


def test_a_key_that_is_struck_again_ends_its_sound_under_the_pedal(score_of: Any) -> None:
    score = score_of(sound=music({"notes": "C4 C4 G4 _", "pedal": "x"}, loop=False), frames=96)
    assert [note.rings for note in played(score)] == [0.5, 1.5, 1.0]
    # It comes up where the section ends.
    end = 4 * tempo_plan(score).grid.ticks_per_beat
    assert [(t, m.value) for t, m in messages(score) if m.is_cc(PEDAL)] == [(0, 127), (end, 0)]


def mixed(score: Any) -> Signal:
    mix = np.zeros((2, score.frames * 2000)).T
    notes = notes_of(score)
    mix_music(mix, score.sound, notes, notes, 1.0, STEREO)
    return np.asarray(mix.mean(axis=1))


def test_the_pedal_is_heard(score_of: Any) -> None:
    line = "C4 ~ ~ ~"
    dry, held = (
        mixed(score_of(sound=music(words, loop=False), frames=48))
        for words in (line, {"notes": line, "pedal": "x"})
    )
    late = slice(SAMPLE_RATE, round(1.5 * SAMPLE_RATE))
    assert np.sqrt(np.mean(held[late] ** 2)) > 5 * np.sqrt(np.mean(dry[late] ** 2))
    assert np.allclose(held[:4800], dry[:4800], atol=0.02 * np.abs(dry).max())


def test_a_slide_bends_one_note_from_pitch_to_pitch(score_of: Any) -> None:
    score = score_of(sound=music("C4>E4>D4 ~", loop=False), frames=96)
    (note,) = played(score)
    assert note.pitch == 60
    found = messages(score)
    grid = tempo_plan(score).grid
    ticks = round(note.seconds * 2 * grid.ticks_per_beat)
    bends = [(tick, message.pitch / 8192 * 12) for tick, message in found if
             message.type == "pitchwheel"]  # fmt: skip
    assert bends[0] == (0, 0.0)
    assert max(value for _, value in bends) == pytest.approx(4.0, abs=0.01)
    assert bends[-1][1] == pytest.approx(2.0, abs=0.01)
    assert all(0 <= tick < ticks for tick, _ in bends)
    steps = np.diff([value for _, value in bends])
    assert np.abs(steps).max() <= 0.11
    # Half-way through its length it has the second pitch.
    assert [v for t, v in bends if t <= ticks // 2][-1] == pytest.approx(4.0, abs=0.01)
    assert [m.value for _, m in found if m.is_cc(6)] == [12]


def test_a_slide_of_degrees_goes_by_the_scale(score_of: Any) -> None:
    (note,) = played(score_of(sound=music("0>2", loop=False), frames=48))
    assert note.bend[-1][1] == 4.0


def test_a_bend_is_heard_as_a_pitch_and_lasts_as_long_as_its_note() -> None:
    t = np.arange(2 * SAMPLE_RATE) / SAMPLE_RATE
    bend = ((0.25, 0.0), (0.75, 7.0))
    held = read_seconds(bend, 1.0)
    # The mean of a power over a line.
    octaves = 7 / 12
    mean = (2**octaves - 1) / (octaves * np.log(2))
    assert held == pytest.approx(0.25 + 0.5 * mean + 0.25 * 2**octaves, abs=2e-3)
    tone = bent(np.sin(2 * np.pi * 440 * t), bend)
    for at, pitch in ((0.1, 440.0), (0.9, 440 * 2 ** (7 / 12))):
        part = tone[round((at - 0.05) * SAMPLE_RATE) : round((at + 0.05) * SAMPLE_RATE)]
        crossings = np.sum((part[1:] >= 0) & (part[:-1] < 0))
        assert crossings / 0.1 == pytest.approx(pitch, abs=12)
    assert bent(tone, ()) is tone


def test_a_bend_has_a_point_at_its_start_and_none_after_its_end() -> None:
    points = bend_curve(((0.5, 0.0), (1.0, -12.0)), 100, 200)
    assert [(point.tick, point.bend) for point in (points[0], points[-1])] == [
        (100, 0),
        (199, -8192),
    ]
    assert bend_curve((), 0, 10) == ()


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"line": "C4>C6"}, "a slide goes at most 12 semitones"),
        ({"line": "C4>"}, "is no note name"),
        ({"line": {"notes": "C4", "pedal": "X"}}, "a pedal has no accent"),
        ({"line": {"notes": "C4", "pedal": "down"}}, "is no step"),
        ({"line": "C4", "swing": 0.9}, "less than or equal to 0.75"),
        ({"line": "C4", "section": {"swing": 0.4}}, "greater than or equal to 0.5"),
        ({"line": "C4", "swing_step": "1/7"}, "1/7"),
    ],
)
def test_wrong_words_are_refused(change: dict[str, Any], part: str) -> None:
    with pytest.raises(ValidationError, match=part):
        Sound.model_validate(music(**change))


def test_drums_have_no_pedal_and_songs_no_swing() -> None:
    kit = {"parts": {"kit": {}}, "sections": {"a": {"play": {"kit": {
        "drums": {"bass drum": "x"}, "pedal": "x"}}}}}  # fmt: skip
    with pytest.raises(ValidationError, match="drums have no pedal"):
        Sound.model_validate({"music": kit})
    with pytest.raises(ValidationError, match="a song swings as it is played"):
        Sound.model_validate({"music": {"file": "song.mid", "swing": 0.6}})


def song() -> bytes:
    """Return a file with a pedal, and a bend of two semitones of a range of four."""
    track = mido.MidiTrack()
    for number, value in ((101, 0), (100, 0), (6, 4), (PEDAL, 127)):
        track.append(mido.Message("control_change", control=number, value=value))
    track.append(mido.Message("note_on", note=60, velocity=90))
    track.append(mido.Message("note_off", note=60, velocity=0, time=480))
    track.append(mido.Message("control_change", control=PEDAL, value=0, time=480))
    track.append(mido.Message("note_on", note=62, velocity=90))
    track.append(mido.Message("pitchwheel", pitch=4096, time=240))
    track.append(mido.Message("note_off", note=62, velocity=0, time=240))
    track.append(mido.Message("pitchwheel", pitch=0))
    file = mido.MidiFile(ticks_per_beat=480, tracks=[track])
    out = io.BytesIO()
    file.save(file=out)
    return out.getvalue()


def test_pedals_and_bends_of_a_song_are_played(score_of: Any, tmp_path: Path) -> None:
    config = {"music": {"file": "song.mid", "loop": False}, "tempo_bpm": 120}
    score = score_of(sound=config, frames=96, song=parse_song(song()))
    held, bent_note = played(score)
    assert (held.seconds, held.rings, held.pedal) == (0.5, 1.0, (0, 1))
    assert bent_note.rings is None
    assert bent_note.bend == ((0.0, 0.0), (0.5, 0.0), (0.5, 2.0))
    found = messages(score)
    beat = tempo_plan(score).grid.ticks_per_beat
    assert [(t, m.value) for t, m in found if m.is_cc(PEDAL)] == [(0, 127), (2 * beat, 0)]
    bends = [(t, m.pitch) for t, m in found if m.type == "pitchwheel"]
    assert bends[-1] == (round(2.5 * beat), 1365)
    assert write_midi(score, tmp_path / "score.mid").notes == 2
