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
    x, z = (float(c) for c in push)
    size = max(math.hypot(x, z), 1e-6)
    x, z = x / size, z / size
    gaps = [(at[k] - low[k] - EDGE_MARGIN, high[k] - EDGE_MARGIN - at[k]) for k in range(2)]
    # As walls that push the more the nearer they are.
    wall_x, wall_z = (
        1.6 * (1.0 / max(below, 0.3) - 1.0 / max(above, 0.3))
        if min(below, above) < EDGE_RANGE
        else 0.0
        for below, above in gaps
    )
    if x * wall_x + z * wall_z < 0.0 and min(map(min, gaps)) < 0.5 * EDGE_RANGE:
        # Along the wall, not to and fro in front of it.
        x, z = x - 0.8 * z, z + 0.8 * x
    x, z = x + wall_x, z + wall_z
    share = distance / max(math.hypot(x, z), 1e-6)
    return np.array([at[0] + share * x, at[1] + share * z])
