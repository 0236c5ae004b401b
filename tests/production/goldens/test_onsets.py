"""Onsets and slates are found again in sounds and pictures."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pipeline.production.goldens.slate import slate, slate_number
from pipeline.production.goldens.sound_onsets import (
    CLEAR_RISE,
    Onset,
    common_shift,
    instant_of,
    measured_onsets,
    onsets_of,
    unmatched_onsets,
)

RATE = 48_000


def blows(times: list[float], noise: float = 1e-4) -> NDArray[np.float64]:
    """Return two seconds of sound in which something is struck at `times` [s]."""
    sound = noise * np.random.default_rng(1).normal(size=2 * RATE)
    for time in times:
        first = round(time * RATE)
        t = np.arange(2 * RATE - first) / RATE
        sound[first:] += 0.3 * np.exp(-t / 0.06) * np.sin(2 * np.pi * 700 * t)
    return sound


def test_onsets_are_found_at_their_times() -> None:
    times = [0.1, 0.5, 0.52, 1.25, 1.6]
    found = [onset.time for onset in onsets_of(blows(times)) if onset.rise >= CLEAR_RISE]
    # The blow 20 ms after another one is lost in its sound.
    assert found == pytest.approx([0.1, 0.5, 1.25, 1.6], abs=0.0051)
    assert onsets_of(blows([])) == ()
    assert onsets_of(np.zeros(0)) == ()


def test_a_missing_onset_is_detected_and_noise_is_not() -> None:
    then = onsets_of(blows([0.1, 0.6, 1.3]))
    assert unmatched_onsets(then, onsets_of(blows([0.1, 0.6, 1.3], 2e-4)), 1 / 48) == ([], [])
    gone, new = unmatched_onsets(then, onsets_of(blows([0.1, 1.3])), 1 / 48)
    assert [onset.time for onset in gone] == pytest.approx([0.6], abs=0.0051)
    assert new == []


@pytest.mark.parametrize("late", [-2, -1, 1, 3])
def test_a_late_track_is_distinguished_from_another_one(late: int) -> None:
    times = [0.31, 0.6, 1.05, 1.3]
    then = onsets_of(blows(times))
    now = onsets_of(blows([time + late / 24 for time in times]))
    # To two hops, unless the instants are measured.
    assert common_shift(then, now) == pytest.approx(late / 24, abs=0.01)
    assert common_shift(then, onsets_of(blows([0.2, 0.9]))) == 0
    assert common_shift(then, then) == 0


@pytest.mark.parametrize("late", [-500, -7, 1, 48, 3000])
def test_a_late_track_is_measured_to_the_sample(late: int) -> None:
    sound = blows([0.31, 0.6, 1.05, 1.3])
    then, now = (measured_onsets(np.stack([s, 0.5 * s])) for s in (sound, np.roll(sound, late)))
    assert common_shift(then, now) * RATE == pytest.approx(late, abs=0.2)
    assert [onset.levels[0] - onset.levels[1] for onset in then] == pytest.approx(
        [6.0] * len(then), abs=0.15
    )


@given(
    gain=st.floats(0.05, 2.0),
    noise=st.floats(0.0, 1e-5),
    late=st.integers(-2000, 2000),
)
def test_an_instant_follows_its_sound_and_nothing_else(
    gain: float, noise: float, late: int
) -> None:
    sound = blows([0.31, 1.05], 0.0)
    rng = np.random.default_rng(late + 2000)
    other = gain * np.roll(sound, late) + noise * rng.normal(size=sound.size)
    for time in (0.31, 1.05):
        first, second = (
            instant_of(sound_, Onset(start, 20.0))
            for sound_, start in ((sound, time), (other, time + late / RATE))
        )
        assert first is not None
        assert second is not None
        assert second - first == pytest.approx(late, abs=0.3)


def test_silence_and_a_swell_have_no_instant() -> None:
    t = np.arange(RATE) / RATE
    swell = 0.3 * np.minimum(t, 0.5) * np.sin(2 * np.pi * 300 * t)
    assert instant_of(swell, Onset(0.3, 5.0)) is None
    assert instant_of(np.zeros(RATE), Onset(0.3, 5.0)) is None


def test_weak_onsets_are_ignored() -> None:
    clear, weak = Onset(0.5, CLEAR_RISE + 1), Onset(1.0, CLEAR_RISE - 1)
    assert unmatched_onsets([clear, weak], [clear], 0.02) == ([], [])
    # Yet a weak one is partner enough for a clear one.
    assert unmatched_onsets([Onset(1.0, CLEAR_RISE + 1)], [weak], 0.02) == ([], [])


@pytest.mark.parametrize("number", [0, 1, 2, 1023, 65_536, 999_999])
def test_a_slate_shows_its_number(number: int) -> None:
    assert slate_number(slate(number)[..., 0]) == number
    noise = np.random.default_rng(number).normal(0, 20, slate(number).shape[:2])
    assert slate_number(slate(number)[..., 0] * 0.8 + 20 + noise) == number
