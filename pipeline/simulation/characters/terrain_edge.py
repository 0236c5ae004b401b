"""Terrain edge: places to run to that lie on the terrain."""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.spatial import Array

EDGE_MARGIN = 0.9  # from the edge of the terrain [m]
EDGE_RANGE = 3.5  # from the edge of the terrain within which one turns away from it [m]


def refuge(at: Array, low: Array, high: Array, push: Array, distance: float) -> Array:
    """Return the place (2,) in a direction, turned away from the edge of the terrain.

    Args:
        at: (2,) present place [m].
        low: (2,) least x and z of the terrain [m].
        high: (2,) greatest x and z of the terrain [m].
        push: (2,) the direction.
        distance: to the place [m].
    """
    below = at - low - EDGE_MARGIN
    above = high - EDGE_MARGIN - at
    # As walls that push the more the nearer they are.
    wall = 1.0 / np.maximum(below, 0.3) - 1.0 / np.maximum(above, 0.3)
    walls = np.where(np.minimum(below, above) < EDGE_RANGE, 1.6 * wall, 0.0)
    push = push / max(math.hypot(push[0], push[1]), 1e-6)
    into_wall = float(push @ walls) < 0.0
    if into_wall and bool((np.minimum(below, above) < 0.5 * EDGE_RANGE).any()):
        # Along the wall, not to and fro in front of it.
        push = push + 0.8 * np.array([-push[1], push[0]])
    way = push + walls
    place: Array = at + distance * way / max(math.hypot(way[0], way[1]), 1e-6)
    return place
