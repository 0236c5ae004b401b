"""Configuration of sound: what is accepted, and one clear message for what is refused."""

import pytest
from pydantic import ValidationError

from audio.config.phrase import Phrase, PhraseStep
from audio.config.quantisation import Quantisation
from audio.config.sound import EventFilter, Master, Range, Room, Sound, Voice
from audio.config.velocity import Velocity
from audio.general_midi import DRUMS, INSTRUMENTS, drum_key, program_number


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


def test_every_field_has_a_description():
    for model in (Sound, Voice, EventFilter, Range, PhraseStep, Phrase, Quantisation, Velocity):
        for name, info in model.model_fields.items():
            assert info.description, name


def test_the_configuration_is_immutable():
    with pytest.raises(ValidationError):
        Sound().volume_db = 3.0


@pytest.mark.parametrize(
    ("config", "place", "hint"),
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
        ({"room": "cave"}, ("room", "preset"), ""),
        ({"room": {"preset": "hall", "seconds": 0}}, ("room", "seconds"), ""),
        ({"room": {"size": [1, 0, 2]}}, ("room", "size", 1), ""),
        ({"room": {"reverb": 1}}, ("room", "reverb"), ""),
        ({"room": 3}, ("room",), ""),
        ({"master": {"lufs": 0}}, ("master", "lufs"), ""),
        ({"master": {"true_peak_db": 1}}, ("master", "true_peak_db"), ""),
        ({"master": "on"}, ("master",), ""),
        ({"soundfont": ""}, ("soundfont",), ""),
        ({"voices": [{"chord": "Amj7"}]}, ("voices", 0, "chord"), "did you mean 'Amaj7'"),
        ({"voices": [{"chord": "Hm"}]}, ("voices", 0, "chord"), "roots: C, C#"),
        ({"voices": [{"chord": "A minor"}]}, ("voices", 0, "chord"), "without a space"),
        ({"voices": [{"scale": "Am77"}]}, ("voices", 0, "scale"), "did you mean 'Am7'"),
        (
            {"voices": [{"drum": "maracas", "chord": "Am"}]},
            ("voices", 0),
            "a drum has one pitch; leave out chord",
        ),
        ({"voices": [{"drum": "maracas", "octave": 1}]}, ("voices", 0), "leave out octave"),
        ({"voices": [{"chord": "Am", "phrase": [0, 1]}]}, ("voices", 0), "either chord or phrase"),
        (
            {"voices": [{"drum": "maracas", "phrase": [0, 2]}]},
            ("voices", 0),
            "leave out degrees or chords in its phrase",
        ),
        ({"quantise": {"grid": "1/8X"}}, ("quantise", "grid"), "did you mean '1/8"),
        ({"quantise": {"grid": "1/7"}}, ("quantise", "grid"), "allowed: 1/1"),
        ({"quantise": {"strength": 1.2}}, ("quantise", "strength"), "less than or equal to 1"),
        ({"quantise": {"swing": 0.3}}, ("quantise", "swing"), "greater than or equal to 0.5"),
        ({"quantise": {"mode": "last"}}, ("quantise", "mode"), "'nearest' or 'next'"),
        ({"tempo_bpm": 0}, ("tempo_bpm",), "greater than or equal to 10"),
    ],
)
def test_a_mistake_is_refused_once_at_its_place(config, place, hint):
    with pytest.raises(ValidationError) as caught:
        Sound.model_validate(config)
    (error,) = caught.value.errors()
    assert error["loc"] == place
    assert hint in error["msg"]


@pytest.mark.parametrize(
    ("phrase", "place", "hint"),
    [
        ([], ("steps",), "one step at least"),
        (["rest", 0], ("steps",), "cannot be a rest"),
        ([0, []], ("steps", 1, "degrees"), "write rest for a silence"),
        ([0, "rust"], ("steps", 1), "'rest'"),
        ([0, {"degree": [1]}], ("steps", 1, "degree"), "not permitted"),
        ([{"beats": 1, "frames": 2}], ("steps", 0), "one of beats, seconds and frames"),
        ({"steps": [0], "beats": 1, "seconds": 2}, (), "one of beats, seconds and frames"),
        ([{"chord": "Am", "rest": True}], ("steps", 0), "one of degrees, chord and rest"),
        ([{"chord": "Amin77"}], ("steps", 0, "chord"), "unknown chord"),
        ([{"seconds": 0}], ("steps", 0, "seconds"), "greater than 0"),
        ([0] * 257, ("steps",), "at most 256"),
    ],
)
def test_a_mistake_in_a_phrase_is_refused_once_at_its_place(phrase, place, hint):
    with pytest.raises(ValidationError) as caught:
        Sound.model_validate({"voices": [{"phrase": phrase}]})
    (error,) = caught.value.errors()
    assert error["loc"] == ("voices", 0, "phrase", *place)
    assert hint in error["msg"]


@pytest.mark.parametrize(
    ("config", "hint"),
    [
        ({"curve": "fixed", "exponent": 2.0}, "'fixed' has no 'exponent'"),
        ({"curve": "linear", "exponent": 2.0}, "'linear' has no 'exponent'"),
        ({"loudest": 90}, "'physical' has no 'loudest'"),
        ({"curve": "linear", "slowest": 3.0}, "slowest, 3 m/s, is to be below fastest, 3 m/s"),
        ({"curve": "log"}, "'physical', 'linear', 'power' or 'fixed'"),
        (128, "less than or equal to 127"),
    ],
)
def test_a_wrong_curve_is_refused_once(config, hint):
    with pytest.raises(ValidationError) as caught:
        Sound.model_validate({"velocity": config})
    (error,) = caught.value.errors()
    assert hint in error["msg"]


def test_a_configuration_written_out_in_full_is_valid():
    for config in ({}, {"velocity": 90}, {"velocity": {"curve": "linear", "fastest": 2.0}}):
        sound = Sound.model_validate(config)
        assert Sound.model_validate(sound.model_dump()) == sound


@pytest.mark.parametrize("name", ["open", "dry", "room", "hall"])
def test_a_room_is_a_name_or_a_mapping(name):
    assert Sound.model_validate({"room": name}).room == Room(preset=name)
    full = Sound.model_validate({"room": {"preset": name, "seconds": 2}}).room
    assert full == Room(preset=name, seconds=2)


def test_a_master_is_off_or_adjusted():
    assert Sound().master == Master(lufs=-16, true_peak_db=-1)
    for off in ("off", False):
        assert Sound.model_validate({"master": off}).master is None
    assert Sound.model_validate({"master": {"lufs": -23}}).master == Master(lufs=-23)
