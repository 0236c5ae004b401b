"""Path smoothing: straight paths, bounces, envelopes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.production.camera.camera_path import envelope, smoothed

values = st.lists(st.floats(-5, 5), min_size=1, max_size=120)
sigmas = st.floats(0.5, 30)


@settings(max_examples=100, deadline=None)
@given(values, sigmas)
def test_an_envelope_is_smooth_and_never_too_low(least: list[float], sigma: float) -> None:
    """Of a step h its second difference is h / (σ² √(2πe)); all rises and falls add up."""
    bound = np.array(least)
    path = envelope(bound, sigma)
    assert (path >= bound).all()
    assert path.max() <= bound.max() + 1e-9
    varied = np.abs(np.diff(bound)).sum()
    bend = varied / (sigma**2 * math.sqrt(2 * math.pi * math.e))
    if sigma > 2 and len(path) > 2:
        # The kernel ends at three σ, with a step of its own there.
        cut_off = varied * math.exp(-4.5) / (sigma * math.sqrt(2 * math.pi)) * 2
        assert np.abs(np.diff(path, 2)).max() <= 1.05 * bend + cut_off + 1e-9


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 80), sigmas, st.floats(-3, 3), st.floats(-3, 3))
def test_a_straight_path_is_unchanged(count: int, sigma: float, start: float, speed: float) -> None:
    path = (start + speed * np.arange(count))[:, None] * [1.0, -2.0]
    np.testing.assert_allclose(smoothed(path, sigma), path, atol=1e-9)


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.0, 4.0])
def test_a_bounce_is_smoothed_to_its_ends(phase: float) -> None:
    """A gaussian leaves exp(-(ωσ)²/2) of a wave; where it ends, not more than a quarter."""
    frames, omega, sigma = np.arange(144), 0.5, 10.8
    path = (0.02 * frames + np.sin(omega * frames + phase))[:, None]
    shake = smoothed(path, sigma)[:, 0] - 0.02 * frames
    middle = shake[48:-48]
    assert np.ptp(middle) < 1e-2
    assert np.abs(shake).max() < 0.25
    assert np.abs(np.diff(shake, 2)).max() < 0.05 * omega**2
