"""Shapes: the words of a shape -> its solid, about its middle.

A new shape is a model in `pipeline/spec/prop.py`, a function here and a line in `SHAPES`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pipeline.simulation.figures.solids import Solid, ball, lofted
from pipeline.simulation.spatial import Array
from pipeline.spec.prop import BallShape, BoxShape, CylinderShape, Shape

AROUND = 48
"""Sides of a cylinder."""

BEVEL = 0.04
"""Of the edges of boxes and cylinders, as a part of their least extent: sharp ones look cut
out of paper, since no light catches on them."""


def box(words: BoxShape) -> Solid:
    """Return a box with bevelled edges."""
    x, y, z = (extent / 2.0 for extent in words.size)
    bevel = BEVEL * min(words.size)
    # A rectangle with its corners cut, turning from +z to +x.
    outer = [(bevel - x, z), (x - bevel, z), (x, z - bevel), (x, bevel - z)]
    outer += [(-a, -b) for a, b in outer]
    ring = np.array([[a, 0.0, b] for a, b in outer])
    inward = np.array([(x - bevel) / x, 1.0, (z - bevel) / z])
    return _bevelled(ring, ring * inward, y, bevel)


def cylinder(words: CylinderShape) -> Solid:
    """Return an upright cylinder with bevelled rims."""
    bevel = BEVEL * min(2.0 * words.radius, words.height)
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    ring = np.stack([np.sin(angle), np.zeros(AROUND), np.cos(angle)], axis=-1)
    rings = words.radius * ring, (words.radius - bevel) * ring
    return _bevelled(*rings, words.height / 2.0, bevel)


def _bevelled(outer: Array, inner: Array, half: float, bevel: float) -> Solid:
    """Return what stands between rings (n, 3), turning from z to x: `inner` at both ends."""
    levels = (inner, -half), (outer, bevel - half), (outer, half - bevel), (inner, half)
    rings = np.stack([ring + np.array([0.0, y, 0.0]) for ring, y in levels])
    return lofted(rings, rings[[0, -1]].mean(axis=1))


def sphere(words: BallShape) -> Solid:
    """Return a ball."""
    return ball(np.zeros(3), words.radius)


SHAPES: dict[type[Any], Callable[[Any], Solid]] = {
    BoxShape: box,
    CylinderShape: cylinder,
    BallShape: sphere,
}


def solid_of(words: Shape) -> Solid:
    """Return the solid of a shape."""
    return SHAPES[type(words)](words)


def bottom(words: Shape) -> float:
    """Return how far a shape reaches below its middle [m]."""
    return -float(solid_of(words).vertices[:, 1].min())
