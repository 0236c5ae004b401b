"""Obstacles: the solids that troupes show one another.

Every visible part that follows one node is a solid: the convex hull of what is seen of it.
How fast it moves follows from its node's poses; what it weighs nobody asks yet, for those
who show solids push and are not pushed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Part
from pipeline.simulation.troupe import Inventory

DIRECTIONS = 96
"""A solid keeps the corners that are farthest in one of so many directions."""

FLAT = 1e-4
"""Extent below which there is no solid [m]."""


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A convex solid that follows a node.

    Attributes:
        node: its number in the take.
        name: of the part.
        performer: whose it is.
        material: its.
        corners: (V, 3) in the frame of the node [m].
    """

    node: int
    name: str
    performer: str
    material: str
    corners: Array


def obstacles_of(inventories: Sequence[Inventory]) -> list[Obstacle]:
    """Return the solids of troupes, whose nodes stand in the take in this order."""
    found, first = list[Obstacle](), 0
    for inventory in inventories:
        for part in inventory.parts:
            obstacle = _obstacle(inventory, part, inventory.meshes[part.mesh], first)
            if obstacle is not None:
                found.append(obstacle)
        first += len(inventory.nodes)
    return found


def _obstacle(inventory: Inventory, part: Part, mesh: Mesh, first: int) -> Obstacle | None:
    node = int(mesh.nodes[0, 0])
    if not (mesh.nodes == node).all():
        return None
    corners = _outermost(mesh.vertices.astype(float) - inventory.nodes[node].rest)
    if float(np.ptp(corners, axis=0).min()) < FLAT:
        return None
    return Obstacle(first + node, part.name, part.performer, part.material, corners)


def _outermost(points: Array) -> Array:
    """Return those of points (n, 3) that are farthest in one of many directions."""
    i = np.arange(DIRECTIONS) + 0.5
    y = 1.0 - 2.0 * i / DIRECTIONS
    turn = i * (math.pi * (3.0 - math.sqrt(5.0)))
    across = np.sqrt(1.0 - y * y)
    ways = np.stack([across * np.cos(turn), y, across * np.sin(turn)], axis=1)
    along = (points[:, None, :] * ways).sum(axis=-1)
    result: Array = points[np.unique(np.argmax(along, axis=0))]
    return result
