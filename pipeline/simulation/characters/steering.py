"""Steering: those who walk step aside for others, before they would run into them.

Each looks at where the others will be: from the nearest that two come to one another, if both go
on so, it turns away, the more the sooner that is, and to the right of those who come straight on.
Who is too near is kept off at once. The others are looked at along x in order, so that a crowd
costs little more than a few.

Source: Horswill 2008, "Object approach" (repulsion with a curl, so that nobody is stuck head on;
d_min there is compared with a squared distance); Reynolds 1999, unaligned collision avoidance.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.gait import leg_of, speed_of
from pipeline.simulation.characters.record import SITTING
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY

AHEAD = 2.2
"""How far ahead others are looked at [s]."""

FAR = 4.5
"""Those farther away are not seen [m]."""

ROOM = 0.36
"""That somebody takes to both sides, in heights [m]."""

SMOOTH = 0.08
"""Share of what is wanted that is taken over in a step."""


@compiled
def avoid(persons: Records) -> None:
    """Choose for everybody how to step aside, once a step."""
    order = np.zeros(len(persons), dtype=np.int64)
    for i in range(len(persons)):
        n = i
        while n > 0 and persons[order[n - 1]].at[0] > persons[i].at[0]:
            order[n] = order[n - 1]
            n -= 1
        order[n] = i
    for n in range(len(order)):
        one = persons[order[n]]
        if not one.goes:
            one.aside[0], one.aside[1] = 0.0, 0.0
            continue
        x = z = 0.0
        for way in (-1, 1):
            m = n + way
            while 0 <= m < len(order):
                other = persons[order[m]]
                if abs(other.at[0] - one.at[0]) > FAR:
                    break
                if other.owner != one.partner:
                    dx, dz = _away(one, other)
                    x, z = x + dx, z + dz
                m += way
        _turn_aside(one, x, z)


@compiled
def _turn_aside(person: Record, x: float, z: float) -> None:
    """Take over part of a velocity that leads aside."""
    size = math.hypot(x, z)
    most = 0.8 * person.pace
    if size > most:
        x, z = x * most / size, z * most / size
    person.aside[0] += SMOOTH * (x - person.aside[0])
    person.aside[1] += SMOOTH * (z - person.aside[1])


@compiled
def _away(one: Record, other: Record) -> tuple[float, float]:
    """Return the velocity with which one keeps off another [m/s]."""
    x, z = other.at[0] - one.at[0], other.at[1] - one.at[1]
    apart = math.hypot(x, z)
    if apart > FAR or apart < 1e-9:
        return 0.0, 0.0
    room = 0.5 * ROOM * (one.height + other.height)
    if other.posture == SITTING:
        room *= 1.4
    u, w = other.going[0] - one.going[0], other.going[1] - one.going[1]
    quick = u * u + w * w
    when = 0.0 if quick < 1e-6 else min(max(-(x * u + z * w) / quick, 0.0), AHEAD)
    near_x, near_z = x + u * when, z + w * when
    near = math.hypot(near_x, near_z)
    push_x = push_z = 0.0
    if when > 0.0 and near < 1.5 * room:
        # Across its own way, to the side on which the other will not be.
        speed = max(speed_of(one), 1e-6)
        right_x, right_z = -one.going[1] / speed, one.going[0] / speed
        side = near_x * right_x + near_z * right_z
        turn = -1.0 if side > 0.15 * room else 1.0
        much = one.pace * (1.0 - when / AHEAD) * (1.0 - near / (1.5 * room)) * 1.6
        push_x, push_z = turn * much * right_x, turn * much * right_z
    if apart < 1.25 * room:
        much = math.sqrt(GRAVITY * leg_of(one)) * 0.5 * (1.25 * room - apart) / room
        push_x, push_z = push_x - much * x / apart, push_z - much * z / apart
    return push_x, push_z
