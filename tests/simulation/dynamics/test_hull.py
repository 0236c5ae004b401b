"""Hulls of points that rounding left nearly in one plane."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from pipeline.errors import MassError
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.spatial import Array


def tube(seed: int, sides: int, rings: int) -> Array:
    """Returns the corners (n, 3) of a bent tube of facets, rounded to single precision."""
    rng = np.random.default_rng(seed)
    turn = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    corners = list[Array]()
    for k in range(rings):
        radius, height = rng.uniform(0.02, 0.05), 0.1 * k
        ring = np.column_stack([radius * np.cos(turn), np.full(sides, height), np.sin(turn)])
        corners.append(ring * [1.0, 1.0, radius])
    axis = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return (np.concatenate(corners) @ axis.T).astype(np.float32).astype(float)


@pytest.mark.parametrize("seed", [7, 237, *range(0, 300, 10)])
def test_hulls_of_rounded_points_are_closed_and_have_the_right_volume(seed: int) -> None:
    points = tube(seed, 6 + seed % 12, 2 + seed % 5)
    hull = hull_of(points)
    corners = hull.vertices[hull.faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(ConvexHull(points).volume, rel=1e-5)
    edges = {
        (a, b) for face in hull.faces.tolist() for a, b in itertools.pairwise([*face, face[0]])
    }
    assert edges == {(b, a) for a, b in edges}


def test_points_of_a_plane_have_no_hull() -> None:
    with pytest.raises(MassError, match="plane"):
        hull_of(np.column_stack([np.random.default_rng(1).normal(size=(20, 2)), np.zeros(20)]))
