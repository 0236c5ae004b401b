"""The limiter: nothing passes its ceiling, and nothing quiet is touched."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.mixing import limited, sides

CEILING = 10 ** (-1 / 20)


@pytest.mark.parametrize("loudness", [0.5, 0.9, 1.2, 5.0, 1e6, 1e200])
def test_no_mix_passes_the_ceiling(loudness):
    rng = np.random.default_rng(1)
    mix = rng.uniform(-1, 1, (20_000, 2)) * np.exp(-np.arange(20_000) / 3000)[:, None] * loudness
    out, lowered = limited(mix)
    assert np.abs(out).max() < CEILING
    assert np.array_equal(np.sign(out), np.sign(mix))
    assert (lowered > 0) == (loudness > 0.9)


def test_a_single_spike_is_caught():
    mix = np.zeros((9999, 2))
    mix[[0, 47, 48, 5000, 9998], [0, 1, 0, 1, 0]] = [3, -40, 2, -1.1, 700]
    out, _ = limited(mix)
    assert np.abs(out).max() < CEILING
    assert np.abs(out[5000, 1]) > 0.6


def test_what_is_far_from_a_crash_is_left_as_it_is():
    mix = np.full((48_000, 2), 0.1)
    mix[24_000:24_100] = 8.0
    out, lowered = limited(mix)
    assert lowered > 15
    assert np.array_equal(out[:23_000], mix[:23_000])
    assert np.array_equal(out[29_000:], mix[29_000:])
    assert (out[24_200] < 0.05).all()


def test_a_mix_below_the_knee_is_not_touched():
    mix = np.random.default_rng(2).uniform(-0.59, 0.59, (5000, 2))
    assert np.array_equal(limited(mix)[0], mix)


@given(st.floats(-1, 1))
def test_the_sides_keep_power(pan):
    left, right = sides(pan)
    assert left**2 + right**2 == pytest.approx(1)
    assert (right > left) == (pan > 1e-16) or abs(pan) < 1e-15


def test_full_left_and_right_leave_the_other_side_silent():
    assert sides(-1)[1] == 0
    assert sides(1)[0] == 0
