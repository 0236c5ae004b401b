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
"""Sides of round shapes."""

BEVEL_FRACTION = 0.04
"""Bevel of edges, relative to the least extent: sharp edges catch no light and look cut out."""


def _box(config: BoxShape) -> Solid:
    x, y, z = (extent / 2.0 for extent in config.size)
    bevel = BEVEL_FRACTION * min(config.size)
    # A rectangle with its corners cut, turning from +z to +x.
    outer = [(bevel - x, z), (x - bevel, z), (x, z - bevel), (x, bevel - z)]
    outer += [(-a, -b) for a, b in outer]
    ring = np.array([[a, 0.0, b] for a, b in outer])
    inward = np.array([(x - bevel) / x, 1.0, (z - bevel) / z])
    return _bevelled_rings(ring, ring * inward, y, bevel)


def _cylinder(config: CylinderShape) -> Solid:
    bevel = BEVEL_FRACTION * min(2.0 * config.radius, config.height)
    angle = np.arange(CYLINDER_SIDES) * (2.0 * np.pi / CYLINDER_SIDES)
    ring = np.stack([np.sin(angle), np.zeros(CYLINDER_SIDES), np.cos(angle)], axis=-1)
    rings = config.radius * ring, (config.radius - bevel) * ring
    return _bevelled_rings(*rings, config.height / 2.0, bevel)


def _bevelled_rings(outer: Array, inner: Array, half: float, bevel: float) -> Solid:
    """Returns a solid between rings (n, 3), turning from z to x: `inner` at both ends."""
    levels = (inner, -half), (outer, bevel - half), (outer, half - bevel), (inner, half)
    rings = np.stack([ring + np.array([0.0, y, 0.0]) for ring, y in levels])
    return loft(rings, rings[[0, -1]].mean(axis=1))


def _cone(config: ConeShape) -> Solid:
    half, low, high = config.height / 2.0, config.radius, config.top
    bevel = BEVEL_FRACTION * min(2.0 * low, config.height)
    least = 0.02 * low  # A slightly rounded tip.
    profile = [(low - bevel, -half), (low, bevel - half), (max(high, least), half - 0.5 * bevel)]
    profile.append((max(high - bevel, 0.5 * least), half))
    angle = np.arange(CYLINDER_SIDES) * (2.0 * np.pi / CYLINDER_SIDES)
    ring = np.stack([np.sin(angle), np.zeros(CYLINDER_SIDES), np.cos(angle)], axis=-1)
    rings = np.stack([radius * ring + np.array([0.0, y, 0.0]) for radius, y in profile])
    return loft(rings, rings[[0, -1]].mean(axis=1))


def _gear(config: GearShape) -> Solid:
    """Returns a gear wheel with straight flanks, one of its teeth along +X."""
    pitch = 2.0 * np.pi / config.teeth
    # Tooth depth 2.1 modules; half of the pitch is tooth at mid-height.
    module = 2.0 * config.radius / config.teeth
    outer, inner = config.radius + 0.95 * module, config.radius - 1.15 * module
    flanks = np.array([-0.31, -0.12, 0.12, 0.31]) * pitch
    radii = np.array([inner, outer, outer, inner])
    # Rings turn from +z to +x.
    angle = (pitch * np.arange(config.teeth)[:, None] + flanks).ravel()
    radius = np.tile(radii, config.teeth)
    ring = np.stack([radius * np.cos(angle), np.zeros(len(angle)), -radius * np.sin(angle)], -1)
    bevel = 2.0 * BEVEL_FRACTION * config.height
    inward = 1.0 - bevel / config.radius
    return _bevelled_rings(ring, ring * np.array([inward, 1.0, inward]), config.height / 2.0, bevel)


def _ball(config: BallShape) -> Solid:
    return ball_solid(np.zeros(3), config.radius)


SHAPE_SOLIDS: dict[type[Any], Callable[[Any], Solid]] = {
    BoxShape: _box,
    CylinderShape: _cylinder,
    BallShape: _ball,
    ConeShape: _cone,
    GearShape: _gear,
}


def prop_solid(config: Shape) -> Solid:
    """Returns the solid of a shape."""
    return SHAPE_SOLIDS[type(config)](config)


def prop_depth(config: Shape) -> float:
    """Returns the depth of a shape below its centre [m]."""
    return -float(prop_solid(config).vertices[:, 1].min())
