"""Loudness at the listener: velocity curves, pan and reverb sends."""

from math import sqrt

import pytest
import symusic
from hypothesis import given
from hypothesis import strategies as st

from audio.config.velocity import Velocity
from audio.loudness_at_listener import (
    CRITICAL_DISTANCE,
    event_level,
    level_of_velocity,
    loudness_db,
    reverb_send,
    velocity_of_level,
)
from audio.midi_file import midi_bytes
from audio.notes import notes_of

CURVES = ("physical", "linear", "power", "fixed")


@given(st.integers(1, 127))
def test_velocity_and_level_invert(velocity):
    assert velocity_of_level(level_of_velocity(velocity)) == velocity


@given(st.floats(0, 50), st.floats(0, 100), st.floats(0.01, 10), st.floats(0, 100), st.booleans())
def test_the_default_level_is_the_loudness_of_the_event(step, speed, energy, size, far, scuffs):
    cause = "scuff" if scuffs else "footfall"
    event = step(strength=speed, energy=energy, size=size, distance=far, cause=cause)
    assert event_level(Velocity(), event) == loudness_db(event)


@pytest.mark.parametrize(
    ("config", "velocities"),
    [
        ({"curve": "linear", "slowest": 1, "fastest": 3, "softest": 20, "loudest": 100},
         [20, 20, 60, 100, 100]),
        ({"curve": "power", "exponent": 2, "slowest": 1, "fastest": 3, "softest": 20,
          "loudest": 100}, [20, 20, 40, 100, 100]),
        ({"curve": "fixed", "loudest": 77}, [77] * 5),
        (77, [77] * 5),
    ],
)  # fmt: skip
def test_configured_velocities_are_those_of_the_score(step, score_of, read_smf, config, velocities):
    events = [step(i + 1, strength=v) for i, v in enumerate((0.2, 1, 2, 3, 9))]
    score = score_of(events, sound={"velocity": config})
    assert [v for *_, v in read_smf(midi_bytes(score)).onsets()] == velocities
    by_voice = score_of(events, sound={"voices": [{"velocity": config}]})
    assert midi_bytes(by_voice) == midi_bytes(score)


@pytest.mark.parametrize("curve", ["linear", "power", "fixed"])
def test_distant_events_are_softer_unless_distance_is_off(step, score_of, curve):
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
def test_every_curve_is_monotonic_in_speed(step, curve, one, other, exponent):
    config = {"curve": curve, "slowest": 0.1, "fastest": 5}
    if curve in ("physical", "power"):
        config["exponent"] = exponent
    if curve == "fixed":
        config = {"curve": curve}
    config = Velocity(**config)
    softer, harder = sorted((one, other))
    low, high = (event_level(config, step(strength=speed)) for speed in (softer, harder))
    assert low <= high + 1e-9


def test_an_exponent_of_one_doubles_the_amplitude_with_the_speed(step):
    config = Velocity(exponent=1)
    one, two = (event_level(config, step(strength=speed)) for speed in (1.0, 2.0))
    assert two - one == pytest.approx(6.0206, abs=1e-3)
    bound = Velocity(slowest=0.5, fastest=2)
    levels = [event_level(bound, step(strength=speed)) for speed in (0.01, 0.5, 2, 30)]
    assert levels[0] == pytest.approx(levels[1])
    assert levels[2] == pytest.approx(levels[3])


def test_bounds_of_speed_keep_the_mass(step):
    config = Velocity(fastest=2)
    fast, bound = step(strength=8.0, energy=32.0), step(strength=2.0, energy=2.0)
    assert event_level(config, fast) == pytest.approx(loudness_db(bound))


def test_gains_are_added_to_configured_velocities(step, score_of):
    (plain,) = notes_of(score_of([step()], sound={"velocity": 90}))
    config = {"velocity": 90, "volume_db": -2, "voices": [{"gain_db": 5}]}
    (louder,) = notes_of(score_of([step()], sound=config))
    assert louder.level - plain.level == pytest.approx(3)


def test_direct_sound_and_reverberation_are_equal_at_the_critical_distance():
    assert reverb_send(CRITICAL_DISTANCE, 1.0) == pytest.approx(sqrt(0.5))
    for distance in (0.1, 1.0, 30.0):
        room = reverb_send(distance, 1.0) ** 2
        assert room / (1 - room) == pytest.approx((distance / CRITICAL_DISTANCE) ** 2)


@given(st.floats(0, 1e300), st.floats(0, 1e300), st.floats(0, 1))
def test_the_send_grows_with_distance_up_to_the_configured_share(one, other, reverb):
    near, far = sorted((one, other))
    assert 0 <= reverb_send(near, reverb) <= reverb_send(far, reverb) <= reverb


def test_a_voice_sets_its_own_reverb_and_pan(step, score_of):
    events = [step(1, who="a", azimuth=1.0), step(1, who="b", azimuth=1.0)]
    sound = {"reverb": 0.8, "voices": [{"when": {"who": "b"}, "reverb": 0, "pan": -1}]}
    a, b = notes_of(score_of(events, sound=sound))
    assert (a.send, b.send) == (reverb_send(4.0, 0.8), 0.0)
    assert a.effective_pan == pytest.approx(0.8415, abs=1e-4)
    assert b.effective_pan == -1


def test_another_reader_finds_pan_and_reverb_in_the_score(step, score_of):
    events = [step(1, distance=0.1), step(9, distance=10.0), step(17, distance=1e4)]
    sound = {"reverb": 1.0, "voices": [{"pan": 1}]}
    tracks = symusic.Score.from_midi(midi_bytes(score_of(events, sound=sound))).tracks
    told = sorted((c.time, c.number, c.value) for track in tracks for c in track.controls)
    assert [value for _, number, value in told if number == 91] == [1, 91, 127]
    assert {value for _, number, value in told if number == 10} == {127}


def test_a_walk_past_the_camera_is_reverberated_more_and_more(step, score_of):
    events = [step(i + 1, distance=1 + i / 2) for i in range(40)]
    data = midi_bytes(score_of(events, 48))
    reverbs = [
        c.value for t in symusic.Score.from_midi(data).tracks for c in t.controls if c.number == 91
    ]
    assert reverbs == sorted(set(reverbs))
    assert len(reverbs) >= 20
