"""Collision avoidance: walkers stop before solids, and feet stay outside them.

Near a solid of another room the speed of a person towards it is at most that of the solid; the
speed past it is unchanged. Light solids are walked into and pushed; the heavier they are, the more
slowly. Feet inside a solid are moved out of it, and slide where something presses the leg.
Solids below the ankle or above the head are ignored.
"""

from __future__ import annotations

from pipeline.simulation.characters.body_arrays import SOLID
from pipeline.simulation.characters.hurdles import walks_into
from pipeline.simulation.characters.person_record import FOOT as FEET
from pipeline.simulation.characters.person_record import STANCE
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.solid_kinematics import (
    OUT_OF_REACH,
    signed_distance,
    velocity_at,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.vectors import Vector, hypotenuse, minus, times, triple

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
    """Take out of a walker's velocity what leads into solids, for `h` [s]."""
    if person.frozen:
        return
    for s in range(len(solids.bodies)):
        solid = solids.bodies[s]
        if s == SOLID - person.deck or walks_into(person, s):
            continue
        if solid.is_present and _is_near(person, solid):
            _limit_approach(person, mass, solids, s)
            if obstruction(solid, mass) > 0.0:
                _clear_feet(person, solids, s, h)


@compiled
def slide_feet(person: Record, nodes: Records, h: float) -> None:
    """Let stance feet give way to contacts, for `h` [s]."""
    for k in range(2):
        if person.foot_state[k] == STANCE:
            push = nodes[person.node + FEET + k].contact_push
            share = min(SLIDE_SPEED * h / max(hypotenuse(push[0], push[2]), 1e-9), 1.0)
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
def obstruction(solid: Record, mass: float) -> float:
    """Return the fraction of a person's velocity into a solid that it stops, 0 to 1."""
    if solid.inverse_mass == 0.0:
        return 1.0
    share: float = (1.0 / (solid.inverse_mass * mass) - LIGHT_MASS) / (HEAVY_MASS - LIGHT_MASS)
    return min(max(share, 0.0), 1.0)


@compiled
def _limit_approach(person: Record, mass: float, solids: Solids, s: int) -> None:
    solid, share = solids.bodies[s], obstruction(solids.bodies[s], mass)
    if share == 0.0:
        return
    closest, normal, place = OUT_OF_REACH, (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)
    for probe in PROBE_LEVELS:
        at = (person.at[0], person.floor + probe * person.height, person.at[1])
        gap, outward = signed_distance(solids, s, at, 0.5 * person.height)
        if gap < closest and abs(outward[1]) < STEEP_COSINE:
            closest, normal, place = gap, outward, minus(at, times(gap, outward))
    if closest == OUT_OF_REACH:
        return
    size = hypotenuse(normal[0], normal[2])
    x, z = normal[0] / size, normal[2] / size
    v = velocity_at(solid, minus(place, triple(solid.p)))
    towards = (person.velocity[0] - v[0]) * x + (person.velocity[1] - v[2]) * z
    distance = max(closest - STANDOFF * person.height, 0.0)
    limit = APPROACH_RATE * distance + (1.0 - share) * person.pace
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
    size = hypotenuse(normal[0], normal[2])
    if gap >= clearance or abs(normal[1]) >= STEEP_COSINE:
        return 0.0, 0.0, 0.0
    return normal[0] / size, normal[2] / size, clearance - gap
