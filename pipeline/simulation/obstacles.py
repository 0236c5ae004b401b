"""Obstacles: convex solids that troupes show one another, and their motion.

Every visible part that follows one node is an obstacle: its convex hull. A skin over many nodes
gives separate solids. The velocity follows from the poses of the node. Obstacles push and are not
pushed, except bodies with an `ObstacleMass`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array

HULL_DIRECTIONS = 96
"""A solid keeps its farthest corner in each of so many directions."""


@dataclass(frozen=True, eq=False)
class ObstacleMass:
    """Mass and contact properties of an obstacle that gives way, about its centre of mass.

    Attributes:
        mass: [kg].
        inverse_inertia: (3, 3) in its own frame [1/(kg m²)].
        friction: Coulomb's coefficient.
        bounciness: speed after / before an impact.
    """

    mass: float
    inverse_inertia: Array
    friction: float
    bounciness: float


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A convex solid that follows a node.

    Attributes:
        node: its number in the take.
        name: of the part.
        performer: name of the performer.
        material: by name.
        corners: (V, 3) in the frame of the node [m].
        mass_properties: None if it pushes and is not pushed.
    """

    node: int
    name: str
    performer: str
    material: str
    corners: Array
    mass_properties: ObstacleMass | None = None


@dataclass(frozen=True, eq=False)
class SolidMotion:
    """Pose and velocity of S solids.

    Attributes:
        p: (S, 3) positions of their nodes [m].
        R: (S, 3, 3).
        v: (S, 3) [m/s].
        w: (S, 3) in the world [rad/s].
        is_present: (S,) whether a solid exists now.
        is_supported: (S,) whether a solid is supported by something other than those that push it.
        gives_way: (S,) whether a solid with a mass gives way now.
    """

    p: Array
    R: Array
    v: Array
    w: Array
    is_present: NDArray[np.bool_]
    is_supported: NDArray[np.bool_]
    gives_way: NDArray[np.bool_]

    def selected(self, mask: NDArray[np.bool_]) -> SolidMotion:
        """Returns the motion of some of the solids."""
        return SolidMotion(
            *(self.p[mask], self.R[mask], self.v[mask], self.w[mask]),
            *(self.is_present[mask], self.is_supported[mask], self.gives_way[mask]),
        )

    def joined(self, other: SolidMotion) -> SolidMotion:
        """Returns the motion of these solids followed by that of others."""
        return SolidMotion(
            np.concatenate([self.p, other.p]),
            np.concatenate([self.R, other.R]),
            np.concatenate([self.v, other.v]),
            np.concatenate([self.w, other.w]),
            np.concatenate([self.is_present, other.is_present]),
            np.concatenate([self.is_supported, other.is_supported]),
            np.concatenate([self.gives_way, other.gives_way]),
        )


def outermost(points: Array, count: int = HULL_DIRECTIONS) -> Array:
    """Returns those of points (n, 3) that are farthest in one of `count` directions."""
    along = (points[:, None, :] * directions(count)).sum(axis=-1)
    return points[np.unique(np.argmax(along, axis=0))]


@cache
def directions(count: int = HULL_DIRECTIONS) -> Array:
    """Returns unit vectors (count, 3), spread evenly over the sphere (Fibonacci lattice)."""
    i = np.arange(count) + 0.5
    y = 1.0 - 2.0 * i / count
    turn = i * (math.pi * (3.0 - math.sqrt(5.0)))
    across = np.sqrt(1.0 - y * y)
    result = np.stack([across * np.cos(turn), y, across * np.sin(turn)], axis=1)
    result.flags.writeable = False  # It is shared.
    return result
