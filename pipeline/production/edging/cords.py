"""Cords with what hangs on them: paper lanterns by the sea, pennants along houses of a town."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pipeline.production.edging.border import Border, turns
from pipeline.production.edging.masonry import lantern
from pipeline.production.scenery.expansion import Copies
from pipeline.production.scenery.prototype import UP, Prototype, Shape, add_tubes
from pipeline.simulation.spatial import Array

LANTERN_COLORS = ((0.80, 0.22, 0.08), (0.85, 0.52, 0.12), (0.82, 0.72, 0.50), (0.70, 0.12, 0.10))
"""Linear colours of paper lanterns."""

PENNANT_COLORS = (
    *((0.66, 0.06, 0.05), (0.80, 0.76, 0.66), (0.05, 0.16, 0.42)),
    *((0.82, 0.52, 0.06), (0.08, 0.30, 0.14)),
)
"""Linear colours of pennants of cloth."""

PENNANT, APART = (0.26, 0.36), 0.4
"""Width and length of a pennant, and the distance from one to the next [m]."""

PENNANT_SAG, LANTERN_SAG = 0.05, 0.42
"""How far a cord sags: relative to its length, and with lanterns [m]."""

PARTS = 12
"""Straight parts of a cord."""


def festoon(border: Border, level: float, spacing: float) -> None:
    """Add poles along a railing with cords between them, on which paper lanterns hang."""
    rng = np.random.default_rng([border.seed, 457])
    rows = border.rows(-0.12, spacing, 2.6, 0.2)
    if not len(rows.places):
        return
    spans = border.spans(rows, spacing, -0.12)[:, None]
    base = np.stack([rows.places[:, 0], np.full(len(rows.places), level), rows.places[:, 1]], -1)
    along = np.stack([np.cos(rows.heading), np.zeros(len(base)), -np.sin(rows.heading)], axis=-1)
    ends = base - 0.5 * spans * along + 2.5 * UP, base + 0.5 * spans * along + 2.5 * UP
    cords = _hung(*ends, np.full(len(base), LANTERN_SAG))
    shape = Shape()
    _add_cords(shape, cords)
    feet = (cords[:, [0, -1]] * [1.0, 0.0, 1.0] + [0.0, level, 0.0]).reshape(-1, 3)
    count = len(feet)
    add_tubes(
        *(shape, feet, feet + 2.58 * UP, np.full(count, 0.035), np.full(count, 0.025)),
        *(np.tile([0.16, 0.11, 0.07], (count, 1)), 7),
    )
    _add_as_it_is(border, shape)
    for k in (2, 5, 8, 11):
        points = cords[:, k] - [0.0, 0.12, 0.0]
        tints = np.array(LANTERN_COLORS)[rng.integers(0, len(LANTERN_COLORS), len(points))]
        size = rng.uniform(0.22, 0.3, (len(points), 1)) * [1.0, 0.85, 1.0]
        border.leaves.append(Copies(lantern(), points, turns(rows.heading), size, tints))


def pennants(border: Border, start: Array, end: Array, rng: np.random.Generator) -> None:
    """Add a cord with pennants between two points (3,) [m]."""
    way = end - start
    long = float(np.linalg.norm(way))
    (cord,) = _hung(start[None], end[None], np.array([PENNANT_SAG * long]))
    shape = Shape()
    _add_cords(shape, cord[None])
    _add_as_it_is(border, shape)
    # Two or three colours take turns.
    colors = rng.permutation(PENNANT_COLORS)[: rng.integers(2, 4)]
    at = np.arange(0.5 * APART, long - 0.4 * APART, APART) / long * PARTS
    points = np.stack([np.interp(at, np.arange(PARTS + 1), axis) for axis in cord.T], axis=-1)
    size = rng.uniform(0.94, 1.06, (len(at), 1)) * [PENNANT[0], PENNANT[1], PENNANT[1]]
    tints = colors[np.arange(len(at)) % len(colors)] * rng.uniform(0.85, 1.1, (len(at), 1))
    turned = turns(np.arctan2(-way[2], way[0]) + rng.normal(0.0, 0.16, len(at)))
    border.leaves.append(Copies(pennant(), points, turned, size, tints))


@lru_cache(maxsize=1)
def pennant() -> Prototype:
    """Return a white triangle of cloth of unit width and length that hangs from the origin."""
    rows = np.linspace(0.0, 1.0, 5)
    across = np.linspace(-0.5, 0.5, 5)
    down, aside = np.meshgrid(rows, across, indexing="ij")
    # It bulges a little, and its tip curls.
    bulge = 0.10 * np.sin(np.pi * down) * np.cos(2.2 * aside) + 0.14 * down**3
    points = np.stack([aside * (1.0 - down), -down, bulge], axis=-1).reshape(-1, 3)
    number = np.arange(25).reshape(5, 5)
    a, b, c, d = (
        part.ravel()
        for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:])
    )
    faces = np.concatenate([np.stack([a, c, b], -1), np.stack([b, c, d], -1)])
    normals = np.stack([0.0 * points[:, 0], 0.3 * points[:, 1], 1.0 + 0.0 * points[:, 0]], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    shape = Shape()
    shape.add(points, normals, np.ones((25, 3)), faces, thin=True)
    return shape.prototype()


def _hung(starts: Array, ends: Array, sag: Array) -> Array:
    """Return cords (N, PARTS + 1, 3) that sag (N,) between points (N, 3) [m]."""
    t = np.linspace(0.0, 1.0, PARTS + 1)[:, None]
    straight = starts[:, None] + t * (ends - starts)[:, None]
    return np.asarray(straight - 4.0 * (t * (1.0 - t)) * sag[:, None, None] * UP)


def _add_cords(shape: Shape, cords: Array) -> None:
    count = PARTS * len(cords)
    add_tubes(
        *(shape, cords[:, :-1].reshape(-1, 3), cords[:, 1:].reshape(-1, 3)),
        *(np.full(count, 0.008), np.full(count, 0.008)),
        *(np.tile([0.05, 0.04, 0.03], (count, 1)), 4),
    )


def _add_as_it_is(border: Border, shape: Shape) -> None:
    one = np.ones((1, 3))
    border.leaves.append(Copies(shape.prototype(), np.zeros((1, 3)), np.eye(3)[None], one, one))
