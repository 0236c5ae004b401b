"""Harmony: note names, scales, and chords near a pitch."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.harmony import CHORD_KINDS, MODES, parse_chord, parse_note, parse_scale, parse_steps
from tests.audio.conftest import is_on_scale

ROOTS = ("C", "C#", "Db", "D", "Eb", "E", "F", "F♯", "G", "Ab", "A", "B♭", "B")


@pytest.mark.parametrize(
    ("name", "pitches"),
    [
        ("C", (60, 64, 67)),
        ("Am7", (57, 60, 64, 67)),
        ("F#maj7", (54, 58, 61, 65)),
        ("Bbm", (58, 61, 65)),
        ("Gmin7", (55, 58, 62, 65)),
        ("D-", (62, 65, 69)),
        ("E+", (64, 68, 72)),
        ("Bm7b5", (59, 62, 65, 69)),
        ("C9", (60, 64, 67, 70, 74)),
    ],
)
def test_a_chord_has_its_root_nearest_to_a_pitch(name, pitches):
    assert parse_chord(name).near(60) == pitches


@given(st.sampled_from(ROOTS), st.sampled_from(sorted(CHORD_KINDS)), st.integers(0, 127))
def test_every_chord_is_within_midi_range_near_its_pitch_and_on_its_scale(root, kind, pitch):
    chord = parse_chord(root + kind)
    pitches = chord.near(pitch)
    assert pitches == tuple(sorted(set(pitches)))
    assert 0 <= pitches[0]
    assert pitches[-1] <= 127
    assert (pitches[0] - chord.root) % 12 == 0
    if 12 <= pitch <= 100:
        assert abs(pitches[0] - pitch) <= 6
    scale = parse_steps(root + kind)
    assert all(is_on_scale(each, scale) for each in pitches)
    assert len(scale.intervals) == len({each % 12 for each in pitches})


def test_text_that_is_no_chord_is_parsed_as_a_scale():
    assert parse_steps("A dorian") == parse_scale("A dorian")
    assert parse_steps("chromatic") == parse_scale("chromatic")


@given(st.integers(0, 127))
def test_note_names_count_semitones_from_c_minus_1(pitch):
    names = ("C", "C#", "D", "Eb", "E", "F", "F#", "G", "Ab", "A", "Bb", "B")
    assert parse_note(f"{names[pitch % 12]}{pitch // 12 - 1}") == pitch


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("root", ROOTS)
def test_degrees_ascend_and_invert(root, mode):
    scale = parse_scale(f"{root} {mode}")
    pitches = [scale.pitch(degree) for degree in range(60)]
    assert pitches == sorted(set(pitches))
    assert pitches[0] == scale.root
    assert all(is_on_scale(pitch, scale) for pitch in pitches)
    assert [scale.degree(pitch) for pitch in pitches] == list(range(60))


def test_c_minor_pentatonic_has_its_pitches():
    scale = parse_scale("C minor pentatonic")
    assert [p for p in range(60, 72) if is_on_scale(p, scale)] == [60, 63, 65, 67, 70]
