"""Sole: how high the ball at a leg's tip must be to touch the ground, but no more.

The ball is looked at on rings around its lowest point, so that it clears what rises
beside it as well.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

RINGS = np.array([0.55, 0.92, 1.0])
"""Radii of the rings, in that of the ball; the last one feels walls."""

_ANGLES = np.arange(8) * (np.pi / 4.0)
_OUT = np.concatenate(
    [np.zeros((1, 2)), *(r * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1) for r in RINGS)]
)
_OUT_X, _OUT_Z = np.ascontiguousarray(_OUT.T)
_DOWN = np.sqrt(1.0 - (_OUT**2).sum(axis=-1))


def lowest(ground: Ground, x: Array, z: Array, sole: Array | float) -> Array:
    """Return the least heights (...) of a ball's middle at places x, z (...) [m].

    Args:
        ground: what it is not to sink into.
        x: places of its middle along x and
        z: along z, of equal shapes [m].
        sole: its radius, or those of all places [m].
    """
    radius = np.asarray(sole)[..., None]
    around = ground.height(x[..., None] + radius * _OUT_X, z[..., None] + radius * _OUT_Z)
    result: Array = (around + radius * _DOWN).max(axis=-1)
    return result
