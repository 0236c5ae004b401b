"""Room acoustics: early reflections by geometry, and the decay of reverberation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.config.sound import Room
from audio.room_acoustics import (
    Reverberator,
    early_reflections,
    reverb_response,
    room_acoustics,
)

RATE, SOUND = 48_000, 343.0


@given(
    preset=st.sampled_from(["open", "room", "hall"]),
    distance=st.floats(0, 1e300),
    azimuth=st.floats(-4, 4),
    size=st.floats(1e-9, 1e9),
)
def test_no_reflection_precedes_or_exceeds_the_direct_sound(step, preset, distance, azimuth, size):
    event = step(1, distance=distance, azimuth=azimuth, size=size)
    images = list(early_reflections(event, room_acoustics(Room(preset=preset))))
    assert len(images) == (1 if preset == "open" else 6)
    for image in images:
        assert image.delay >= 1
        assert 0 < image.gain < 1
        assert -np.pi <= image.azimuth <= np.pi


def test_the_reflections_of_a_box_match_its_geometry(step):
    room = room_acoustics(Room(preset="hall", size=(10, 8, 20), absorption=0))
    event = step(1, distance=4.0, azimuth=0.0, size=1.6)
    paths = sorted(4.0 + image.delay * SOUND / RATE for image in early_reflections(event, room))
    # Ears and source 1.6 m high, 4 m apart, ears in the middle of the floor.
    ground, top = np.hypot(4, 3.2), np.hypot(4, 12.8)
    side = np.hypot(4, 10)
    assert paths == pytest.approx(sorted([ground, top, side, side, 16, 24]), abs=0.008)


def test_reflections_weaken_with_absorption(step):
    def gains(absorption):
        room = room_acoustics(Room(preset="room", absorption=absorption))
        return [image.gain for image in early_reflections(step(1), room)]

    assert np.divide(gains(0.75), gains(0.0)) == pytest.approx(0.5)
    assert gains(1.0) == []


def test_the_reflection_of_a_left_wall_is_panned_left(step):
    room = room_acoustics(Room(preset="room"))
    pans = [np.sin(i.azimuth) for i in early_reflections(step(1, azimuth=0.0), room)]
    assert min(pans) < -0.7
    assert max(pans) > 0.7
    assert sum(pans) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("seconds", [0.4, 1.0, 2.5])
def test_reverberation_falls_by_60_db_in_its_time(seconds):
    for side in (0, 1):
        tail = reverb_response(seconds, side)
        assert np.sum(tail**2) == pytest.approx(1)
        assert not tail[:576].any()
        # Backward integration. Source: Schroeder 1965.
        left = 10 * np.log10(np.cumsum(tail[::-1] ** 2)[::-1] + 1e-12)
        at = [np.flatnonzero(left < left[0] + level)[0] / RATE for level in (-5, -35)]
        assert 2 * (at[1] - at[0]) == pytest.approx(seconds, rel=0.15)


def test_both_sides_of_reverberation_are_uncorrelated_and_reproducible():
    left, right = reverb_response(1.0, 0), reverb_response(1.0, 1)
    assert abs(np.sum(left * right)) < 0.1
    assert np.array_equal(left, reverb_response(1.0, 0))


@pytest.mark.parametrize("preset", ["open", "room", "hall"])
def test_reverberation_follows_the_onset_and_grows_with_the_send(step, preset):
    click, event = np.ones(8), step(1, distance=3.0)
    power = []
    for send in (0.0, 0.25, 1.0):
        space = Reverberator(room_acoustics(Room(preset=preset)), 48_000)
        space.feed(event, 1000, click, 1.0, send)
        stereo = np.zeros((48_000, 2))
        space.add_to(stereo)
        assert np.abs(stereo[:1001]).max() < 1e-12
        power.append(float((stereo[2000:] ** 2).sum()))
    assert power == sorted(set(power))


def test_a_dry_room_adds_nothing(step):
    space = Reverberator(room_acoustics(Room(preset="dry")), 4800)
    space.feed(step(1), 0, np.ones(100), 1.0, 1.0)
    stereo = np.zeros((4800, 2))
    space.add_to(stereo)
    assert not stereo.any()


def test_a_preset_supplies_what_a_room_does_not_give():
    hall = room_acoustics(Room(preset="hall"))
    said = room_acoustics(Room(preset="hall", seconds=4.0, wet_db=-20))
    assert (said.size, said.reflectance, said.seconds) == (hall.size, hall.reflectance, 4.0)
    assert said.wet == pytest.approx(0.1)
