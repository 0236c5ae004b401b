"""Notes of events: voices, pitch rules and chords."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.general_midi import INSTRUMENTS
from audio.harmony import MODES, parse_scale
from audio.notes import notes_of
from tests.audio.conftest import is_on_scale

ROOTS = ("C", "C#", "Db", "D", "Eb", "E", "F", "F♯", "G", "Ab", "A", "B♭", "B")


@given(
    st.sampled_from(ROOTS),
    st.sampled_from(sorted(MODES)),
    st.lists(st.floats(1e-4, 50), min_size=1, max_size=20),
    st.sampled_from(["by size", "by foot", "by part", None]),
)
def test_every_pitch_by_size_or_part_is_in_the_scale(step, score_of, root, mode, sizes, rule):
    scale = f"{root} {mode}"
    voices = [{"pitch": rule}] if rule else []
    events = [step(1, size=size, part=f"foot_{i}") for i, size in enumerate(sizes)]
    notes = notes_of(score_of(events, sound={"scale": scale, "voices": voices}))
    assert len(notes) == len(sizes)
    assert all(is_on_scale(note.pitch, parse_scale(scale)) for note in notes)
    assert all(36 <= note.pitch <= 96 for note in notes)


def test_smaller_parts_have_higher_pitches(step, score_of):
    sizes = (0.8, 0.2, 0.05)
    events = [step(i + 1, cause="collision", size=size) for i, size in enumerate(sizes)]
    pitches = [note.pitch for note in notes_of(score_of(events))]
    assert pitches == sorted(set(pitches))


def test_each_foot_has_its_own_pitch_in_the_order_of_names(step, score_of):
    feet = [f"foot_{i}" for i in (10, 2, 1)]
    notes = notes_of(score_of([step(1, part=foot) for foot in feet]))
    pitch = {note.event.part: note.pitch for note in notes}
    assert pitch["foot_1"] < pitch["foot_2"] < pitch["foot_10"]


def test_the_first_voice_whose_conditions_all_hold_is_used(step, score_of):
    voices = [
        {"when": {"cause": "footfall", "who": "cow"}, "instrument": "tuba"},
        {"when": {"part": "foot_*", "surface": "Dry-Soil"}, "instrument": "celesta", "pitch": 61},
        {"when": {"material": "green chitin"}, "instrument": "koto"},
        {"when": {"who": "ghost"}, "mute": True},
    ]
    events = [
        step(1, who="bug"),
        step(2, who="bug", surface="rock"),
        step(3, who="cow"),
        step(4, who="ghost", part="", material="", surface=""),
        step(5, who="bug.*", part="x", material="oak", surface=""),
    ]
    notes = notes_of(score_of(events, sound={"voices": voices}))
    names = [INSTRUMENTS[note.program] for note in notes]
    assert names == ["celesta", "koto", "tuba", "marimba"]
    assert notes[0].pitch == 61


def test_size_and_strength_ranges_meet_without_a_gap(step, score_of):
    voices = [
        {"when": {"size": {"above": 1}}, "pitch": 36},
        {"when": {"size": {"above": 0.2, "below": 1}, "strength": {"below": 2}}, "pitch": 48},
        {"when": {"strength": {"above": 2}, "other": "terr*"}, "pitch": 60},
        {"when": {"other": "crate"}, "pitch": 72},
        {"pitch": 84},
    ]
    events = [
        step(1, size=1.0),
        step(2, size=0.2),
        step(3, size=0.2, strength=2.0),
        step(4, size=0.99, strength=3.0, other="crate"),
        step(5, size=0.19),
    ]
    notes = notes_of(score_of(events, sound={"voices": voices}))
    assert [note.pitch for note in notes] == [36, 48, 60, 72, 84]


def test_gains_add_up_in_the_level(step, score_of):
    (plain,) = notes_of(score_of([step()]))
    config = {"volume_db": -3, "voices": [{"gain_db": 7.5}]}
    (louder,) = notes_of(score_of([step()], sound=config))
    assert louder.level - plain.level == pytest.approx(4.5)


def test_default_instruments_follow_the_material(step, score_of):
    materials = ("chitin", "oak", "granite", "steel", "glass", "bone")
    events = [step(i + 1, material=name) for i, name in enumerate(materials)]
    programs = [note.program for note in notes_of(score_of(events))]
    assert len(set(programs)) == len(materials)


def test_a_chord_sounds_at_once_with_the_power_of_one_note(step, score_of):
    (plain,) = notes_of(score_of([step()], sound={"voices": [{"pitch": 57}]}))
    notes = notes_of(score_of([step()], sound={"voices": [{"pitch": 57, "chord": "Am7"}]}))
    assert [note.pitch for note in notes] == [57, 60, 64, 67]
    assert {note.onset for note in notes} == {plain.onset}
    assert [note.is_first for note in notes] == [True, False, False, False]
    assert sum(10 ** (n.level / 10) for n in notes) == pytest.approx(10 ** (plain.level / 10))
    assert all(note.tuned for note in notes)


def test_feet_take_the_notes_of_a_chord_in_each_performers_octave(step, score_of):
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
def test_feet_have_distinct_pitches_up_to_two_octaves(step, score_of, sizes, material):
    events = [
        step(1, part=f"foot_{i}", size=size, material=material) for i, size in enumerate(sizes)
    ]
    notes = notes_of(score_of(events))
    assert len({note.pitch for note in notes}) == len(sizes)
