"""Tempo, meter and bars of the score, and where they come from."""

from __future__ import annotations

import io
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pretty_midi
import pytest
import symusic
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from audio.beat_clock import beat_clock
from audio.config.sound import Sound
from audio.harmony import parse_steps
from audio.key_signature import scale_key
from audio.midi_file import midi_bytes, write_midi
from audio.notes import notes_of
from audio.pulse import fit_pulse
from audio.score import DanceBeat
from audio.tempo_events import MAX_ERROR
from audio.tempo_plan import tempo_plan
from audio.time_grid import tick_grid

NTSC = Fraction(30000, 1001)
MICROSECOND = Fraction(1, 1_000_000)


def grid_of(tempo: float, rate: Fraction, first: Fraction = Fraction(0), **rest: Any) -> Any:
    return tick_grid(rate, beat_clock(Fraction(str(tempo)), first, **rest))


@pytest.mark.parametrize(
    ("tempo", "rate", "frame", "beat"),
    [
        (120, NTSC, 1001, 15000),
        (103, Fraction(24), 103, 1440),
        (120, Fraction(24), 80, 960),
        (90, Fraction(24), 60, 960),
        (120, Fraction(25), 96, 1200),
    ],
)
def test_frames_and_beats_are_both_whole(
    tempo: float, rate: Fraction, frame: int, beat: int
) -> None:
    grid = grid_of(tempo, rate)
    assert (grid.ticks_per_frame, grid.ticks_per_beat) == (frame, beat)
    assert grid.drift == 0


@settings(max_examples=80)
@given(
    tempo=st.floats(10, 480).map(lambda t: round(t, 2)),
    rate=st.sampled_from([Fraction(r) for r in (10, 12, 24, 25, 30, 60)] + [NTSC]),
    first=st.integers(0, 100),
    frames=st.integers(200, 200_000),
)
def test_the_time_that_follows_from_the_file_is_near_that_of_the_film(
    tempo: float, rate: Fraction, first: int, frames: int
) -> None:
    grid = grid_of(tempo, rate, first / rate)
    end = grid.tick(frames + 1)
    track = grid.tempo_track(end)
    assert 1 <= grid.ticks_per_beat <= 32_767
    assert all(1 <= event.microseconds < 2**24 for event in track.events)
    # After the pickup all frames are whole ticks.
    for frame in (first + 1, first + 2, (first + frames) // 2 + 1, frames + 1):
        exact = grid.bar_line + (frame - 1 - first) * grid.ticks_per_frame
        assert grid.tick(frame) == exact
        assert grid.seconds(grid.tick(frame)) == (frame - 1) / rate
        assert grid.frame_at(grid.tick(frame)) == frame
        error = abs(track.seconds(grid.tick(frame)) - (frame - 1) / rate)
        assert error <= (MAX_ERROR + 1) * MICROSECOND
    # Bar 1 is on a bar line: the pickup is a whole number of sixteenths.
    sixteenths = Fraction(4 * grid.bar_line, grid.ticks_per_beat)
    assert abs(sixteenths - round(sixteenths)) <= Fraction(2, grid.ticks_per_beat)
    # A tempo that no division suits is written as the nearest.
    assert abs(grid.drift * Fraction(str(tempo)) / 60) <= Fraction(1, 10_000)


def test_bars_begin_where_the_dance_does(step: Any, score_of: Any, read_smf: Any) -> None:
    score = score_of([step(25), step(41)], 96, sound={"tempo_bpm": 90})
    dance = DanceBeat(Fraction(90), Fraction(1), (3, 4))
    smf = read_smf(midi_bytes(replace(score, dance=dance)))
    # 24 frames are a beat and a half: six sixteenths.
    assert smf.meters == [(0, 3, 8), (1440, 3, 4)]
    ticks = [tick for tick, *_ in smf.onsets()]
    assert ticks[0] == smf.meters[-1][0]
    assert ticks[1] - ticks[0] == smf.division


def test_the_first_bar_is_that_of_the_scene_then_of_the_dance_then_of_the_music(
    step: Any, score_of: Any
) -> None:
    dance = DanceBeat(Fraction(100), Fraction(1, 2))
    for sound, expected in (
        ({"tempo_bpm": 100, "first_bar": 1.0}, Fraction(1)),
        ({"tempo_bpm": 100}, Fraction(1, 2)),
        ({"tempo_bpm": 100, "quantise": {"offset": 0.25}}, Fraction(1, 4)),
        ({}, Fraction(1, 2)),
    ):
        plan = tempo_plan(replace(score_of([step(49)], 96, sound=sound), dance=dance))
        assert plan.clock.spans[0].time == expected
    alone = tempo_plan(score_of([step(49)], 96, sound={"tempo_bpm": 100}))
    assert alone.grid.seconds(alone.grid.bar_line) == Fraction(2)


def test_a_dance_gives_its_tempo_where_the_scene_gives_none(step: Any, score_of: Any) -> None:
    score = replace(score_of([step(25)], 96), dance=DanceBeat(Fraction(72), Fraction(1)))
    plan = tempo_plan(score)
    assert (plan.source, 60 / plan.clock.spans[0].length) == ("dance", 72)


def test_what_counts_beats_has_a_tempo_without_a_word(step: Any, score_of: Any) -> None:
    for sound in ({"quantise": {}}, {"voices": [{"phrase": [0, 2]}]}):
        plan = tempo_plan(score_of([step(1)], sound=sound))
        assert (plan.source, 60 / plan.clock.spans[0].length) == ("scene", 120)
    timed = {"voices": [{"phrase": {"steps": [0, 2], "frames": 3}}]}
    assert tempo_plan(score_of([step(1)], sound=timed)).source == "none"


@pytest.mark.parametrize("tempo", [61.0, 84.5, 103.0, 118.0])
@pytest.mark.parametrize("rate", [Fraction(24), Fraction(25), Fraction(60), NTSC], ids=str)
def test_even_events_have_a_pulse_and_lie_on_its_sixteenths(
    step: Any, score_of: Any, tmp_path: Any, tempo: float, rate: Fraction
) -> None:
    times = [Fraction(1, 3) + k * 60 / Fraction(str(tempo)) for k in range(24)]
    frames = [-(-int(t * rate * 1000) // 1000) + 1 for t in times]
    report = write_midi(score_of([step(f) for f in frames], frames[-1] + 9, rate), tmp_path / "s")
    assert report.tempo.source == "events"
    ratio = float(report.tempo.bpm) / tempo
    assert min(abs(ratio - k) for k in (0.5, 1, 2)) < 0.01
    assert report.tempo.on_grid is not None
    assert report.tempo.on_grid >= 0.95


def test_chance_makes_no_pulse() -> None:
    found = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        frames = np.sort(rng.integers(0, 480, 40))
        found += fit_pulse(frames, Fraction(24)) is not None
    assert found == 0


def test_a_tempo_map_changes_tempo_and_meter_at_bars(
    step: Any, score_of: Any, read_smf: Any, tmp_path: Any
) -> None:
    sound = {
        "tempo_bpm": 120,
        "meter": "3/4",
        "first_bar": 0,
        "tempo_map": [{"bar": 3, "tempo_bpm": 60}, {"bar": 4, "meter": "6/8"}],
    }
    # Bars 1 and 2 last 1.5 s each, bar 3 lasts 3 s.
    score = score_of([step(1), step(37), step(73), step(145)], 240, sound=sound)
    write_midi(score, tmp_path / "score.mid")
    smf = read_smf((tmp_path / "score.mid").read_bytes())
    beat = smf.division
    assert [tick for tick, *_ in smf.onsets()] == [0, 3 * beat, 6 * beat, 9 * beat]
    assert smf.meters == [(0, 3, 4), (9 * beat, 6, 8)]
    assert smf.tempos == [(0, 500_000), (6 * beat, 1_000_000)]
    assert [smf.seconds(tick) for tick, *_ in smf.onsets()] == [0, 1.5, 3, 6]


def test_phrases_and_quantisation_follow_the_tempo_map(step: Any, score_of: Any) -> None:
    changes = [{"bar": 2, "tempo_bpm": 60}]
    sound = {"tempo_bpm": 120, "first_bar": 0, "tempo_map": changes}
    voices = [{"phrase": {"steps": [0, 0], "beats": 1}}]
    for frame, following in ((1, 13), (49, 73)):
        notes = notes_of(score_of([step(frame)], 96, sound={**sound, "voices": voices}))
        assert [note.onset * 24 + 1 for note in notes] == [frame, following]
    drawn = notes_of(score_of([step(57)], 96, sound={**sound, "quantise": {"grid": "1/4"}}))
    assert [note.onset * 24 + 1 for note in drawn] == [49]


def test_other_readers_find_tempo_meter_and_key(step: Any, score_of: Any) -> None:
    sound = {"tempo_bpm": 103, "meter": "3/4", "scale": "A minor pentatonic"}
    data = midi_bytes(score_of([step(1), step(15)], 96, sound=sound))
    read = symusic.Score.from_midi(data)
    assert read.ticks_per_quarter == 1440
    assert (read.time_signatures[0].numerator, read.time_signatures[0].denominator) == (3, 4)
    assert round(60_000_000 / read.tempos[0].mspq) == 103
    assert [(key.key, key.tonality) for key in read.key_signatures] == [(0, 1)]
    other = pretty_midi.PrettyMIDI(io.BytesIO(data))
    assert other.get_tempo_changes()[1][0] == pytest.approx(103, abs=1e-3)
    assert [signature.numerator for signature in other.time_signature_changes] == [3]


@pytest.mark.parametrize(
    ("scale", "key"),
    [
        ("C major", "C"),
        ("A minor pentatonic", "Am"),
        ("D dorian", "Am"),
        ("Eb lydian", "Bb"),
        ("G mixolydian", "C"),
        ("F# blues", "F#m"),
        ("E harmonic minor", "Em"),
        ("Am7", "Am"),
        ("C chromatic", None),
        ("D whole tone", None),
    ],
)
def test_a_scale_has_the_signature_of_its_notes(scale: str, key: str | None) -> None:
    assert scale_key(parse_steps(scale)) == key


def test_a_scale_that_nobody_sets_has_no_signature(step: Any, score_of: Any, read_smf: Any) -> None:
    plain = read_smf(midi_bytes(score_of([step(1)])))
    assert not [kind for track in plain.tracks for _, kind, _ in track if kind == 0xFF59]


@pytest.mark.parametrize(
    ("sound", "message"),
    [
        ({"meter": "4/5"}, "did you mean 4/8"),
        ({"meter": "0/4"}, "no meter"),
        ({"tempo_map": [{"bar": 2, "tempo_bpm": 90}]}, "needs tempo_bpm"),
        ({"tempo_bpm": 90, "tempo_map": [{"bar": 2}]}, "changes nothing"),
        ({"tempo_bpm": 90, "tempo_map": [{"bar": 1, "tempo_bpm": 80}]}, "greater than or equal"),
        (
            {
                "tempo_bpm": 90,
                "tempo_map": [{"bar": 5, "tempo_bpm": 80}, {"bar": 5, "meter": "3/4"}],
            },
            "in their order",
        ),
        ({"first_bar": 1, "quantise": {"offset": 1}}, "conflicts with quantise.offset"),
        ({"first_bar": -1}, "greater than or equal to 0"),
    ],
)
def test_wrong_bars_are_refused(sound: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        Sound.model_validate(sound)
