"""Rings: the mesh of the land, from the vertices of the terrain's edge to the horizon.

The first ring holds the edge itself; the next has as many vertices as the rest, so that the land
is equally fine whatever the cells of the terrain are. Rings widen with the distance: about as the
size of a pixel does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.production.surroundings.landforms import REACH
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

AROUND = 1440
"""Vertices of a ring at a detail of 1, for frames 1280 pixels wide."""

LEAST_AROUND = 240
"""Vertices of the coarsest rings."""

GROWTH = np.array([[0.0, 0.085], [150.0, 0.085], [500.0, 0.033], [900.0, 0.022], [5e3, 0.022]])
"""Width of a ring relative to its distance [m]: narrow where ridges rise."""

NEAR_GROWTH = float(GROWTH[0, 1])
"""Width of a ring near the terrain, relative to its distance."""


def distances(first: float, detail: float = 1.0) -> Array:
    """Return the distances of the rings beyond the edge (R,), the first at `first` [m]."""
    out = [first]
    while out[-1] < REACH:
        growth = float(np.interp(out[-1], *GROWTH.T)) / detail
        out.append(out[-1] + max(first, growth * out[-1]))
    return np.array(out)


def border(field: HeightField) -> NDArray[np.int64]:
    """Return the numbers of the vertices of the edge, counter-clockwise from above turned down."""
    n_x, n_z = field.cells
    i, j = np.arange(n_x + 1), np.arange(n_z + 1)
    sides = [
        np.stack([i[:-1], np.zeros_like(i[:-1])], axis=-1),
        np.stack([np.full_like(j[:-1], n_x), j[:-1]], axis=-1),
        np.stack([i[:0:-1], np.full_like(i[1:], n_z)], axis=-1),
        np.stack([np.zeros_like(j[1:]), j[:0:-1]], axis=-1),
    ]
    loop = np.concatenate(sides)
    return np.asarray(loop[:, 1] * (n_x + 1) + loop[:, 0])


def turned(places: Array, half: Array) -> Array:
    """Return the angles (N,) of places around the middle, from 0 at the edge's first corner."""
    first = np.arctan2(-half[1], -half[0])
    return np.mod(np.arctan2(places[:, 1], places[:, 0]) - first + 1e-9, 2.0 * np.pi) - 1e-9


def rim_places(half: Array, around: int = AROUND) -> Array:
    """Return places (around, 2) along the edge, at about equal angles, with its corners."""
    corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
    angles = turned(corners[:4], half)
    spans = np.diff([*angles, 2.0 * np.pi])
    counts = np.maximum(np.rint(around * spans / (2.0 * np.pi)).astype(int), 1)
    counts[counts.argmax()] += around - counts.sum()
    sides = []
    for k, count in enumerate(counts):
        angle = angles[k] + spans[k] * np.arange(count) / count + np.arctan2(-half[1], -half[0])
        ray = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        along = (half / np.maximum(np.abs(ray), 1e-12)).min(axis=-1)
        side = ray * along[:, None]
        side[0] = corners[k]
        sides.append(side)
    return np.concatenate(sides)


def zipped(inner: Array, outer: Array) -> NDArray[np.int64]:
    """Return the triangles (n + m, 3) between two loops of vertices.

    Args:
        inner: (n,) ascending angles of the inner loop, whose vertices are numbered from 0.
        outer: (m,) those of the outer loop, numbered from n.
    """
    n, m = len(inner), len(outer)
    # Each step of either loop closes one triangle; steps are taken in the order of their ends.
    ends = np.concatenate([np.append(inner[1:], 7.0), np.append(outer[1:], 7.0)])
    is_inner = np.concatenate([np.ones(n, bool), np.zeros(m, bool)])
    order = np.argsort(ends, kind="stable")
    steps = is_inner[order]
    a = np.concatenate([[0], np.cumsum(steps)[:-1]])
    b = np.concatenate([[0], np.cumsum(~steps)[:-1]])
    here, there = a % n, n + b % m
    ahead = np.where(steps, (a + 1) % n, n + (b + 1) % m)
    return np.stack([here, ahead, there], axis=-1)


def ring_faces(count: int, around: int, start: int) -> NDArray[np.int64]:
    """Return the triangles between `count` rings of `around` vertices, numbered from `start`."""
    a = start + np.arange(count - 1)[:, None] * around + np.arange(around)
    b = start + np.arange(count - 1)[:, None] * around + (np.arange(around) + 1) % around
    quads = np.stack([a, b, b + around, a, b + around, a + around], axis=-1)
    return quads.reshape(-1, 3)
