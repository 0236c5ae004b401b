"""Character plans: the nodes and links of each kind of character, and where they start.

A person has sixteen nodes, thirteen links, and limits against unnatural bends.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipeline.simulation.characters.body_arrays import LIMB, PERSON_NODES, RecordArray
from pipeline.simulation.characters.body_plan import BodyPlan, Link
from pipeline.simulation.characters.person_record import standing_nodes
from pipeline.simulation.characters.playthings import (
    BALL_MASS,
    BALL_RADIUS,
    BOX_SIZES,
    DECK_RADIUS,
    MERRY_GO_ROUND_MASS,
    ball_plan,
    box_plan,
    box_size,
    merry_go_round_plan,
)
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.people.joint_limits import (
    ARM_CONE,
    ELBOW_BEND,
    KNEE_BEND,
    LEG_CONE,
    MAX_HEAD_TILT,
    MAX_PELVIS_TILT,
    MAX_SHOULDER_TILT,
    MAX_SPINE_BEND,
)
from pipeline.simulation.people.proportions import (
    BUILDS,
    CHILD,
    JOINTS,
    SEGMENT_MASSES,
    SEGMENTS,
    Proportions,
)
from pipeline.simulation.spatial import Array, heading, normalized
from pipeline.simulation.terrain import Ground
from pipeline.spec.character import Character

TRUNK_SHARES = {
    "pelvis": 0.16,
    "hip_l": 0.15,
    "hip_r": 0.15,
    "spine": 0.22,
    "shoulders": 0.16,
    "shoulder_l": 0.08,
    "shoulder_r": 0.08,
}
"""Shares of the trunk's mass by node."""

LINK_RADII = {
    "belly": 0.068,
    "chest": 0.075,
    "head": 0.030,
    "yoke": 0.042,
    "pelvis": 0.058,
    "upper_arm": 0.026,
    "forearm": 0.021,
    "thigh": 0.046,
    "shin": 0.030,
}
"""Radii of links, in heights."""

BACK_FLATNESS = {"belly": 0.62, "chest": 0.60}
"""Depth of a back behind the axis of a link, in the radius of the link, which is as wide as it."""

SKULL_RADIUS = 0.42  # in the head's own height
JOINT_DAMPING = 3.0  # of limbs: a swing of a third of a second loses a tenth [1/s]

TOUCHING_LINKS = (
    *(
        (f"{arm}_{side}", other)
        for side in "lr"
        for arm, others in (
            ("forearm", ("belly", "chest", "pelvis", "skull", "thigh_l", "thigh_r")),
            ("upper_arm", ("belly", "chest")),
        )
        for other in others
    ),
    ("forearm_l", "forearm_r"),
)
"""Pairs of links of one person that touch one another."""

TOUCHING_LEGS = (
    ("shin_l", "shin_r"),
    ("thigh_l", "thigh_r"),
    ("shin_l", "thigh_r"),
    ("shin_r", "thigh_l"),
)
"""Further pairs of a limp person. Legs under control are led past one another: a stance foot is
locked, and touches of its leg would throw the other one off."""

PAIN_ENERGY = 0.12  # of a touch that hurts, per mass of the person [J/kg]

FOOT_TOUGHNESS = 1.5  # of a shin, which ends in the shoe that strikes what lies in its way

LINK_NAMES = (*SEGMENTS, "skull")
"""Names of a person's first links."""


def person_plan(proportions: Proportions, controlled: bool = False) -> BodyPlan:
    """Return a person, whose legs are under control or limp.

    Source: Horswill 2008, "Geometric and kinematic modeling": 13 links and 16 nodes. The links
    alone do not hold the middles of shoulders and pelvis.
    """
    rest = proportions.rest()
    links = [
        Link(
            _ends(*ends),
            _girth(name) * proportions.height,
            damping=JOINT_DAMPING if name[-2:] in ("_l", "_r") else 0.0,
            flatness=BACK_FLATNESS.get(name, 1.0),
            is_arm=name.startswith(("yoke", "upper_arm", "forearm")),
            toughness=FOOT_TOUGHNESS if name.startswith("shin") else 1.0,
        )
        for name, ends in SEGMENTS.items()
    ]
    skull = SKULL_RADIUS * proportions.head_size * proportions.height
    links.append(Link(_ends("head", "head"), skull))
    links += _limits(rest)
    numbers = {name: k for k, name in enumerate(LINK_NAMES)}
    touching = TOUCHING_LINKS if controlled else TOUCHING_LINKS + TOUCHING_LEGS
    return BodyPlan(
        rest=rest,
        mass=_masses(proportions.mass),
        radius=_radii(proportions, skull),
        links=tuple(links),
        middles=tuple(
            (PERSON_NODES[middle], *_ends(f"{end}_l", f"{end}_r"))
            for middle, end in (("pelvis", "hip"), ("shoulders", "shoulder"))
        ),
        limbs=_limbs(rest),
        pairs=tuple((numbers[a], numbers[b]) for a, b in touching),
        pain_threshold=PAIN_ENERGY * proportions.mass,
        grips=2,
    )


def _ends(a: str, b: str) -> tuple[int, int]:
    return PERSON_NODES[a], PERSON_NODES[b]


def _girth(segment: str) -> float:
    return LINK_RADII[segment.removesuffix("_l").removesuffix("_r")]


def _masses(mass: float) -> Array:
    """Return the masses of the nodes, limbs spread evenly over their ends [kg]."""
    masses = dict.fromkeys(JOINTS, 0.0)
    masses["head"] = SEGMENT_MASSES["head"]
    for name, share in TRUNK_SHARES.items():
        masses[name] += share * SEGMENT_MASSES["trunk"]
    for side in "lr":
        for limb in ("upper_arm", "forearm", "thigh", "shin"):
            for end in SEGMENTS[f"{limb}_{side}"]:
                masses[end] += 0.5 * SEGMENT_MASSES[limb]
        masses[f"hand_{side}"] += SEGMENT_MASSES["hand"]
        masses[f"foot_{side}"] += SEGMENT_MASSES["foot"]
    return mass * np.array([masses[name] for name in JOINTS])


def _radii(proportions: Proportions, skull: float) -> Array:
    """Return the distances of nodes from the ground in contact [m]; ankles stand on soles."""
    fractions = dict.fromkeys(JOINTS, 0.0)
    for name, ends in SEGMENTS.items():
        for end in ends:
            fractions[end] = max(fractions[end], _girth(name))
    for side in "lr":
        fractions[f"foot_{side}"] = proportions.ankle
        fractions[f"hip_{side}"] = LINK_RADII["pelvis"]
        fractions[f"shoulder_{side}"] = LINK_RADII["yoke"]
    radii: Array = proportions.height * np.array([fractions[name] for name in JOINTS])
    radii[PERSON_NODES["head"]] = skull
    return radii


def _limits(rest: Array) -> list[Link]:
    limits = [
        _bend_limit("pelvis", "spine", "shoulders", MAX_SPINE_BEND, rest),
        _bend_limit("spine", "shoulders", "head", MAX_HEAD_TILT, rest),
    ]
    for side in "lr":
        limits += [
            _tilt_limit("spine", "pelvis", f"hip_{side}", MAX_PELVIS_TILT, rest),
            _tilt_limit("spine", "shoulders", f"shoulder_{side}", MAX_SHOULDER_TILT, rest),
            _tilt_limit("head", "shoulders", f"shoulder_{side}", MAX_HEAD_TILT, rest),
            _fold_limit(f"shoulder_{side}", f"elbow_{side}", f"hand_{side}", ELBOW_BEND, rest),
            _fold_limit(f"hip_{side}", f"knee_{side}", f"foot_{side}", KNEE_BEND, rest),
        ]
    return limits


def _sides(a: str, b: str, c: str, rest: Array) -> tuple[float, float]:
    i, j, k = PERSON_NODES[a], PERSON_NODES[b], PERSON_NODES[c]
    return float(math.dist(rest[i], rest[j])), float(math.dist(rest[j], rest[k]))


def _bend_limit(a: str, b: str, c: str, angle: float, rest: Array) -> Link:
    x, y = _sides(a, b, c, rest)
    least = math.sqrt(x * x + y * y + 2.0 * x * y * math.cos(angle))
    return Link(_ends(a, c), shortest=least, longest=math.inf)


def _tilt_limit(a: str, b: str, c: str, angle: float, rest: Array) -> Link:
    x, y = _sides(a, b, c, rest)
    least, most = (math.sqrt(x * x + y * y + s * 2 * x * y * math.sin(angle)) for s in (-1, 1))
    return Link(_ends(a, c), shortest=least, longest=most)


def _fold_limit(a: str, b: str, c: str, angle: float, rest: Array) -> Link:
    x, y = _sides(a, b, c, rest)
    least = math.sqrt(x * x + y * y + 2.0 * x * y * math.cos(math.radians(angle)))
    return Link(_ends(a, c), shortest=least, longest=x + y)


def _limbs(rest: Array) -> RecordArray:
    limbs = np.zeros(4, LIMB)
    for k, (side, stems) in enumerate(
        (side, stems)
        for stems in (("hip", "knee", "foot"), ("shoulder", "elbow", "hand"))
        for side in "lr"
    ):
        names = tuple(f"{stem}_{side}" for stem in stems)
        leg = stems[0] == "hip"
        trunk = ("pelvis", "spine") if leg else ("spine", "shoulders")
        across = [f"{stems[0]}_l", f"{stems[0]}_r"]
        for field, name in zip(
            ("root", "joint", "tip", "left", "right", "low", "high"),
            (*names, *across, *trunk),
            strict=True,
        ):
            limbs[field][k] = PERSON_NODES[name]
        limbs["upper"][k], limbs["lower"][k] = _sides(names[0], names[1], names[2], rest)
        middle, cone, bend, spread = LEG_CONE if leg else ARM_CONE
        mirror = np.array([1.0, 1.0, 1.0 if side == "r" else -1.0])
        m = normalized(mirror * middle)
        b = mirror * bend
        limbs["middle"][k] = m
        limbs["cone"][k] = math.cos(math.radians(cone))
        limbs["bend"][k] = normalized(b - (b @ m) * m)
        limbs["spread"][k] = math.cos(math.radians(spread)), math.sin(math.radians(spread))
    return limbs


RAGDOLL = replace(CHILD, height=0.55, mass=0.7)
"""A doll with a child's proportions."""

PEOPLE = {**BUILDS, "ragdoll": RAGDOLL}
"""Characters with the body of a person."""

START_CLEARANCE = 2e-4
"""Height above the ground at which things start [m]."""


def proportions_of(member: Character) -> Proportions | None:
    """Return the measures of a person or a doll, None for a thing."""
    template = PEOPLE.get(member.character)
    if template is None:
        return None
    return replace(
        template, height=template.height * member.scale, mass=template.mass * member.scale**3
    )


def plan_of(member: Character) -> BodyPlan:
    """Return the nodes and links of a character."""
    proportions = proportions_of(member)
    if proportions is not None:
        return person_plan(proportions, controlled=member.acts)
    scale = member.scale
    if member.character == "ball":
        return ball_plan(BALL_RADIUS * scale, BALL_MASS * scale**3)
    if member.character == "merry-go-round":
        return merry_go_round_plan(DECK_RADIUS * scale, MERRY_GO_ROUND_MASS * scale**3)
    return box_plan(box_size(member), BOX_SIZES[member.character][1] * scale**3)


def start_nodes(member: Character, plan: BodyPlan, ground: Ground) -> Array:
    """Return the start places (n, 3) of the nodes of a character [m]."""
    x, z = member.at[0], member.at[-1]
    proportions = proportions_of(member)
    if proportions is not None and member.acts:
        height = float(ground.height(np.array(x), np.array(z)))
        return standing_nodes(
            proportions, np.array([x, z]), math.radians(member.heading_deg), height
        )
    R = heading(math.radians(member.heading_deg))
    if any(member.rotation_deg):
        R = R @ rotation_from_angles(np.radians(np.array([member.rotation_deg])))[0]
    p = plan.rest @ R.T
    p += [x, 0.0, z]
    floor = float((p[:, 1] - plan.radius).min())
    clearance = float((p[:, 1] - plan.radius - ground.height(p[:, 0], p[:, 2])).min())
    if plan.bearing_nodes:
        # A bearing stands on a base of its height; nodes on it would drag over the ground.
        floor, clearance = 0.0, min(clearance, -float(ground.height(np.array(x), np.array(z))))
    if len(member.at) == 3:
        p[:, 1] += member.at[1] - floor
    else:
        p[:, 1] += START_CLEARANCE - clearance
    return p


def previous_nodes(member: Character, p: Array, mass: Array, h: float) -> Array:
    """Return the places (n, 3) a sub-step `h` [s] before the start at p (n, 3) [m]."""
    free = np.isfinite(mass)
    weights = np.where(free, mass, 0.0)
    middle = (weights[:, None] * p).sum(axis=0) / weights.sum()
    v = np.cross(np.radians(member.spin_deg), p - middle) + member.velocity
    return np.where(free[:, None], p - h * v, p)
