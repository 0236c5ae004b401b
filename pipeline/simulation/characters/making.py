"""Making: the words of a character -> its plan, and where its nodes begin."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipeline.simulation.characters.layout import Plan
from pipeline.simulation.characters.person import person
from pipeline.simulation.characters.record import standing
from pipeline.simulation.characters.things import ball, box, merry_go_round
from pipeline.simulation.people.proportions import ADULT, CHILD, Proportions
from pipeline.simulation.spatial import Array, heading
from pipeline.simulation.terrain import Ground
from pipeline.simulation.tracks import turned
from pipeline.spec.cast import Character

RAGDOLL = replace(CHILD, height=0.55, mass=0.7)
"""A doll has a child's proportions."""

PEOPLE = {"child": CHILD, "adult": ADULT, "ragdoll": RAGDOLL}
"""Whose bodies are people's."""

BALL, BALL_MASS = 0.12, 0.4
"""Radius [m] and mass of a playground's ball [kg]."""

ROUND, ROUND_MASS = 1.3, 90.0
"""Radius [m] and mass of a merry-go-round [kg]."""

BOXES = {"box": ((0.5, 0.5, 0.5), 9.0), "bench": ((0.42, 0.42, 1.5), 26.0)}
"""Extents along X, Y and Z [m] and masses [kg]."""

CLEAR = 2e-4
"""Height over the ground at which what is put there begins [m]."""


def proportions_of(member: Character) -> Proportions | None:
    """Return the measures of a person or a doll, None of a thing."""
    like = PEOPLE.get(member.character)
    if like is None:
        return None
    return replace(like, height=like.height * member.scale, mass=like.mass * member.scale**3)


def plan_of(member: Character) -> Plan:
    """Return what a character is made of."""
    proportions = proportions_of(member)
    if proportions is not None:
        return person(proportions, led=member.acts)
    scale = member.scale
    if member.character == "ball":
        return ball(BALL * scale, BALL_MASS * scale**3)
    if member.character == "merry-go-round":
        return merry_go_round(ROUND * scale, ROUND_MASS * scale**3)
    return box(size_of(member), BOXES[member.character][1] * scale**3)


def size_of(member: Character) -> tuple[float, float, float]:
    """Return the extents of a box or a bench [m]."""
    x, y, z = BOXES[member.character][0]
    return x * member.scale, y * member.scale, z * member.scale


def start_of(member: Character, plan: Plan, ground: Ground) -> Array:
    """Return where the nodes (n, 3) of a character begin [m]."""
    x, z = member.at[0], member.at[-1]
    proportions = proportions_of(member)
    if proportions is not None and member.acts:
        height = float(ground.height(np.array(x), np.array(z)))
        return standing(proportions, np.array([x, z]), math.radians(member.heading_deg), height)
    p = _turned(member, plan)
    p += [x, 0.0, z]
    floor = float((p[:, 1] - plan.radius).min())
    over = float((p[:, 1] - plan.radius - ground.height(p[:, 0], p[:, 2])).min())
    if plan.gliding:
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


def _turned(member: Character, plan: Plan) -> Array:
    """Return the nodes (n, 3) about the origin, turned as they begin [m]."""
    R = heading(math.radians(member.heading_deg))
    if any(member.rotation_deg):
        R = R @ turned(np.radians(np.array([member.rotation_deg])))[0]
    result: Array = plan.rest @ R.T
    return result
