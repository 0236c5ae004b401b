"""Solid: what troupes show one another of what they move, where it is, and how it is pushed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class Weight:
    """What a solid that gives way is, about its centre of mass.

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
        performer: whose it is.
        material: its.
        corners: (V, 3) in the frame of the node [m].
        weight: None if it pushes and is not pushed.
    """

    node: int
    name: str
    performer: str
    material: str
    corners: Array
    weight: Weight | None = None


@dataclass(frozen=True, eq=False)
class Motion:
    """Where S solids are, and how fast.

    Attributes:
        p: (S, 3) their nodes [m].
        R: (S, 3, 3).
        v: (S, 3) [m/s].
        w: (S, 3) in the world [rad/s].
        here: (S,) whether they are there.
        borne: (S,) whether something bears them that those who push them are no part of.
    """

    p: Array
    R: Array
    v: Array
    w: Array
    here: NDArray[np.bool_]
    borne: NDArray[np.bool_]
