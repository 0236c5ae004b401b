"""Sides: equal power, and silence where nothing is to be heard."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.mixing import sides


@given(st.floats(-1, 1))
def test_the_sides_keep_power(pan):
    left, right = sides(pan)
    assert left**2 + right**2 == pytest.approx(1)
    assert (right > left) == (pan > 1e-16) or abs(pan) < 1e-15


def test_full_left_and_right_leave_the_other_side_silent():
    assert sides(-1)[1] == 0
    assert sides(1)[0] == 0
