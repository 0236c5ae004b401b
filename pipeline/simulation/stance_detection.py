"""Foot contacts: where a take's poses show that feet rest on the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.mechanism import Leg
from pipeline.simulation.spatial import Array, matrix, turn
from pipeline.simulation.take import Take
from pipeline.simulation.terrain.heightfield import surface_of_vertices

RESTING_SPEED = 0.004
"""Speed below which a foot rests [leg lengths/s]."""

RESTING_CLEARANCE = 0.03
"""Height above the ground up to which a foot can rest [leg lengths]."""


def foot_path(take: Take, leg: Leg) -> Array:
    """Return the tip of a leg in every row (K, 3) [m]."""
    node = first_node(take, leg.performer) + leg.link
    return take.positions[:, node] + turn(matrix(take.rotations[:, node]), np.array(leg.tip))


def first_node(take: Take, performer: str) -> int:
    """Return the number of a performer's first node."""
    return [node.performer for node in take.nodes].index(performer)


def ground_below(take: Take, path: Array) -> Array:
    """Return the height of the terrain (K,) below points (K, 3) [m]."""
    terrain = surface_of_vertices(take.terrain.vertices, take.terrain.cells)
    return terrain.height(path[:, 0], path[:, 2])


def resting_rows(take: Take, leg: Leg, path: Array, ground: Array) -> NDArray[np.bool_]:
    """Return whether a foot rests between each row and the next (K - 1,).

    Args:
        take: what happened.
        leg: of the foot.
        path: (K, 3) of its tip [m].
        ground: (K,) height of the ground below it [m].
    """
    row = 1.0 / float(take.header.rate * take.header.samples)
    still = np.linalg.norm(np.diff(path, axis=0), axis=-1) < RESTING_SPEED * leg.length * row
    above = path[:, 1] - ground - leg.sole
    return still & (above[1:] < RESTING_CLEARANCE * leg.length)
