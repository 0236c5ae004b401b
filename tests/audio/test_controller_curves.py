"""Controller curves: pitch bend and expression follow the speed of a sustained sound."""

from fractions import Fraction
from math import log2

import pytest
import symusic
from hypothesis import given
from hypothesis import strategies as st

from audio.controller_curves import controller_curve
from audio.loudness_at_listener import loudness_db
from audio.midi_file import midi_bytes, write_midi
from audio.time_grid import tick_grid

GRID = tick_grid(Fraction(24))


def rolls(step, speeds, frame=1, **fields):
    return step(
        frame, cause="roll", strength=max(speeds), duration=1.0, speeds=tuple(speeds), **fields
    )


def curves(track):
    """Return bends [semitones] and expressions by frame, as symusic reads them."""
    bends = {bend.time // 40: 12 * bend.value / 8192 for bend in track.pitch_bends}
    fades = {c.time // 40: c.value for c in track.controls if c.number == 11}
    return bends, fades


def test_half_the_speed_is_half_an_octave_lower_and_as_soft_as_its_impact(step, score_of):
    happened = rolls(step, [2.0, 1.0, 0.5])
    (track,) = symusic.Score.from_midi(midi_bytes(score_of([happened]))).tracks
    bends, fades = curves(track)
    assert bends[0] == 0
    assert bends[12] == pytest.approx(-6, abs=0.1)
    assert bends[23] == pytest.approx(12 * log2(0.5 + 0.5 / 12) / 2 - 6, abs=0.1)
    assert fades[0] == 127
    softer = loudness_db(rolls(step, [1.0])) - loudness_db(happened)
    assert 40 * log2(fades[12] / 127) * 0.30103 == pytest.approx(softer, abs=0.1)


def test_a_curve_starts_with_its_note_relative_to_the_top_speed(step, score_of, read_smf):
    smf = read_smf(midi_bytes(score_of([rolls(step, [0.25, 1.0])])))
    voice = [(t, status & 0xF0, data) for t, status, data in smf.tracks[1] if status < 0xFF00]
    onset = next(i for i, (_, kind, _) in enumerate(voice) if kind == 0x90)
    before = [(kind, data[0]) for _, kind, data in voice[:onset]]
    # Program, the bend range of twelve semitones, pan, reverb, then bend and expression.
    assert before == [
        (0xC0, 122),
        *((0xB0, number) for number in (101, 100, 6, 38, 101, 100)),
        (0xB0, 10),
        (0xB0, 91),
        (0xE0, 0),
        (0xB0, 11),
    ]
    assert next(data[1] for _, kind, data in voice if (kind, data[0]) == (0xB0, 6)) == 12
    assert voice[onset - 2][2] == bytes([0, 0]), "an octave below"


def test_the_note_after_a_curve_has_reset_controllers(step, score_of, read_smf, check_laws):
    happened = [rolls(step, [2.0, 0.1]), step(60, cause="roll", strength=2.0)]
    smf = read_smf(midi_bytes(score_of(happened, 72)))
    check_laws(smf, 72, Fraction(24))
    at_59 = [(s & 0xF0, data) for t, s, data in smf.tracks[1] if t == 59 * 40 and s < 0xFF00]
    assert at_59[:2] == [(0xE0, bytes([0, 64])), (0xB0, bytes([11, 127]))]
    assert {s & 15 for _, s, _ in smf.tracks[1] if s < 0xFF00} == {0}


def test_rolls_of_one_part_at_once_lose_their_curves_but_with_mpe(
    step, score_of, read_smf, check_laws, tmp_path
):
    happened = [rolls(step, [1.0, 0.3], part=f"p{i}", size=0.05 + i / 10) for i in range(16)]
    path = tmp_path / "rolls.mid"
    for sound, lost in (({}, 11), ({"mpe": True}, 2)):
        report = write_midi(score_of(happened, 48, sound=sound), path)
        check_laws(read_smf(path.read_bytes()), 48, Fraction(24), drums=bool(sound))
        assert report.losses.without_curve == lost
        assert report.notes + len(report.losses.merged) == 16


@given(
    st.lists(st.floats(0, 1e300), max_size=30).map(tuple),
    st.floats(0, 5),
    st.integers(0, 1000),
    st.integers(1, 2000),
)
def test_any_curve_is_valid_and_within_its_note(step, speeds, duration, start, length):
    event = step(1, speeds=speeds, duration=duration)
    points = controller_curve(event, GRID, start, start + length)
    assert [m.tick for m in points] == sorted({m.tick for m in points})
    assert all((m.tick - start) % 40 == 0 for m in points)
    assert all(start <= m.tick < start + length for m in points)
    assert all(-8192 <= m.bend <= 0 and 1 <= m.expression <= 127 for m in points)
    assert bool(points) == (len(speeds) > 1 and max(speeds) > 0 and duration > 0)


def test_a_constant_speed_gives_one_point(step):
    event = step(1, speeds=(0.7,) * 9, duration=2.0)
    (point,) = controller_curve(event, GRID, 0, 1920)
    assert (point.bend, point.expression) == (0, 127)
