"""Velocities by curves, and levels that agree with them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from audio.config.notes import Velocity
from audio.config.sound import Sound
from audio.loudness_at_listener import (
    event_level,
    level_of_velocity,
    loudness_db,
    velocity_of_level,
)
from audio.midi_file import midi_bytes
from audio.notes import notes_of

CURVES = ("physical", "linear", "power", "fixed")


@given(st.integers(1, 127))
def test_a_velocity_is_that_of_its_level(velocity):
    assert velocity_of_level(level_of_velocity(velocity)) == velocity


@given(st.floats(0, 50), st.floats(0, 100), st.floats(0.01, 10), st.floats(0, 100), st.booleans())
def test_without_words_a_level_is_the_loudness_of_the_event(step, speed, energy, size, far, scuffs):
    cause = "scuff" if scuffs else "footfall"
    event = step(strength=speed, energy=energy, size=size, distance=far, cause=cause)
    assert event_level(Velocity(), event) == loudness_db(event)


@pytest.mark.parametrize(
    ("words", "velocities"),
    [
        ({"curve": "linear", "slowest": 1, "fastest": 3, "softest": 20, "loudest": 100},
         [20, 20, 60, 100, 100]),
        ({"curve": "power", "exponent": 2, "slowest": 1, "fastest": 3, "softest": 20,
          "loudest": 100}, [20, 20, 40, 100, 100]),
        ({"curve": "fixed", "loudest": 77}, [77] * 5),
        (77, [77] * 5),
    ],
)  # fmt: skip
def test_given_velocities_are_those_of_the_score(step, score_of, read_smf, words, velocities):
    events = [step(i + 1, strength=v) for i, v in enumerate((0.2, 1, 2, 3, 9))]
    score = score_of(events, sound={"velocity": words})
    assert [v for *_, v in read_smf(midi_bytes(score)).onsets()] == velocities
    by_voice = score_of(events, sound={"voices": [{"velocity": words}]})
    assert midi_bytes(by_voice) == midi_bytes(score)


@pytest.mark.parametrize("curve", ["linear", "power", "fixed"])
def test_what_is_far_is_softer_unless_the_author_says_otherwise(step, score_of, curve):
    near, far = step(1, distance=4), step(1, distance=40)
    by = [event_level(Velocity(curve=curve), event) for event in (near, far)]
    assert by[0] - by[1] == pytest.approx(20)
    same = Velocity(curve=curve, distance=False)
    assert event_level(same, near) == event_level(same, far) == pytest.approx(by[0])


@given(
    st.sampled_from(CURVES),
    st.floats(0, 40),
    st.floats(0, 40),
    st.floats(0.05, 4),
)
def test_no_curve_lets_a_harder_blow_be_softer(step, curve, one, other, exponent):
    words = {"curve": curve, "slowest": 0.1, "fastest": 5}
    if curve in ("physical", "power"):
        words["exponent"] = exponent
    if curve == "fixed":
        words = {"curve": curve}
    words = Velocity(**words)
    softer, harder = sorted((one, other))
    low, high = (event_level(words, step(strength=speed)) for speed in (softer, harder))
    assert low <= high + 1e-9


def test_an_exponent_of_one_doubles_the_amplitude_with_the_speed(step):
    words = Velocity(exponent=1)
    one, two = (event_level(words, step(strength=speed)) for speed in (1.0, 2.0))
    assert two - one == pytest.approx(6.0206, abs=1e-3)
    bound = Velocity(slowest=0.5, fastest=2)
    levels = [event_level(bound, step(strength=speed)) for speed in (0.01, 0.5, 2, 30)]
    assert levels[0] == pytest.approx(levels[1])
    assert levels[2] == pytest.approx(levels[3])


def test_the_mass_that_is_heard_stays_where_speeds_are_bound(step):
    words = Velocity(fastest=2)
    fast, bound = step(strength=8.0, energy=32.0), step(strength=2.0, energy=2.0)
    assert event_level(words, fast) == pytest.approx(loudness_db(bound))


def test_gains_are_added_to_given_velocities(step, score_of):
    (plain,) = notes_of(score_of([step()], sound={"velocity": 90}))
    words = {"velocity": 90, "volume_db": -2, "voices": [{"gain_db": 5}]}
    (louder,) = notes_of(score_of([step()], sound=words))
    assert louder.level - plain.level == pytest.approx(3)


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ({"curve": "fixed", "exponent": 2.0}, "'fixed' has no 'exponent'"),
        ({"curve": "linear", "exponent": 2.0}, "'linear' has no 'exponent'"),
        ({"loudest": 90}, "'physical' has no 'loudest'"),
        ({"curve": "linear", "slowest": 3.0}, "slowest, 3 m/s, is to be below fastest, 3 m/s"),
        ({"curve": "log"}, "'physical', 'linear', 'power' or 'fixed'"),
        (128, "less than or equal to 127"),
    ],
)
def test_a_wrong_curve_is_refused_once(words, hint):
    with pytest.raises(ValidationError) as caught:
        Sound.model_validate({"velocity": words})
    (error,) = caught.value.errors()
    assert hint in error["msg"]


def test_words_written_out_in_full_are_read_again():
    for words in ({}, {"velocity": 90}, {"velocity": {"curve": "linear", "fastest": 2.0}}):
        sound = Sound.model_validate(words)
        assert Sound.model_validate(sound.model_dump()) == sound
