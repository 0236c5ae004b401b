"""Linkage: rigid links connected by hinges with servos, and sites pulled through space.

A description; `mujoco_linkage` simulates it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from pipeline.simulation.spatial import Array

CollisionGroup = Literal["limb", "trunk", "nothing"]
"""Collision groups: limbs collide with limbs and trunks; trunks collide with limbs only."""


@dataclass(frozen=True, eq=False)
class Hinge:
    """One degree of freedom, with the servo that drives it.

    Attributes:
        name: unique.
        axis: (3,) of unit length, at rest.
        lower: least angle [rad].
        upper: greatest angle [rad].
        stiffness: of the servo [N m/rad].
        damping: of the servo [N m s/rad].
        strength: greatest torque of the servo [N m].
    """

    name: str
    axis: Array
    lower: float
    upper: float
    stiffness: float
    damping: float
    strength: float


@dataclass(frozen=True, eq=False)
class Capsule:
    """A capsule of a link: all points within `radius` of a line.

    Attributes:
        name: unique.
        ends: (2, 3) ends of the line at rest [m].
        radius: [m].
        meets: collision group.
    """

    name: str
    ends: Array
    radius: float
    meets: CollisionGroup = "nothing"


@dataclass(frozen=True, eq=False)
class Disc:
    """A fixed upright cylinder that is struck from above.

    Attributes:
        name: unique.
        middle: (3,) centre [m].
        radius: [m].
        height: [m].
    """

    name: str
    middle: Array
    radius: float
    height: float


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid link; its mass is distributed evenly over its solids.

    Attributes:
        name: unique.
        parent: number of the parent link, -1 for the fixed base.
        place: (3,) of its hinges at rest [m].
        mass: [kg]; without effect on a fixed link.
        hinges: from the parent outward, each turning the next; none for a fixed link.
        solids: its capsules.
        weightless: whether gravity is compensated.
    """

    name: str
    parent: int
    place: Array
    mass: float
    hinges: tuple[Hinge, ...] = ()
    solids: tuple[Capsule, ...] = ()
    weightless: bool = False


@dataclass(frozen=True, eq=False)
class Site:
    """A point on a link, -1 for the fixed base; `place` (3,) at rest [m]."""

    name: str
    link: int
    place: Array


@dataclass(frozen=True, eq=False)
class Linkage:
    """Links, sites and discs.

    Attributes:
        links: parents first.
        sites: points of interest, in the order of their links.
        pulled: names of the sites that a force can pull.
        drag: c of these forces, c (v_desired - v) [N s/m].
        most_force: greatest force along each axis [N].
        apart: pairs of names of links that never collide.
        discs: fixed discs.
    """

    links: tuple[Link, ...]
    sites: tuple[Site, ...]
    pulled: tuple[str, ...]
    drag: float
    most_force: float
    apart: tuple[tuple[str, str], ...] = ()
    discs: tuple[Disc, ...] = field(default=())

    @property
    def hinges(self) -> tuple[Hinge, ...]:
        """All hinges, link by link."""
        return tuple(hinge for link in self.links for hinge in link.hinges)
