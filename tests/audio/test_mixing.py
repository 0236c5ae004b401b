"""Sides: equal power, and silence where nothing is to be heard."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.dsp import pan_gains


@given(st.floats(-1, 1))
def test_the_sides_keep_power(pan):
    left, right = pan_gains(pan)
    assert left**2 + right**2 == pytest.approx(1)
    assert (right > left) == (pan > 1e-16) or abs(pan) < 1e-15


def test_full_left_and_right_leave_the_other_side_silent():
    assert pan_gains(-1)[1] == 0
    assert pan_gains(1)[0] == 0
