"""Chords: names, places, and the scales that they are."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from audio.config.sound import Sound
from audio.harmony import CHORD_KINDS, parse_chord, parse_scale, parse_steps
from audio.notes import notes_of

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
def test_a_chord_stands_on_its_root_nearest_to_a_pitch(name, pitches):
    assert parse_chord(name).near(60) == pitches


@given(st.sampled_from(ROOTS), st.sampled_from(sorted(CHORD_KINDS)), st.integers(0, 127))
def test_every_chord_is_within_midi_near_its_pitch_and_is_its_own_scale(root, kind, pitch):
    chord = parse_chord(root + kind)
    pitches = chord.near(pitch)
    assert pitches == tuple(sorted(set(pitches)))
    assert 0 <= pitches[0]
    assert pitches[-1] <= 127
    assert (pitches[0] - chord.root) % 12 == 0
    if 12 <= pitch <= 100:
        assert abs(pitches[0] - pitch) <= 6
    scale = parse_steps(root + kind)
    assert all(scale.contains(each) for each in pitches)
    assert len(scale.intervals) == len({each % 12 for each in pitches})


def test_what_is_no_chord_is_read_as_a_scale():
    assert parse_steps("A dorian") == parse_scale("A dorian")
    assert parse_steps("chromatic") == parse_scale("chromatic")


@pytest.mark.parametrize(
    ("words", "place", "hint"),
    [
        ({"chord": "Amj7"}, ("chord",), "did you mean 'Amaj7'"),
        ({"chord": "Hm"}, ("chord",), "roots: C, C#"),
        ({"chord": "A minor"}, ("chord",), "without a space"),
        ({"scale": "Am77"}, ("scale",), "did you mean 'Am7'"),
        ({"drum": "maracas", "chord": "Am"}, (), "a drum has one pitch; leave out chord"),
        ({"drum": "maracas", "octave": 1}, (), "leave out octave"),
        ({"chord": "Am", "phrase": [0, 1]}, (), "either chord or phrase"),
    ],
)
def test_a_wrong_chord_is_refused_once_at_its_place(words, place, hint):
    with pytest.raises(ValidationError) as caught:
        Sound.model_validate({"voices": [words]})
    (error,) = caught.value.errors()
    assert error["loc"] == ("voices", 0, *place)
    assert hint in error["msg"]


def test_a_voice_with_a_chord_strikes_it_at_once_as_loud_as_one_note(step, score_of):
    (plain,) = notes_of(score_of([step()], sound={"voices": [{"pitch": 57}]}))
    notes = notes_of(score_of([step()], sound={"voices": [{"pitch": 57, "chord": "Am7"}]}))
    assert [note.pitch for note in notes] == [57, 60, 64, 67]
    assert {note.onset for note in notes} == {plain.onset}
    assert [note.is_first for note in notes] == [True, False, False, False]
    assert sum(10 ** (n.level / 10) for n in notes) == pytest.approx(10 ** (plain.level / 10))
    assert all(note.tuned for note in notes)


def test_feet_climb_through_a_chord_and_performers_sit_in_octaves_of_their_own(step, score_of):
    voices = [
        {"when": {"who": "cow"}, "scale": "Am7", "pitch": "by foot from A2"},
        {"when": {"who": "bug"}, "scale": "Am7", "pitch": "by foot from A2", "octave": 2},
        {"pitch": "by foot from A2", "scale": "Am7", "octave": -1, "transpose": 7},
    ]
    feet = ("l1", "l2", "r1", "r2", "r3")
    events = [step(1, who=who, part=foot) for who in ("cow", "bug", "ant") for foot in feet]
    notes = notes_of(score_of(events, sound={"voices": voices}))
    pitches = {who: [n.pitch for n in notes if n.event.who == who] for who in ("cow", "bug", "ant")}
    assert pitches["cow"] == [45, 48, 52, 55, 57]
    assert pitches["bug"] == [69, 72, 76, 79, 81]
    assert pitches["ant"] == [40, 43, 47, 50, 52]


@given(
    st.lists(st.floats(0.01, 3), min_size=1, max_size=10),
    st.sampled_from(["chitin", "steel", "ice", "rubber", "bone", "stone"]),
)
def test_up_to_two_octaves_of_feet_have_a_pitch_each_whatever_their_sizes(
    step, score_of, sizes, material
):
    events = [
        step(1, part=f"foot_{i}", size=size, material=material) for i, size in enumerate(sizes)
    ]
    notes = notes_of(score_of(events))
    assert len({note.pitch for note in notes}) == len(sizes)
