"""Edge smoothing: steps of outlines become even, and all else stays as it is."""

from __future__ import annotations

import numpy as np
import pytest

from render.edge_smoothing import smoothed_edges


def _half_plane(slope: float, bright: float) -> np.ndarray:
    y, x = np.mgrid[0:60, 0:80]
    is_sky = y < 20.0 + slope * x
    return np.where(is_sky[..., None], bright, 0.05).astype(np.float32).repeat(3, axis=-1)


@pytest.mark.parametrize("slope", [0.1, 0.15, 0.25])
def test_steps_of_an_edge_are_nearer_to_the_share_that_it_covers(slope: float) -> None:
    light = _half_plane(slope, 0.8)
    y, x = np.mgrid[0:60, 0:80]
    # The share of the sky in each pixel, of 16 by 16 places.
    part = (np.arange(16) + 0.5) / 16 - 0.5
    inside = [
        (y + dy) < 20.0 + slope * (x + dx) + 1e-9 for dy in part.tolist() for dx in part.tolist()
    ]
    share = np.mean(inside, axis=0)
    compressed = lambda value: value / (1.0 + value)  # noqa: E731
    wanted = compressed(0.05) + share * (compressed(0.8) - compressed(0.05))
    inner = (slice(4, -4), slice(4, -4))
    before = np.abs(compressed(light[..., 0]) - wanted)[inner].sum()
    after = np.abs(compressed(smoothed_edges(light, 0.0)[..., 0]) - wanted)[inner].sum()
    assert after < 0.75 * before


def test_even_areas_and_soft_shades_stay_as_they_are() -> None:
    ramp = np.linspace(0.1, 0.6, 200, dtype=np.float32)
    light = np.broadcast_to(ramp[None, :, None], (40, 200, 3)).copy()
    np.testing.assert_array_equal(smoothed_edges(light, 0.0), light)


def test_a_sun_neither_spreads_across_its_edge_nor_overflows() -> None:
    light = _half_plane(0.0, 4000.0)
    smoothed = smoothed_edges(light, 1.0)
    assert np.isfinite(smoothed).all()
    np.testing.assert_allclose(smoothed, light, rtol=2e-2)
