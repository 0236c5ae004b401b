"""Collision avoidance: walkers step aside for people, and stop before solids.

Each walker predicts the closest approach to others if both go on as they do, and turns away from
it: the sooner the approach, the more, and to the right of people straight ahead. A person too near
is kept off at once. Others are visited in order along x, so that a crowd costs little more than
a few.

Near a solid of another room the speed of a person towards it is at most that of the solid; the
speed past it is unchanged. Light solids are walked into and pushed; the heavier they are, the more
slowly. Feet inside a solid are moved out of it, and slide where something presses the leg.
Solids below the ankle or above the head are ignored.

Source: Horswill 2008, "Object approach" (repulsion with a curl, so that nobody is stuck head on;
d_min there is compared with a squared distance); Reynolds 1999, unaligned collision avoidance.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.gait_timing import ground_speed, leg_length
from pipeline.simulation.characters.person_record import FOOT as FEET
from pipeline.simulation.characters.person_record import SITTING, STANCE
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.solid_kinematics import (
    OUT_OF_REACH,
    signed_distance,
    velocity_at,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.vectors import Vector, minus, times, triple

# Between people.
PREDICTION_TIME = 2.2  # [s]
SIGHT_RANGE = 4.5  # [m]
PERSONAL_SPACE = 0.36  # to both sides, in heights
PUSH_RANGE = 1.25  # within which others push, in personal space
SMOOTHING = 0.08  # share of the wanted sidestep taken over in a step


@compiled
def avoid_people(persons: Records) -> None:
    """Choose the sidestep of every person, once a step."""
    order = np.zeros(len(persons), dtype=np.int64)
    for i in range(len(persons)):
        n = i
        while n > 0 and persons[order[n - 1]].at[0] > persons[i].at[0]:
            order[n] = order[n - 1]
            n -= 1
        order[n] = i
    for n in range(len(order)):
        person = persons[order[n]]
        if not person.has_goal:
            person.sidestep[0], person.sidestep[1] = 0.0, 0.0
            continue
        x = z = 0.0
        for direction in (-1, 1):
            m = n + direction
            while 0 <= m < len(order):
                other = persons[order[m]]
                if abs(other.at[0] - person.at[0]) > SIGHT_RANGE:
                    break
                if other.owner != person.partner:
                    push_x, push_z = _repulsion(person, other)
                    x, z = x + push_x, z + push_z
                m += direction
        _blend_sidestep(person, x, z)


@compiled
def _blend_sidestep(person: Record, x: float, z: float) -> None:
    size = math.hypot(x, z)
    limit = 0.8 * person.pace
    if size > limit:
        x, z = x * limit / size, z * limit / size
    person.sidestep[0] += SMOOTHING * (x - person.sidestep[0])
    person.sidestep[1] += SMOOTHING * (z - person.sidestep[1])


@compiled
def _repulsion(one: Record, other: Record) -> tuple[float, float]:
    """Return the velocity with which one person keeps off another [m/s]."""
    x, z = other.at[0] - one.at[0], other.at[1] - one.at[1]
    distance = math.hypot(x, z)
    if distance > SIGHT_RANGE or distance < 1e-9:
        return 0.0, 0.0
    space = 0.5 * PERSONAL_SPACE * (one.height + other.height)
    if other.posture == SITTING:
        space *= 1.4
    space = min(space, one.neighbour_distance / PUSH_RANGE)
    rel_x, rel_z = other.velocity[0] - one.velocity[0], other.velocity[1] - one.velocity[1]
    speed_squared = rel_x * rel_x + rel_z * rel_z
    time = (
        0.0
        if speed_squared < 1e-6
        else min(max(-(x * rel_x + z * rel_z) / speed_squared, 0.0), PREDICTION_TIME)
    )
    near_x, near_z = x + rel_x * time, z + rel_z * time
    closest = math.hypot(near_x, near_z)
    push_x = push_z = 0.0
    if time > 0.0 and closest < 1.5 * space:
        # Across the own way, to the side on which the other will not be.
        speed = max(ground_speed(one), 1e-6)
        right_x, right_z = -one.velocity[1] / speed, one.velocity[0] / speed
        turn = -1.0 if (near_x * right_x + near_z * right_z) > 0.15 * space else 1.0
        amount = one.pace * (1.0 - time / PREDICTION_TIME) * (1.0 - closest / (1.5 * space)) * 1.6
        push_x, push_z = turn * amount * right_x, turn * amount * right_z
    if distance < PUSH_RANGE * space:
        depth = (PUSH_RANGE * space - distance) / space
        amount = math.sqrt(GRAVITY * leg_length(one)) * 0.5 * depth
        push_x, push_z = push_x - amount * x / distance, push_z - amount * z / distance
    return push_x, push_z


# Before solids of other rooms. Distances in heights, masses in those of the person.
PROBE_LEVELS = (0.07, 0.28, 0.53, 0.8)  # ankle, knee, pelvis, chest
STANDOFF = 0.15  # of the middle of the body
APPROACH_RATE = 4.0  # speed of approach by the distance that is left [1/s]
LIGHT_MASS, HEAVY_MASS = 0.25, 1.0  # of solids that slow nobody; that nobody pushes
FOOT_CLEARANCE = 0.05  # of an ankle
SLIDE_SPEED = 1.5  # of a stance foot that is moved out [m/s]
STEEP_COSINE = 0.7  # of the least angle to the level of a way out that bars the way


@compiled
def stop_before_solids(person: Record, mass: float, solids: Solids, h: float) -> None:
    """Take out of a walker's velocity what leads into solids, for a sub-step of `h` [s]."""
    if person.frozen:
        return
    for s in range(len(solids.bodies)):
        solid = solids.bodies[s]
        if solid.is_present and _is_near(person, solid):
            _limit_approach(person, mass, solids, s)
            if _obstruction(solid, mass) > 0.0:
                _clear_feet(person, solids, s, h)


@compiled
def slide_feet(person: Record, nodes: Records, h: float) -> None:
    """Let stance feet give way to contacts, for a sub-step of `h` [s]."""
    for k in range(2):
        if person.foot_state[k] == STANCE:
            push = nodes[person.node + FEET + k].contact_push
            share = min(SLIDE_SPEED * h / max(math.hypot(push[0], push[2]), 1e-9), 1.0)
            person.stance_place[k, 0] += share * push[0]
            person.stance_place[k, 2] += share * push[2]


@inlined
def _is_near(person: Record, solid: Record) -> bool:
    reach = 0.5 * person.height
    return (
        solid.low[0] - reach < person.at[0] < solid.high[0] + reach
        and solid.low[2] - reach < person.at[1] < solid.high[2] + reach
        and solid.high[1] > person.floor + PROBE_LEVELS[0] * person.height
        and solid.low[1] < person.floor + person.height
    )


@inlined
def _obstruction(solid: Record, mass: float) -> float:
    """Return the fraction of a person's velocity into a solid that it stops, 0 to 1."""
    if solid.inverse_mass == 0.0:
        return 1.0
    share: float = (1.0 / (solid.inverse_mass * mass) - LIGHT_MASS) / (HEAVY_MASS - LIGHT_MASS)
    return min(max(share, 0.0), 1.0)


@compiled
def _limit_approach(person: Record, mass: float, solids: Solids, s: int) -> None:
    solid, obstruction = solids.bodies[s], _obstruction(solids.bodies[s], mass)
    if obstruction == 0.0:
        return
    closest, normal, place = OUT_OF_REACH, (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)
    for probe in PROBE_LEVELS:
        at = (person.at[0], person.floor + probe * person.height, person.at[1])
        gap, outward = signed_distance(solids, s, at, 0.5 * person.height)
        if gap < closest and abs(outward[1]) < STEEP_COSINE:
            closest, normal, place = gap, outward, minus(at, times(gap, outward))
    if closest == OUT_OF_REACH:
        return
    size = math.hypot(normal[0], normal[2])
    x, z = normal[0] / size, normal[2] / size
    v = velocity_at(solid, minus(place, triple(solid.p)))
    towards = (person.velocity[0] - v[0]) * x + (person.velocity[1] - v[2]) * z
    distance = max(closest - STANDOFF * person.height, 0.0)
    limit = APPROACH_RATE * distance + (1.0 - obstruction) * person.pace
    if -towards > limit:
        excess = -towards - limit
        person.velocity[0] += excess * x
        person.velocity[1] += excess * z


@compiled
def _clear_feet(person: Record, solids: Solids, s: int, h: float) -> None:
    """Move a stance foot out of a solid, and the landing place of a swing foot beside it."""
    clearance = FOOT_CLEARANCE * person.height
    for k in range(2):
        if person.foot_state[k] == STANCE:
            x, z, depth = _way_out(solids, s, triple(person.stance_place[k]), clearance)
            depth = min(depth, SLIDE_SPEED * h)
            person.stance_place[k, 0] += depth * x
            person.stance_place[k, 2] += depth * z
        else:
            x, z, depth = _way_out(solids, s, triple(person.landing_place[k]), clearance)
            person.landing_place[k, 0] += depth * x
            person.landing_place[k, 2] += depth * z


@inlined
def _way_out(solids: Solids, s: int, at: Vector, clearance: float) -> tuple[float, float, float]:
    """Return the level way out of a solid, and the distance along it [m]."""
    gap, normal = signed_distance(solids, s, at, clearance)
    size = math.hypot(normal[0], normal[2])
    if gap >= clearance or abs(normal[1]) >= STEEP_COSINE:
        return 0.0, 0.0, 0.0
    return normal[0] / size, normal[2] / size, clearance - gap
