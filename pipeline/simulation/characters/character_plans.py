"""Character plans."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipeline.simulation.characters.body_arrays import LIMB, PERSON_NODES, RecordArray
from pipeline.simulation.characters.body_plan import BodyPlan, Link
from pipeline.simulation.characters.person_record import standing_nodes
from pipeline.simulation.characters.playthings import (
    BALL,
    BALL_MASS,
    BOXES,
    ROUND,
    ROUND_MASS,
    ball_plan,
    box_plan,
    merry_go_round_plan,
    size_of,
)
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.people.proportions import (
    ADULT,
    CHILD,
    JOINTS,
    SEGMENT_MASSES,
    SEGMENTS,
    Proportions,
)
from pipeline.simulation.spatial import Array, heading, normalized
from pipeline.simulation.terrain import Ground
from pipeline.spec.character import Character

TRUNK = {
    "pelvis": 0.16,
    "hip_l": 0.15,
    "hip_r": 0.15,
    "spine": 0.22,
    "shoulders": 0.16,
    "shoulder_l": 0.08,
    "shoulder_r": 0.08,
}
"""How the mass of the trunk is spread over its nodes."""

GIRTHS = {
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
"""Radii of what is touched, in heights."""

SKULL = 0.42
"""Radius of the head, in its own height."""

JOINT_DAMPING = 3.0
"""Of limbs that swing: a tenth of a second of a third [1/s]."""

FOLDED = math.radians(150.0)
"""How far elbows and knees bend."""

LEG = (0.5, -0.85, 0.12), 88.0, (0.85, 0.5, 0.1), 35.0

ARM = (0.6, -0.25, 0.75), 115.0, (-0.6, -0.7, 0.45), 100.0
"""Middle of the cone, half its angle, where the joint points, how far aside [degrees]; on the
right, in the frame of the trunk."""

BENT, TILTED, TURNED, NODDED = (math.radians(angle) for angle in (60.0, 22.0, 16.0, 50.0))
"""How far the spine bends, the pelvis and the shoulders tilt on it, and the head."""

MEETINGS = (
    *(
        (f"{arm}_{side}", what)
        for side in "lr"
        for arm, whats in (
            ("forearm", ("belly", "chest", "pelvis", "skull", "thigh_l", "thigh_r")),
            ("upper_arm", ("belly", "chest")),
        )
        for what in whats
    ),
    ("forearm_l", "forearm_r"),
)
"""Links of one person that meet one another."""

LEGS_MEET = (
    ("shin_l", "shin_r"),
    ("thigh_l", "thigh_r"),
    ("shin_l", "thigh_r"),
    ("shin_r", "thigh_l"),
)
"""Likewise of one who is limp. Legs that are led past one another are not held up by touches:
a foot that stands is locked, and what strikes its leg would be thrown off."""

HURTS = 0.12
"""Energy of a touch that hurts, by the mass of who is touched [J/kg]."""

LINK_NAMES = (*SEGMENTS, "skull")
"""Of a person's first links."""


def person_plan(proportions: Proportions, led: bool = False) -> BodyPlan:
    """Return a person of these measures, whose legs are led or limp.

    Source: Horswill 2008, "Geometric and kinematic modeling": 13 links and 16 nodes. The
        links alone do not hold the middles of shoulders and pelvis.
    """
    rest = proportions.rest()
    links = [
        Link(
            _ends(*ends),
            _girth(name) * proportions.height,
            damping=_damping(name),
            is_arm=name.startswith(("upper_arm", "forearm")),
        )
        for name, ends in SEGMENTS.items()
    ]
    skull = SKULL * proportions.head_size * proportions.height
    links.append(Link(_ends("head", "head"), skull))
    links += _limits(rest)
    numbers = {name: k for k, name in enumerate(LINK_NAMES)}
    meetings = MEETINGS if led else MEETINGS + LEGS_MEET
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
        pairs=tuple((numbers[a], numbers[b]) for a, b in meetings),
        pain_threshold=HURTS * proportions.mass,
        grips=3,
    )


def _ends(a: str, b: str) -> tuple[int, int]:
    return PERSON_NODES[a], PERSON_NODES[b]


def _girth(segment: str) -> float:
    return GIRTHS[segment.removesuffix("_l").removesuffix("_r")]


def _damping(segment: str) -> float:
    return JOINT_DAMPING if segment[-2:] in ("_l", "_r") else 0.0


def _masses(mass: float) -> Array:
    """Return the masses of the nodes: limbs are spread evenly over their ends [kg]."""
    of = dict.fromkeys(JOINTS, 0.0)
    of["head"] = SEGMENT_MASSES["head"]
    for name, share in TRUNK.items():
        of[name] += share * SEGMENT_MASSES["trunk"]
    for side in "lr":
        for limb in ("upper_arm", "forearm", "thigh", "shin"):
            for end in SEGMENTS[f"{limb}_{side}"]:
                of[end] += 0.5 * SEGMENT_MASSES[limb]
        of[f"hand_{side}"] += SEGMENT_MASSES["hand"]
        of[f"foot_{side}"] += SEGMENT_MASSES["foot"]
    return mass * np.array([of[name] for name in JOINTS])


def _radii(proportions: Proportions, skull: float) -> Array:
    """Return how far from the ground nodes lie [m]; ankles stand on soles."""
    of = dict.fromkeys(JOINTS, 0.0)
    for name, ends in SEGMENTS.items():
        for end in ends:
            of[end] = max(of[end], _girth(name))
    for side in "lr":
        of[f"foot_{side}"] = proportions.ankle
        of[f"hip_{side}"] = GIRTHS["pelvis"]
        of[f"shoulder_{side}"] = GIRTHS["yoke"]
    radii: Array = proportions.height * np.array([of[name] for name in JOINTS])
    radii[PERSON_NODES["head"]] = skull
    return radii


def _limits(rest: Array) -> list[Link]:
    """Return links that nothing touches and that only keep ends from coming too near or far."""
    limits = [
        _bent("pelvis", "spine", "shoulders", BENT, rest),
        _bent("spine", "shoulders", "head", NODDED, rest),
    ]
    for side in "lr":
        limits += [
            _tilted("spine", "pelvis", f"hip_{side}", TILTED, rest),
            _tilted("spine", "shoulders", f"shoulder_{side}", TURNED, rest),
            _tilted("head", "shoulders", f"shoulder_{side}", NODDED, rest),
            _folded(f"shoulder_{side}", f"elbow_{side}", f"hand_{side}", rest),
            _folded(f"hip_{side}", f"knee_{side}", f"foot_{side}", rest),
        ]
    return limits


def _sides(a: str, b: str, c: str, rest: Array) -> tuple[float, float]:
    i, j, k = PERSON_NODES[a], PERSON_NODES[b], PERSON_NODES[c]
    return float(math.dist(rest[i], rest[j])), float(math.dist(rest[j], rest[k]))


def _bent(a: str, b: str, c: str, angle: float, rest: Array) -> Link:
    """Keep two links in a row from bending more than so far."""
    x, y = _sides(a, b, c, rest)
    least = math.sqrt(x * x + y * y + 2.0 * x * y * math.cos(angle))
    return Link(_ends(a, c), shortest=least, longest=math.inf)


def _tilted(a: str, b: str, c: str, angle: float, rest: Array) -> Link:
    """Keep two links that stand on one another from tilting more than so far."""
    x, y = _sides(a, b, c, rest)
    least, most = (math.sqrt(x * x + y * y + s * 2 * x * y * math.sin(angle)) for s in (-1, 1))
    return Link(_ends(a, c), shortest=least, longest=most)


def _folded(a: str, b: str, c: str, rest: Array) -> Link:
    """Keep a limb from folding too far, and from becoming quite straight."""
    x, y = _sides(a, b, c, rest)
    least = math.sqrt(x * x + y * y + 2.0 * x * y * math.cos(FOLDED))
    return Link(_ends(a, c), shortest=least, longest=x + y)


def _limbs(rest: Array) -> RecordArray:
    """Return the legs and arms."""
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
        for word, name in zip(
            ("root", "joint", "tip", "left", "right", "low", "high"),
            (*names, *across, *trunk),
            strict=True,
        ):
            limbs[word][k] = PERSON_NODES[name]
        limbs["upper"][k], limbs["lower"][k] = _sides(names[0], names[1], names[2], rest)
        middle, cone, bend, spread = LEG if leg else ARM
        mirror = np.array([1.0, 1.0, 1.0 if side == "r" else -1.0])
        m = normalized(mirror * middle)
        b = mirror * bend
        limbs["middle"][k] = m
        limbs["cone"][k] = math.cos(math.radians(cone))
        limbs["bend"][k] = normalized(b - (b @ m) * m)
        limbs["spread"][k] = math.cos(math.radians(spread)), math.sin(math.radians(spread))
    return limbs


RAGDOLL = replace(CHILD, height=0.55, mass=0.7)
"""A doll has a child's proportions."""

PEOPLE = {"child": CHILD, "adult": ADULT, "ragdoll": RAGDOLL}
"""Whose bodies are people's."""

CLEAR = 2e-4
"""Height over the ground at which what is put there begins [m]."""


def proportions_of(member: Character) -> Proportions | None:
    """Return the measures of a person or a doll, None of a thing."""
    like = PEOPLE.get(member.character)
    if like is None:
        return None
    return replace(like, height=like.height * member.scale, mass=like.mass * member.scale**3)


def plan_of(member: Character) -> BodyPlan:
    """Return what a character is made of."""
    proportions = proportions_of(member)
    if proportions is not None:
        return person_plan(proportions, led=member.acts)
    scale = member.scale
    if member.character == "ball":
        return ball_plan(BALL * scale, BALL_MASS * scale**3)
    if member.character == "merry-go-round":
        return merry_go_round_plan(ROUND * scale, ROUND_MASS * scale**3)
    return box_plan(size_of(member), BOXES[member.character][1] * scale**3)


def start_of(member: Character, plan: BodyPlan, ground: Ground) -> Array:
    """Return where the nodes (n, 3) of a character begin [m]."""
    x, z = member.at[0], member.at[-1]
    proportions = proportions_of(member)
    if proportions is not None and member.acts:
        height = float(ground.height(np.array(x), np.array(z)))
        return standing_nodes(
            proportions, np.array([x, z]), math.radians(member.heading_deg), height
        )
    p = _turned(member, plan)
    p += [x, 0.0, z]
    floor = float((p[:, 1] - plan.radius).min())
    over = float((p[:, 1] - plan.radius - ground.height(p[:, 0], p[:, 2])).min())
    if plan.bearing_nodes:
        # What runs on a bearing stands on a base of that height: it would drag over the ground.
        floor, over = 0.0, min(over, -float(ground.height(np.array(x), np.array(z))))
    if len(member.at) == 3:
        p[:, 1] += member.at[1] - floor
    else:
        p[:, 1] += CLEAR - over
    return p


def before_of(member: Character, p: Array, mass: Array, h: float) -> Array:
    """Return where nodes that begin at p (n, 3) were a sub-step `h` [s] before [m]."""
    free = np.isfinite(mass)
    weights = np.where(free, mass, 0.0)
    middle = (weights[:, None] * p).sum(axis=0) / weights.sum()
    v = np.cross(np.radians(member.spin_deg), p - middle) + member.velocity
    return np.where(free[:, None], p - h * v, p)


def _turned(member: Character, plan: BodyPlan) -> Array:
    """Return the nodes (n, 3) about the origin, turned as they begin [m]."""
    R = heading(math.radians(member.heading_deg))
    if any(member.rotation_deg):
        R = R @ rotation_from_angles(np.radians(np.array([member.rotation_deg])))[0]
    result: Array = plan.rest @ R.T
    return result
