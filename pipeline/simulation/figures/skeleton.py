"""The skeleton of a figure: its nodes laid out in three dimensions, joints and links.

An insect stays flat as drawn. A mammal's body may be raised at its front, and its legs and arms
are folded down: the direction from a limb's base to its tip becomes down, and what was drawn
towards the head of a sideways limb becomes forward.

A joint is a place and an axis in the creation frame, in which the figure lies as drawn with all
joint values zero. A ball joint is three joints at one place. Link 0 is the body; every other link
hangs on one joint.

Source: Sims 1987, 4.2 (axes by style), eq. 4.1 (its -y_c up is left-handed for a drawing seen from
above; X forward, Y up, Z right is right-handed), 5.1 and 5.2 (axis and position).
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.drawing import Drawing
from pipeline.simulation.figures.joint_limits import (
    JointRange,
    apply_joint_overrides,
    insect_joint_ranges,
    mammal_joint_ranges,
    raised_neck,
)
from pipeline.simulation.figures.limb_guesses import midline
from pipeline.simulation.figures.network import (
    ARM,
    HEAD,
    LEG,
    TAIL,
    Anatomy,
    Appendage,
)
from pipeline.simulation.spatial import UP, Array, normalized, rotation
from pipeline.spec.figure import Figure as FigureConfig
from pipeline.spec.figure import LinkShape

FOLDED_KINDS = (LEG, ARM)
"""Kinds of appendage that a mammal folds down."""

SIDEWAYS = np.array([0.0, 0.0, 1.0])
"""Axis about which a mammal's limbs swing and bend."""


FORWARD = np.array([1.0, 0.0, 0.0])

UPRIGHT_SINE = 0.9
"""Sine of the elevation beyond which a limb stands or hangs: no axis in the drawing plane is
across it."""

SPLAY = 0.7
"""How far from the midline feet stand whose legs hang on it, in the body's radius there."""

LEVEL = 30.0
"""Greatest pitch of a body whose neck has to be raised for its head to be up [degrees]."""

ON_MIDLINE = 1e-9
"""Distance from the midline of what is drawn on it, beside rounding [m]."""

MIN_RADIUS_RATIO = 1e-6
"""Least radius of a link, in its length."""

BODY = -1
"""Number in place of a joint: the body, which no joint moves."""


def lay_out_nodes(config: FigureConfig, drawing: Drawing, anatomy: Anatomy, scale: float) -> Array:
    """Return the nodes (n, 3) in the creation frame [m].

    Its origin is the mean of the nodes that carry legs, or of the body.
    """
    points: Array = drawing.creation() * scale
    carried = [a.nodes[0] for a in anatomy.of_kind(LEG)] or list(anatomy.body)
    points = points - points[sorted(set(carried))].mean(axis=0)
    if config.style == "insect":
        return points
    points = points @ rotation(SIDEWAYS, math.radians(config.pitch_deg)).T
    for appendage in anatomy.appendages:
        if appendage.kind in FOLDED_KINDS:
            _fold_limb(points, drawing, appendage, scale)
    return points


def drawing_normal(config: FigureConfig, kind: str) -> Array:
    """Return the unit normal (3,) of the plane that appendages of a kind were drawn in.

    It points up as drawn; for a mammal's legs and arms it is folded down with them.
    """
    if config.style == "insect":
        return UP
    if kind in FOLDED_KINDS:
        return SIDEWAYS
    return rotation(SIDEWAYS, math.radians(config.pitch_deg)) @ UP


def _fold_limb(points: Array, drawing: Drawing, appendage: Appendage, scale: float) -> None:
    """Put all nodes of a limb below its base."""
    base, rest = appendage.nodes[0], list(appendage.nodes[1:])
    drawn = (drawing.places[rest] - drawing.places[base]) * scale
    # A limb drawn back to its base only has the direction of its first link.
    to_tip = drawn[-1] if np.linalg.norm(drawn[-1]) > 1e-6 * np.abs(drawn).max() else drawn[0]
    down = to_tip / np.linalg.norm(to_tip)
    # A quarter turn that takes outward to headward on either side.
    left = drawing.places[base][0] + to_tip[0] / scale <= 0.0
    forward = np.array([-down[1], down[0]]) if left else np.array([down[1], -down[0]])
    points[rest] = points[base]
    points[rest, 1] -= drawn @ down
    points[rest, 0] += drawn @ forward


@dataclass(frozen=True, eq=False)
class Link:
    """A solid between two nodes.

    Attributes:
        name: such as "l1.2", the second link of the first left leg.
        kind: body, leg, arm, head, tail, feeler, horn or wing.
        joint: that moves it; `BODY` for the body.
        ends: (2, 3) its nodes in the creation frame [m].
        radii: of the solid at both ends [m].
        material: name; empty for the performer's own.
        is_tip: whether its second end is the tip of an appendage.
        shape: of its solid.
        normal: (3,) unit normal of the plane that it was drawn in.
    """

    name: str
    kind: str
    joint: int
    ends: Array
    radii: tuple[float, float]
    material: str
    is_tip: bool
    shape: LinkShape = "round"
    normal: Array = field(default_factory=UP.copy)

    @property
    def limb(self) -> str:
        """Name of the limb that it belongs to, or "body"."""
        return self.name.rpartition(".")[0] or self.name


@dataclass(frozen=True, eq=False)
class Limb:
    """A chain of joints from a base to a tip, for inverse kinematics.

    Attributes:
        name: "l1", "r2", "head", ...
        kind: leg, arm, head, tail, feeler, horn or wing.
        side: "l", "r" or "m".
        joints: joint numbers from base to tip.
        links: link numbers from base to tip.
        tip: (3,) in the creation frame [m].
        tip_radius: of the solid around the tip [m].
        length: from base to tip, stretched [m].
    """

    name: str
    kind: str
    side: str
    joints: tuple[int, ...]
    links: tuple[int, ...]
    tip: Array
    tip_radius: float
    length: float


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints, links and limbs of one figure; constant while it moves.

    Attributes:
        joint_names: such as "l1.hip_yaw".
        parents: (J,) joint before each; `BODY` for joints on the body.
        axes: (J, 3) unit axes in the creation frame.
        places: (J, 3) positions in the creation frame [m].
        prismatic: (J,) whether a joint slides along its axis instead of turning about it.
        lower, upper: (J,) limits [rad or m].
        preferred: (J,) values at rest [rad or m].
        extended: (J,) values at which limbs are straightest [rad or m].
        links: the body first.
        limbs: legs first, left before right, front to back.
    """

    joint_names: tuple[str, ...]
    parents: NDArray[np.int64]
    axes: Array
    places: Array
    prismatic: NDArray[np.bool_]
    lower: Array
    upper: Array
    preferred: Array
    extended: Array
    links: tuple[Link, ...]
    limbs: tuple[Limb, ...]

    @property
    def legs(self) -> tuple[Limb, ...]:
        """The limbs that walk."""
        return tuple(limb for limb in self.limbs if limb.kind == LEG)


@dataclass(slots=True)
class _Builder:
    """Collects joints and links, appendage by appendage."""

    style: str
    carrier: dict[int, int]  # node -> joint that moves the link it belongs to
    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    axes: list[Array] = field(default_factory=list)
    places: list[Array] = field(default_factory=list)
    ranges: list[JointRange] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    limbs: list[Limb] = field(default_factory=list)

    def joint(
        self, name: str, parent: int, axis: Array, place: Array, joint_range: JointRange
    ) -> int:
        self.names.append(name)
        self.parents.append(parent)
        self.axes.append(axis)
        self.places.append(place)
        self.ranges.append(joint_range)
        return len(self.names) - 1


def build_skeleton(
    config: FigureConfig, drawing: Drawing, anatomy: Anatomy, points: Array, scale: float
) -> Skeleton:
    """Return the joints and links of a figure.

    Axes of an insect's inner joints lie in the plane of the drawing, across the limb, so that its
    legs bend up and down; those of a mammal's legs point to the side. Hips, necks and roots are
    ball joints. (The thesis puts insect axes "perpendicular to the two links", which is undefined
    for straight legs and vertical for bent ones.)

    Args:
        config: style and joints of the figure.
        drawing: the flat network.
        anatomy: its parts.
        points: (n, 3) nodes in the creation frame [m].
        scale: factor from the drawing to the world.

    Raises:
        SceneError: `joints` names a joint that the figure lacks, or a link is too thin; the path
            starts there.
    """
    radii = drawing.radii * scale
    builder = _Builder(config.style, dict.fromkeys(anatomy.body, BODY))
    middle = points[list(anatomy.body)].mean(axis=0)
    girth = max((float(radii[n]) for n in anatomy.body), default=0.0)
    builder.links.append(
        Link("body", "body", BODY, np.stack([middle, middle]), (girth, girth), "", False)
    )
    splays = _splays(drawing, anatomy, radii)
    for name, side, appendage in _name_appendages(anatomy):
        normal = drawing_normal(config, appendage.kind)
        steps = np.diff(points[list(appendage.nodes)], axis=0)
        splay = splays.get(appendage.nodes[0], 0.0)
        own_ranges = _joint_ranges(config, name, side, appendage.kind, steps, splay)
        _add_limb(builder, name, side, appendage, points, radii, drawing, normal, own_ranges)
    joints = apply_joint_overrides(config.joints, builder.names, builder.ranges, scale)
    ranges = joints.ranges
    axes = np.array(builder.axes).reshape(-1, 3)
    for j in np.flatnonzero(joints.prismatic):
        axes[j] = _slide_axis(builder, int(j))
    return Skeleton(
        joint_names=tuple(builder.names),
        parents=np.array(builder.parents, dtype=np.int64),
        axes=axes,
        places=np.array(builder.places).reshape(-1, 3),
        prismatic=joints.prismatic,
        lower=np.array([s.lower for s in ranges]),
        upper=np.array([s.upper for s in ranges]),
        preferred=np.array([s.preferred for s in ranges]),
        extended=np.array([s.extended for s in ranges]),
        links=tuple(builder.links),
        limbs=tuple(builder.limbs),
    )


def _slide_axis(builder: _Builder, joint: int) -> Array:
    """Return the direction of a joint that slides: along its link.

    Raises:
        SceneError: it moves no link of its own, as all but the last joint of a ball joint.
    """
    moved = {link.joint: link for link in builder.links}
    last = next(j for j in range(joint, len(builder.names)) if j in moved)
    if last != joint:
        message = f"has no link to slide along; '{builder.names[last].rpartition('.')[2]}' has"
        raise SceneError([Problem(f"joints.{builder.names[joint]}", message)])
    ends = moved[joint].ends
    return normalized(ends[1] - ends[0])


def _splays(drawing: Drawing, anatomy: Anatomy, radii: Array) -> dict[int, float]:
    """Return by base how far its feet stand from the midline, for several legs that hang on it [m].

    Both legs of such a pair would stand in one place.
    """
    bases = Counter(leg.nodes[0] for leg in anatomy.of_kind(LEG))
    middle = midline(drawing)
    return {
        base: SPLAY * float(radii[base])
        for base, count in bases.items()
        if count > 1 and abs(float(drawing.places[base, 0]) - middle) <= ON_MIDLINE
    }


def _name_appendages(anatomy: Anatomy) -> list[tuple[str, str, Appendage]]:
    """Return each appendage with name and side: l1, l2, ..., r1, ..., head, tail, feeler_l1."""
    counts: dict[tuple[str, str], int] = {}
    named = []
    for appendage in anatomy.appendages:
        kind, side = appendage.kind, appendage.side
        # Heads and tails are numbered across sides.
        key = (kind, "" if kind in (HEAD, TAIL) else side)
        counts[key] = number = counts.get(key, 0) + 1
        if kind == LEG:
            name = f"{side}{number}"
        elif kind in (HEAD, TAIL):
            name = kind if number == 1 else f"{kind}{number}"
        else:
            name = f"{kind}_{side}{number}"
        named.append((name, side, appendage))
    return named


def _joint_ranges(
    config: FigureConfig, name: str, side: str, kind: str, steps: Array, splay: float
) -> list[dict[str, JointRange]]:
    """Return the joints at each node of a limb but its tip, before the author's settings."""
    if config.style == "insect":
        return insect_joint_ranges(kind, len(steps))
    ranges = mammal_joint_ranges(kind, side, steps, splay)
    # An author who writes down the joints of a neck poses it.
    raised = kind == HEAD and config.pitch_deg < LEVEL and name not in config.joints
    return raised_neck(ranges) if raised else ranges


def _add_limb(
    builder: _Builder,
    name: str,
    side: str,
    appendage: Appendage,
    points: Array,
    radii: Array,
    drawing: Drawing,
    normal: Array,
    ranges: list[dict[str, JointRange]],
) -> None:
    """Add the joints and links of one appendage, from its base outward."""
    nodes, materials = appendage.nodes, drawing.materials
    steps = np.diff(points[list(nodes)], axis=0)
    directions = normalized(steps)
    parent = builder.carrier[nodes[0]]
    joints, links = list[int](), list[int]()
    mammal = builder.style == "mammal"
    kind = appendage.kind
    for i, (node, after) in enumerate(itertools.pairwise(nodes)):
        # An inner joint's axis is across the mean direction of its two links.
        along = directions[i] if i == 0 else _mean_direction(directions[i - 1], directions[i])
        axes = _axes(along, mammal and kind in FOLDED_KINDS)
        girths = _link_radii(radii[[node, after]], i == 0, materials[after] != materials[node])
        _check_thickness(drawing, (node, after), girths, float(np.linalg.norm(steps[i])))
        for turn, joint_range in ranges[i].items():
            joint_name = f"{name}.{'base' if i == 0 else f'joint{i}'}_{turn}"
            parent = builder.joint(joint_name, parent, axes[turn], points[node], joint_range)
            joints.append(parent)
        builder.links.append(
            Link(
                f"{name}.{i + 1}",
                kind,
                parent,
                np.stack([points[node], points[after]]),
                girths,
                materials[after],
                after == nodes[-1],
                drawing.shapes[after],
                normal,
            )
        )
        links.append(len(builder.links) - 1)
        builder.carrier[after] = parent
    length = float(np.linalg.norm(steps, axis=-1).sum())
    tip = nodes[-1]
    builder.limbs.append(
        Limb(
            name,
            kind,
            side,
            tuple(joints),
            tuple(links),
            points[tip],
            float(radii[tip]),
            length,
        )
    )


def _axes(along: Array, folded: bool) -> dict[str, Array]:
    """Return the joint axes of a link that points `along`, by the name of the joint."""
    if folded or abs(along[1]) > UPRIGHT_SINE:
        return {"yaw": UP, "pitch": SIDEWAYS, "roll": FORWARD, "bend": SIDEWAYS}
    across = normalized(np.cross(along, UP))
    return {"yaw": UP, "pitch": across, "roll": along, "bend": across}


def _link_radii(radii: Array, is_root: bool, changes: bool) -> tuple[float, float]:
    """Return the radii of a link's solid between nodes of `radii` (2,) [m].

    At its root an appendage is no thicker than further on. Where the material changes it is
    thicker than the link before, so that the two meet in a clean line.
    """
    first, second = (float(radius) for radius in radii)
    if is_root:
        return min(first, 1.35 * second), second
    return (1.12 if changes else 1.0) * first, second


def _check_thickness(
    drawing: Drawing, nodes: tuple[int, int], girths: tuple[float, float], length: float
) -> None:
    """Refuse a link so thin that its volume is lost in rounding."""
    # A ball's stem may be as thin as the ball allows.
    is_ball = drawing.shapes[nodes[1]] == "ball"
    if (girths[1] if is_ball else max(girths)) >= MIN_RADIUS_RATIO * length:
        return
    before, name = (drawing.names[n] for n in nodes)
    message = f"the link from '{before}' to '{name}' is thinner than a millionth of its length"
    raise SceneError([Problem(drawing.path_of(name), f"{message}; give '{name}' a larger radius")])


def _mean_direction(before: Array, after: Array) -> Array:
    """Return the mean direction of two links; that of the first where they fold together."""
    mean: Array = before + after
    return normalized(mean) if np.linalg.norm(mean) > 1e-6 else before
