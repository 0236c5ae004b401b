"""Linkage: rigid links that hinges join, each hinge with a servo, some places pulled through space.

A description alone; `mujoco_linkage.py` moves it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from pipeline.simulation.spatial import Array

Meets = Literal["limb", "trunk", "nothing"]
"""Limbs meet limbs and trunks; trunks meet limbs alone."""


@dataclass(frozen=True, eq=False)
class Hinge:
    """One degree of freedom, with the servo that drives it.

    Attributes:
        name: unique.
        axis: (3,) of unit length, at rest.
        lower: least angle [rad].
        upper: greatest angle [rad].
        stiffness: of its servo [N m/rad].
        damping: of its servo [N m s/rad].
        strength: greatest torque of its servo [N m].
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
    """A round solid of a link: all that is within `radius` of the line between two ends.

    Attributes:
        name: unique.
        ends: (2, 3) at rest [m].
        radius: [m].
        meets: what it meets.
    """

    name: str
    ends: Array
    radius: float
    meets: Meets = "nothing"


@dataclass(frozen=True, eq=False)
class Disc:
    """An upright cylinder that stands still and is struck from above.

    Attributes:
        name: unique.
        middle: (3,) of it [m].
        radius: [m].
        height: [m].
    """

    name: str
    middle: Array
    radius: float
    height: float


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid link; its mass is spread evenly over its solids.

    Attributes:
        name: unique.
        parent: number of the link it hangs on, -1 for what stands still.
        place: (3,) of its hinges at rest [m].
        mass: [kg]; of what stands still it does not matter.
        hinges: from its parent on, the first turning the others; without any it is fixed.
        solids: that it consists of.
        weightless: whether its weight is compensated.
    """

    name: str
    parent: int
    place: Array
    mass: float
    hinges: tuple[Hinge, ...] = ()
    solids: tuple[Capsule, ...] = ()
    weightless: bool = False


@dataclass(frozen=True, eq=False)
class Spot:
    """A place that goes with a link, -1 for what stands still; `place` (3,) at rest [m]."""

    name: str
    link: int
    place: Array


@dataclass(frozen=True, eq=False)
class Linkage:
    """All of it.

    Attributes:
        links: parents first.
        spots: places whose way matters, those of a link after those of the links before it.
        pulled: names of the spots that a force can pull.
        drag: c of these forces, c (v_desired - v) [N s/m].
        most_force: greatest along each axis [N].
        apart: pairs of names of links that never meet one another.
        discs: that stand about it.
    """

    links: tuple[Link, ...]
    spots: tuple[Spot, ...]
    pulled: tuple[str, ...]
    drag: float
    most_force: float
    apart: tuple[tuple[str, str], ...] = ()
    discs: tuple[Disc, ...] = field(default=())

    @property
    def hinges(self) -> tuple[Hinge, ...]:
        """All hinges, link by link."""
        return tuple(hinge for link in self.links for hinge in link.hinges)
