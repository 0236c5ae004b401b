"""Mechanism: joints, masses, stances and part names of creatures, as a take records them."""

from __future__ import annotations

from dataclasses import dataclass

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Mechanism:
    """Joints and masses of a figure with J joints, in the creation frame.

    Attributes:
        performers: creatures that have this figure at this scale.
        joints: (J,) names, such as "l1.base_yaw".
        parents: (J,) joint before each, -1 for joints on the body.
        axes: (J, 3) unit axes.
        places: (J, 3) positions [m].
        prismatic: (J,) whether a joint slides along its axis instead of turning about it.
        masses: (J + 1,) of the links on each joint, and of the body last [kg].
        centres: (J + 1, 3) centres of mass relative to the joint [m].
        inertias: (J + 1, 3, 3) about the centres of mass [kg m²].
    """

    performers: tuple[str, ...]
    joints: tuple[str, ...]
    parents: tuple[int, ...]
    axes: tuple[Vector, ...]
    places: tuple[Vector, ...]
    prismatic: tuple[bool, ...]
    masses: tuple[float, ...]
    centres: tuple[Vector, ...]
    inertias: tuple[tuple[Vector, Vector, Vector], ...]


@dataclass(frozen=True, slots=True)
class Leg:
    """One leg of a creature and its planned stances.

    Attributes:
        performer: name of the creature.
        name: of the leg, such as "l1".
        side: "l", "r" or "m".
        link: number of the foot's node among those of the performer.
        joint: number of the last joint.
        tip: of the foot relative to its node, at rest [m].
        length: of the stretched leg [m].
        sole: radius of the tip [m].
        stances: (n, 2) phases of the gait from foot-down to foot-up, whole cycles counted.
    """

    performer: str
    name: str
    side: str
    link: int
    joint: int
    tip: Vector
    length: float
    sole: float
    stances: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class NodeAlias:
    """Another name of a node: that of a node of its creature's drawing.

    Attributes:
        name: such as "bug.knee1_l".
        node: number of the node, -1 for none.
    """

    name: str
    node: int
