"""Closest points of segments: optimality, and parallel segments."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.simulation.characters.link_contacts import closest_points
from pipeline.simulation.dynamics.compiled import entry
from pipeline.simulation.spatial import Array


@entry
def all_closest(p: Array, u: Array, q: Array, v: Array) -> Array:
    result = np.empty((len(p), 2))
    for i in range(len(p)):
        result[i] = closest_points(
            (p[i, 0], p[i, 1], p[i, 2]),
            (u[i, 0], u[i, 1], u[i, 2]),
            (q[i, 0], q[i, 1], q[i, 2]),
            (v[i, 0], v[i, 1], v[i, 2]),
        )
    return result


def pairs(kind: str) -> tuple[Array, Array, Array, Array]:
    rng = np.random.default_rng(11)
    p, u, q, v = rng.normal(size=(4, 3000, 3))
    if kind == "parallel":
        v = u * rng.normal(size=(3000, 1))
    if kind == "nearly parallel":
        v = u + 1e-7 * v
    if kind == "points":
        u[::2] = 0.0
        v[::3] = 0.0
    if kind == "crossing":
        q = p + 0.5 * u - 0.5 * v
    return p, u, q, v


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["any", "parallel", "nearly parallel", "points", "crossing"])
def test_closest_points_are_optimal(kind: str) -> None:
    p, u, q, v = pairs(kind)
    s, t = all_closest(p, u, q, v).T
    assert (s >= 0).all() and (s <= 1).all() and (t >= 0).all() and (t <= 1).all()  # noqa: PT018
    away = p + s[:, None] * u - q - t[:, None] * v
    # The distance is convex in (s, t): it decreases along neither inside the square.
    for place, slope in ((s, (away * u).sum(axis=1)), (t, -(away * v).sum(axis=1))):
        # The error is up to the sine below which segments count as parallel.
        scale = 2e-5 if kind == "nearly parallel" else 1e-9
        assert (slope[place < 1.0] > -scale).all()
        assert (slope[place > 0.0] < scale).all()


def test_parallel_segments_touch_in_the_middle_of_the_shared_stretch() -> None:
    one = np.array([[0.0, 0.0, 0.0]]), np.array([[2.0, 0.0, 0.0]])
    other = np.array([[1.0, 1.0, 0.0]]), np.array([[3.0, 0.0, 0.0]])
    assert all_closest(*one, *other)[0] == pytest.approx([0.75, 1.0 / 6.0])
