"""Obstacles: the solids that troupes show one another.

Every visible part that follows one node is a solid: the convex hull of what is seen of it. Who is
seen as a skin over many nodes gives solids of its own.
How fast it moves follows from its node's poses. Those who show solids push and are not
pushed, but for bodies that meet whatever there is, which say what they weigh.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.solid import Obstacle
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Part
from pipeline.simulation.troupe import Inventory

DIRECTIONS = 96
"""A solid keeps the corners that are farthest in one of so many directions."""

FLAT = 1e-4
"""Extent below which there is no solid [m]."""


def obstacles_of(inventories: Sequence[Inventory]) -> list[Obstacle]:
    """Return the solids of troupes, whose nodes stand in the take in this order."""
    found, first = list[Obstacle](), 0
    for inventory in inventories:
        found += [replace(one, node=first + one.node) for one in inventory.solids]
        given = {first + one.node for one in inventory.solids}
        for part in inventory.parts:
            obstacle = _obstacle(inventory, part, inventory.meshes[part.mesh], first)
            if obstacle is not None and obstacle.node not in given:
                found.append(obstacle)
        first += len(inventory.nodes)
    return found


def _obstacle(inventory: Inventory, part: Part, mesh: Mesh, first: int) -> Obstacle | None:
    node = int(mesh.nodes[0, 0])
    if not (mesh.nodes == node).all():
        return None
    corners = outermost(mesh.vertices.astype(float) - inventory.nodes[node].rest)
    if float(np.ptp(corners, axis=0).min()) < FLAT:
        return None
    return Obstacle(first + node, part.name, part.performer, part.material, corners)


def outermost(points: Array, count: int = DIRECTIONS) -> Array:
    """Return those of points (n, 3) that are farthest in one of `count` directions."""
    along = (points[:, None, :] * directions(count)).sum(axis=-1)
    result: Array = points[np.unique(np.argmax(along, axis=0))]
    return result


def directions(count: int = DIRECTIONS) -> Array:
    """Return directions (count, 3) that are about as far from one another everywhere."""
    i = np.arange(count) + 0.5
    y = 1.0 - 2.0 * i / count
    turn = i * (math.pi * (3.0 - math.sqrt(5.0)))
    across = np.sqrt(1.0 - y * y)
    return np.stack([across * np.cos(turn), y, across * np.sin(turn)], axis=1)
