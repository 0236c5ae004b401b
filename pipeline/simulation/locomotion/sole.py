"""Sole: how high the ball at a leg's tip must be to touch the ground, but no more.

The ball is looked at on rings around its lowest point, so that it clears what rises
beside it as well.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

RINGS = np.array([0.55, 0.92])
"""Radii of the rings, in that of the ball."""

_ANGLES = np.arange(8) * (np.pi / 4.0)
_OUT = np.concatenate(
    [np.zeros((1, 2)), *(r * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1) for r in RINGS)]
)
_DOWN = np.sqrt(1.0 - (_OUT**2).sum(axis=-1))


def lowest(ground: Ground, x: Array, z: Array, sole: float) -> Array:
    """Return the least heights (n,) of a ball's middle at places x, z (n,) [m].

    Args:
        ground: what it is not to sink into.
        x: (n,) and
        z: (n,) places of its middle [m].
        sole: its radius [m].
    """
    around = ground.height(x[:, None] + sole * _OUT[:, 0], z[:, None] + sole * _OUT[:, 1])
    result: Array = (around + sole * _DOWN).max(axis=-1)
    return result
