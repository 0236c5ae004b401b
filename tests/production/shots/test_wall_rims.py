"""Wall rims: round walls are round in the picture, and all else stays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.wall_rims import rounded_walls

CELLS = 60


def ground(height: NDArray[np.bool_] | NDArray[np.float64]) -> NDArray[np.float64]:
    z, x = np.mgrid[0 : CELLS + 1, 0 : CELLS + 1] * 0.1 - 3.0
    return np.stack([x, np.broadcast_to(height, x.shape), z], axis=-1).reshape(-1, 3).astype(float)


def places() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    z, x = np.mgrid[0 : CELLS + 1, 0 : CELLS + 1] * 0.1 - 3.0
    return x, z


def test_the_edge_of_a_round_stone_is_nearer_to_a_circle() -> None:
    x, z = places()
    before = ground(np.hypot(x, z) < 1.04)
    after = rounded_walls(before, (CELLS, CELLS))
    moved = np.any(after != before, axis=1) & (before[:, 1] > 0.5)
    spreads = [np.hypot(v[moved, 0], v[moved, 2]).std() for v in (before, after)]
    assert spreads[1] < 0.6 * spreads[0]
    # It does not shrink, and no height changes.
    np.testing.assert_array_equal(after[:, 1], before[:, 1])
    assert np.hypot(after[moved, 0], after[moved, 2]).mean() > 0.95
    assert np.hypot(*(after - before)[:, [0, 2]].T).max() < 0.08


def test_straight_walls_slopes_and_the_border_stay() -> None:
    x, z = places()
    ditch = ground(np.abs(x) < 0.52)
    np.testing.assert_allclose(rounded_walls(ditch, (CELLS, CELLS)), ditch, atol=1e-9)
    slope = ground(0.1 * x + 0.05 * np.sin(9.0 * z))
    assert rounded_walls(slope, (CELLS, CELLS)) is slope
