"""The author's words: what is accepted, what is refused and how."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from audio.config.notes import Phrase, PhraseStep, Quantisation, Velocity
from audio.config.sound import EventFilter, Range, Sound, Voice
from audio.general_midi import DRUMS, INSTRUMENTS, drum_key, program_number
from audio.harmony import MODES, parse_note, parse_scale
from audio.notes import notes_of

ROOTS = ("C", "C#", "Db", "D", "Eb", "E", "F", "F♯", "G", "Ab", "A", "B♭", "B")


def test_instruments_are_the_programs_of_general_midi():
    assert len(INSTRUMENTS) == len(set(INSTRUMENTS)) == 128
    known = {"acoustic grand piano": 0, "marimba": 12, "violin": 40, "kalimba": 108}
    known |= {"woodblock": 115, "gunshot": 127, "music box": 10, "flute": 73, "timpani": 47}
    assert {name: program_number(name) for name in known} == known
    assert program_number("Honky Tonk  Piano") == 3


def test_drums_are_the_keys_of_general_midi():
    assert len(DRUMS) == len(set(DRUMS)) == 47
    known = {"acoustic bass drum": 35, "Hand-Clap": 39, "crash cymbal 1": 49, "claves": 75}
    known |= {"low wood block": 77, "open triangle": 81}
    assert {name: drum_key(name) for name in known} == known


@pytest.mark.parametrize(
    ("words", "place", "hint"),
    [
        ({"scale": "C minr"}, ("scale",), "'minor'"),
        ({"scale": "H minor"}, ("scale",), "a root and a kind"),
        ({"voices": [{"instrument": "wodblock"}]}, ("voices", 0, "instrument"), "'woodblock'"),
        ({"voices": [{"pitch": 128}]}, ("voices", 0, "pitch"), "0 to 127"),
        ({"voices": [{"pitch": True}]}, ("voices", 0, "pitch"), "0 to 127"),
        ({"voices": [{"pitch": "by sise"}]}, ("voices", 0, "pitch"), "by size"),
        ({"voices": [{"pitch": "G#9"}]}, ("voices", 0, "pitch"), "G9"),
        ({"voices": [{"length": 0}]}, ("voices", 0, "length"), "greater than 0"),
        ({"voices": [{"gain_db": float("inf")}]}, ("voices", 0, "gain_db"), "finite"),
        ({"voices": [{"when": {"whom": "x"}}]}, ("voices", 0, "when", "whom"), "not permitted"),
        ({"volume_db": float("nan")}, ("volume_db",), "finite"),
        ({"voices": [{"drum": "cowbel"}]}, ("voices", 0, "drum"), "'cowbell'"),
        ({"voices": [{"drum": "maracas", "pitch": 60}]}, ("voices", 0), "either drum"),
        ({"voices": [{"pitch": "by foot from H2"}]}, ("voices", 0, "pitch"), "no note name"),
        (
            {"voices": [{"when": {"size": {"above": 1, "below": 1}}}]},
            ("voices", 0, "when", "size"),
            "nothing is above 1 and below 1",
        ),
        ({"voices": [{"pan": 2}]}, ("voices", 0, "pan"), "less than or equal to 1"),
        ({"voices": [{"reverb": -1}]}, ("voices", 0, "reverb"), "greater than or equal to 0"),
        ({"tracks": "causes"}, ("tracks",), "'performer' or 'cause'"),
        ({"loud": 1}, ("loud",), "not permitted"),
    ],
)
def test_a_wrong_word_is_refused_once_at_its_place_with_what_is_allowed(words, place, hint):
    with pytest.raises(ValidationError) as caught:
        Sound.model_validate(words)
    (error,) = caught.value.errors()
    assert error["loc"] == place
    assert hint in error["msg"]


def test_every_word_is_described():
    for model in (Sound, Voice, EventFilter, Range, PhraseStep, Phrase, Quantisation, Velocity):
        for name, info in model.model_fields.items():
            assert info.description, name


def test_words_do_not_change():
    with pytest.raises(ValidationError):
        Sound().volume_db = 3.0


@given(st.integers(0, 127))
def test_note_names_count_semitones_from_c_minus_1(pitch):
    names = ("C", "C#", "D", "Eb", "E", "F", "F#", "G", "Ab", "A", "Bb", "B")
    assert parse_note(f"{names[pitch % 12]}{pitch // 12 - 1}") == pitch


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("root", ROOTS)
def test_degrees_climb_through_the_scale_and_are_found_again(root, mode):
    scale = parse_scale(f"{root} {mode}")
    pitches = [scale.pitch(degree) for degree in range(60)]
    assert pitches == sorted(set(pitches))
    assert pitches[0] == scale.root
    assert all(scale.contains(pitch) for pitch in pitches)
    assert [scale.degree(pitch) for pitch in pitches] == list(range(60))


def test_a_minor_pentatonic_on_c():
    scale = parse_scale("C minor pentatonic")
    assert [p for p in range(60, 72) if scale.contains(p)] == [60, 63, 65, 67, 70]


@given(
    st.sampled_from(ROOTS),
    st.sampled_from(sorted(MODES)),
    st.lists(st.floats(1e-4, 50), min_size=1, max_size=20),
    st.sampled_from(["by size", "by foot", "by part", None]),
)
def test_every_pitch_that_follows_size_or_part_is_in_the_scale(
    step, score_of, root, mode, sizes, rule
):
    scale = f"{root} {mode}"
    voices = [{"pitch": rule}] if rule else []
    events = [step(1, size=size, part=f"foot_{i}") for i, size in enumerate(sizes)]
    notes = notes_of(score_of(events, sound={"scale": scale, "voices": voices}))
    assert len(notes) == len(sizes)
    assert all(parse_scale(scale).contains(note.pitch) for note in notes)
    assert all(36 <= note.pitch <= 96 for note in notes)


def test_smaller_is_higher(step, score_of):
    sizes = (0.8, 0.2, 0.05)
    events = [step(i + 1, cause="collision", size=size) for i, size in enumerate(sizes)]
    pitches = [note.pitch for note in notes_of(score_of(events))]
    assert pitches == sorted(set(pitches))


def test_each_foot_has_its_own_pitch_in_the_order_of_names(step, score_of):
    feet = [f"foot_{i}" for i in (10, 2, 1)]
    notes = notes_of(score_of([step(1, part=foot) for foot in feet]))
    pitch = {note.event.part: note.pitch for note in notes}
    assert pitch["foot_1"] < pitch["foot_2"] < pitch["foot_10"]


def test_the_first_fitting_voice_wins_and_all_its_conditions_must_hold(step, score_of):
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


def test_rules_tell_small_from_large_and_soft_from_hard_without_a_gap(step, score_of):
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


def test_gains_add_up_and_are_heard_in_the_level(step, score_of):
    (plain,) = notes_of(score_of([step()]))
    words = {"volume_db": -3, "voices": [{"gain_db": 7.5}]}
    (louder,) = notes_of(score_of([step()], sound=words))
    assert louder.level - plain.level == pytest.approx(4.5)


def test_materials_choose_instruments_without_any_words(step, score_of):
    materials = ("chitin", "oak", "granite", "steel", "glass", "bone")
    events = [step(i + 1, material=name) for i, name in enumerate(materials)]
    programs = [note.program for note in notes_of(score_of(events))]
    assert len(set(programs)) == len(materials)
