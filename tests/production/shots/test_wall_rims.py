"""Wall rims: round walls are round in the picture, and all else stays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.wall_rims import rounded_walls, wall_faces
from pipeline.simulation.terrain.heightfield import surface_of_vertices

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


def test_the_faces_of_a_round_wall_face_outward() -> None:
    x, z = places()
    flat = ground(np.hypot(x, z) < 1.04)
    field = surface_of_vertices(flat, (CELLS, CELLS))
    worst = []
    for faces in (field.faces, wall_faces(flat, field.faces, (CELLS, CELLS))):
        corners = rounded_walls(flat, (CELLS, CELLS))[faces]
        is_wall = np.ptp(corners[..., 1], axis=1) > 0.5
        a, b, c = (corners[is_wall, k][:, [0, 2]] for k in range(3))
        rise = corners[is_wall, 1, 1] - corners[is_wall, 0, 1]
        other = corners[is_wall, 2, 1] - corners[is_wall, 0, 1]
        # The normal along x and z of (b - a) x (c - a).
        way = np.stack(
            [
                rise * (c - a)[:, 1] - (b - a)[:, 1] * other,
                (b - a)[:, 0] * other - rise * (c - a)[:, 0],
            ],
            axis=-1,
        )
        middle = (a + b + c) / 3.0
        cosine = (way * middle).sum(axis=1) / (np.hypot(*way.T) * np.hypot(*middle.T))
        worst.append(np.degrees(np.arccos(np.abs(cosine).clip(0.0, 1.0))).max())
    assert worst[1] < 12.0 < 25.0 < worst[0]


def test_gentle_ground_keeps_its_faces() -> None:
    x, z = places()
    slope = ground(0.1 * x + 0.05 * np.sin(9.0 * z))
    faces = surface_of_vertices(slope, (CELLS, CELLS)).faces
    np.testing.assert_array_equal(wall_faces(slope, faces, (CELLS, CELLS)), faces)
