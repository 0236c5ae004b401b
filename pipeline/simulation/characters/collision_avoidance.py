"""Collision avoidance."""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.gait_timing import leg_of, speed_of
from pipeline.simulation.characters.person_record import FOOT as FEET
from pipeline.simulation.characters.person_record import SITTING, STANCE
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.solid_kinematics import FAR, gap_of, velocity_at
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.vectors import Vector, minus, times, triple

AHEAD = 2.2
"""How far ahead others are looked at [s]."""

SIGHT_RANGE = 4.5
"""Those farther away are not seen [m]."""

PERSONAL_SPACE = 0.36
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
                if abs(other.at[0] - one.at[0]) > SIGHT_RANGE:
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
    if apart > SIGHT_RANGE or apart < 1e-9:
        return 0.0, 0.0
    room = 0.5 * PERSONAL_SPACE * (one.height + other.height)
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


LEVELS = (0.07, 0.28, 0.53, 0.8)
"""Heights at which people look for solids, in theirs: ankle, knee, pelvis, chest."""

STANDOFF, SLOWS = 0.15, 4.0
"""How far the middle of a body is kept off, in heights; how fast it may come nearer by the
distance that is left [1/s]."""

LIGHT, HEAVY = 0.25, 1.0
"""Masses of what nobody is slowed by and of what nobody pushes, in theirs."""

FOOT, SLIDES = 0.05, 1.5
"""How far an ankle is kept off, in heights; how fast one that stands is moved out [m/s]."""

STEEP = 0.7
"""Cosine of the least angle to the level of what bars the way, as up or down its way out leads."""


@compiled
def hold_back(person: Record, mass: float, solids: Solids, h: float) -> None:
    """Take out of the way of one who walks what leads into solids, for a sub-step of `h` [s]."""
    if person.frozen:
        return
    for s in range(len(solids.bodies)):
        solid = solids.bodies[s]
        if solid.here and _is_near(person, solid):
            _slow(person, mass, solids, s)
            if _bars(solid, mass) > 0.0:
                _clear(person, solids, s, h)


@compiled
def slide(person: Record, nodes: Records, h: float) -> None:
    """Let feet that stand give way to whoever presses them, for a sub-step of `h` [s]."""
    for k in range(2):
        if person.doing[k] == STANCE:
            pressed = nodes[person.node + FEET + k].pressed
            far = math.hypot(pressed[0], pressed[2])
            share = min(SLIDES * h / max(far, 1e-9), 1.0)
            person.stood[k, 0] += share * pressed[0]
            person.stood[k, 2] += share * pressed[2]


@inlined
def _is_near(person: Record, solid: Record) -> bool:
    reach = 0.5 * person.height
    near: bool = (
        solid.low[0] - reach < person.at[0] < solid.high[0] + reach
        and solid.low[2] - reach < person.at[1] < solid.high[2] + reach
        and solid.high[1] > person.floor + LEVELS[0] * person.height
        and solid.low[1] < person.floor + person.height
    )
    return near


@inlined
def _bars(solid: Record, mass: float) -> float:
    """Return how much of the way somebody of a mass has to a solid it bars, from 0 to 1."""
    if solid.inverse_mass == 0.0:
        return 1.0
    share: float = (1.0 / (solid.inverse_mass * mass) - LIGHT) / (HEAVY - LIGHT)
    return min(max(share, 0.0), 1.0)


@compiled
def _slow(person: Record, mass: float, solids: Solids, s: int) -> None:
    """Let somebody go on no faster into a solid than it goes."""
    solid, bars = solids.bodies[s], _bars(solids.bodies[s], mass)
    if bars == 0.0:
        return
    least, normal, where = FAR, (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)
    for level in LEVELS:
        at = (person.at[0], person.floor + level * person.height, person.at[1])
        gap, way = gap_of(solids, s, at, 0.5 * person.height)
        if gap < least and abs(way[1]) < STEEP:
            least, normal, where = gap, way, minus(at, times(gap, way))
    if least == FAR:
        return
    size = math.hypot(normal[0], normal[2])
    x, z = normal[0] / size, normal[2] / size
    v = velocity_at(solid, minus(where, triple(solid.p)))
    towards = (person.going[0] - v[0]) * x + (person.going[1] - v[2]) * z
    left = max(least - STANDOFF * person.height, 0.0)
    most = SLOWS * left + (1.0 - bars) * person.pace
    if -towards > most:
        more = -towards - most
        person.going[0] += more * x
        person.going[1] += more * z


@compiled
def _clear(person: Record, solids: Solids, s: int, h: float) -> None:
    """Move a foot that stands in a solid out of it, and land one that swings beside it."""
    room = FOOT * person.height
    for k in range(2):
        if person.doing[k] == STANCE:
            x, z, deep = _out(solids, s, triple(person.stood[k]), room)
            deep = min(deep, SLIDES * h)
            person.stood[k, 0] += deep * x
            person.stood[k, 2] += deep * z
        else:
            x, z, deep = _out(solids, s, triple(person.land[k]), room)
            person.land[k, 0] += deep * x
            person.land[k, 2] += deep * z


@inlined
def _out(solids: Solids, s: int, at: Vector, room: float) -> tuple[float, float, float]:
    """Return the level way out of a solid, and how far a foot has to go along it [m]."""
    gap, normal = gap_of(solids, s, at, room)
    size = math.hypot(normal[0], normal[2])
    if gap >= room or abs(normal[1]) >= STEEP:
        return 0.0, 0.0, 0.0
    return normal[0] / size, normal[2] / size, room - gap
