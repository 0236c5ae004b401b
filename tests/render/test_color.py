"""Colour: sRGB and tone mapping."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from render.color import encoded, linear
from render.development import Development, Tone, developed


def test_srgb_and_light_are_inverse() -> None:
    s = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(encoded(linear(s)), s, atol=1e-7)
    np.testing.assert_array_equal(np.rint(encoded(linear(np.arange(256) / 255)) * 255), range(256))


def grey(values: np.ndarray, stops: float = 0.0) -> np.ndarray:
    light = np.repeat(np.asarray(values, np.float32)[None, :, None], 3, axis=2)
    return developed(light, Development(Tone(stops)))[0].astype(int)


def test_more_light_is_never_darker_and_grey_stays_grey() -> None:
    shown = grey(np.geomspace(1e-5, 100, 4000))
    assert (np.diff(shown, axis=0) >= 0).all()
    assert (np.ptp(shown, axis=1) <= 1).all()
    assert shown[0].max() == 0
    assert shown[-1].min() > 240


def test_middle_grey_is_shown_in_the_middle() -> None:
    assert 95 <= grey(np.array([0.18]))[0, 0] <= 130


@given(stops=st.floats(-6, 6), level=st.floats(0.001, 10))
def test_a_stop_is_a_factor_of_two(stops: float, level: float) -> None:
    by_stops = grey(np.array([level]), stops)
    by_light = grey(np.array([level * 2.0**stops]))
    assert abs(by_stops - by_light).max() <= 1


def test_black_negative_and_infinite_light_are_developed() -> None:
    light = np.array([[[0, 0, 0], [-1, -1, -1], [np.inf, np.inf, np.inf]]], np.float32)
    assert developed(light)[0, :, 0].tolist()[:2] == [0, 0]
    assert developed(light)[0, 2].min() > 240
