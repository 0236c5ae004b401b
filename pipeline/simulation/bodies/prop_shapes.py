"""Prop shapes: the solid of each shape, about its middle.

A new shape is a model in `pipeline/spec/prop.py`, a function here and a line in `SHAPES`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pipeline.simulation.figures.solids import Solid, ball_solid, loft
from pipeline.simulation.spatial import Array
from pipeline.spec.prop import BallShape, BoxShape, ConeShape, CylinderShape, GearShape, Shape

CYLINDER_SIDES = 48
"""Sides of a cylinder."""

BEVEL_FRACTION = 0.04
"""Of the edges of boxes and cylinders, as a part of their least extent: sharp ones look cut
out of paper, since no light catches on them."""


def _box(words: BoxShape) -> Solid:
    """Return a box with bevelled edges."""
    x, y, z = (extent / 2.0 for extent in words.size)
    bevel = BEVEL_FRACTION * min(words.size)
    # A rectangle with its corners cut, turning from +z to +x.
    outer = [(bevel - x, z), (x - bevel, z), (x, z - bevel), (x, bevel - z)]
    outer += [(-a, -b) for a, b in outer]
    ring = np.array([[a, 0.0, b] for a, b in outer])
    inward = np.array([(x - bevel) / x, 1.0, (z - bevel) / z])
    return _bevelled_rings(ring, ring * inward, y, bevel)


def _cylinder(words: CylinderShape) -> Solid:
    """Return an upright cylinder with bevelled rims."""
    bevel = BEVEL_FRACTION * min(2.0 * words.radius, words.height)
    angle = np.arange(CYLINDER_SIDES) * (2.0 * np.pi / CYLINDER_SIDES)
    ring = np.stack([np.sin(angle), np.zeros(CYLINDER_SIDES), np.cos(angle)], axis=-1)
    rings = words.radius * ring, (words.radius - bevel) * ring
    return _bevelled_rings(*rings, words.height / 2.0, bevel)


def _bevelled_rings(outer: Array, inner: Array, half: float, bevel: float) -> Solid:
    """Return what stands between rings (n, 3), turning from z to x: `inner` at both ends."""
    levels = (inner, -half), (outer, bevel - half), (outer, half - bevel), (inner, half)
    rings = np.stack([ring + np.array([0.0, y, 0.0]) for ring, y in levels])
    return loft(rings, rings[[0, -1]].mean(axis=1))


def _cone(words: ConeShape) -> Solid:
    """Return an upright cone, its rims bevelled."""
    half, low, high = words.height / 2.0, words.radius, words.top
    bevel = BEVEL_FRACTION * min(2.0 * low, words.height)
    least = 0.02 * low  # Its point is a little round, as points are.
    profile = [(low - bevel, -half), (low, bevel - half), (max(high, least), half - 0.5 * bevel)]
    profile.append((max(high - bevel, 0.5 * least), half))
    angle = np.arange(CYLINDER_SIDES) * (2.0 * np.pi / CYLINDER_SIDES)
    ring = np.stack([np.sin(angle), np.zeros(CYLINDER_SIDES), np.cos(angle)], axis=-1)
    rings = np.stack([radius * ring + np.array([0.0, y, 0.0]) for radius, y in profile])
    return loft(rings, rings[[0, -1]].mean(axis=1))


def _gear(words: GearShape) -> Solid:
    """Return a gear wheel with straight flanks, one of its teeth along +X."""
    pitch = 2.0 * np.pi / words.teeth
    # A tooth is as deep as two modules and a bit; half of the pitch is tooth at its middle.
    module = 2.0 * words.radius / words.teeth
    outer, inner = words.radius + 0.95 * module, words.radius - 1.15 * module
    flanks = np.array([-0.31, -0.12, 0.12, 0.31]) * pitch
    radii = np.array([inner, outer, outer, inner])
    # From +z to +x, as all rings here turn.
    angle = (pitch * np.arange(words.teeth)[:, None] + flanks).ravel()
    radius = np.tile(radii, words.teeth)
    ring = np.stack([radius * np.cos(angle), np.zeros(len(angle)), -radius * np.sin(angle)], -1)
    bevel = 2.0 * BEVEL_FRACTION * words.height
    inward = 1.0 - bevel / words.radius
    return _bevelled_rings(ring, ring * np.array([inward, 1.0, inward]), words.height / 2.0, bevel)


def _ball(words: BallShape) -> Solid:
    """Return a ball."""
    return ball_solid(np.zeros(3), words.radius)


SHAPE_SOLIDS: dict[type[Any], Callable[[Any], Solid]] = {
    BoxShape: _box,
    CylinderShape: _cylinder,
    BallShape: _ball,
    ConeShape: _cone,
    GearShape: _gear,
}


def prop_solid(words: Shape) -> Solid:
    """Return the solid of a shape."""
    return SHAPE_SOLIDS[type(words)](words)


def prop_depth(words: Shape) -> float:
    """Return how far a shape reaches below its middle [m]."""
    return -float(prop_solid(words).vertices[:, 1].min())
