"""Bones: the rigid bodies of a ragdoll and the joints between them, as plain arrays.

How flesh holds a joint follows from what hangs on it: a mass m whose radius of gyration about
the joint is l swings with √(g / l) and weighs m g l at most, which stiffness and damping
are parts of. So a ragdoll falls limply in the same way at any scale.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties, joined
from pipeline.simulation.spatial import Array

WORLD = -1
"""In place of a bone: what the first one hangs on."""

STIFF, DAMPED, HEAVY = 0.12, 0.4, 0.1
"""How joints are drawn to their rest and damped, in parts of the weight that hangs on them and of
what damps it critically; inertia that they have besides, in that of what hangs on them: a thin
tail is easily twisted, and would be by a body that lies on it."""


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """One degree of freedom.

    Attributes:
        axis: (3,) in the creation frame, of length one.
        slides: whether it slides along its axis instead of turning about it.
        lower, upper: limits [rad or m].
        rest: where flesh draws it [rad or m].
    """

    axis: Array
    slides: bool
    lower: float
    upper: float
    rest: float


@dataclass(frozen=True, slots=True, eq=False)
class Bone:
    """A rigid body, in the creation frame, in which all joint values are zero.

    Attributes:
        parent: number of the bone that it hangs on, a lower one; `WORLD` for the first.
        place: (3,) of its joints [m].
        joints: from the parent outward, none of the first, which moves freely.
        mass: of it.
        corners: (V, 3) of its convex hull [m].
    """

    parent: int
    place: Array
    joints: tuple[Joint, ...]
    mass: MassProperties
    corners: Array


@dataclass(frozen=True, slots=True)
class Flesh:
    """What holds the joints of a bone, in the units of what turns; see `of_sliding`.

    Attributes:
        stiffness: [N m/rad].
        damping: [N m s/rad].
        inertia: [kg m²].
        length: by which what slides is divided [m].
    """

    stiffness: float
    damping: float
    inertia: float
    length: float

    def of_sliding(self) -> Flesh:
        """Return the same for a joint that slides, [N/m], [N s/m] and [kg]."""
        one = self.length
        return Flesh(self.stiffness / one**2, self.damping / one**2, self.inertia / one**2, one)


def flesh_of(bones: Sequence[Bone]) -> list[Flesh]:
    """Return what holds each bone to its parent; of the first one it means nothing."""
    beyond: list[list[MassProperties]] = [[bone.mass] for bone in bones]
    for i in reversed(range(1, len(bones))):
        beyond[bones[i].parent] += beyond[i]
    return [_flesh(joined(masses), bone.place) for bone, masses in zip(bones, beyond, strict=True)]


def _flesh(hangs: MassProperties, place: Array) -> Flesh:
    length = math.sqrt(0.5 * float(np.trace(hangs.about(place))) / hangs.mass)
    weight = hangs.mass * GRAVITY * length
    critical = 2.0 * hangs.mass * length**2 * math.sqrt(GRAVITY / length)
    return Flesh(STIFF * weight, DAMPED * critical, HEAVY * hangs.mass * length**2, length)


def size_of(bones: Sequence[Bone]) -> float:
    """Return the greatest extent of a ragdoll as it was created [m]."""
    corners = np.concatenate([bone.corners for bone in bones])
    return float(np.ptp(corners, axis=0).max())
