"""Barriers: the solids beside a walker, in what it does to avoid other people.

Alone a walker goes by its route, which leads around solids. What it does for others must not lead
it into a wall: each solid near by forbids a half plane of velocities, and ends the gaps before it.

Source: van den Berg, Guy, Lin, Manocha, Reciprocal n-body collision avoidance, 2011, section 4.3:
half planes of obstacles, of which a walker makes all of the way; here one of each solid, along the
tangent at its nearest place.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.body_arrays import SOLID
from pipeline.simulation.characters.collision_avoidance import STANDOFF, obstruction
from pipeline.simulation.characters.hurdles import walks_into
from pipeline.simulation.characters.neighbours import Numbers, insert_nearest
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.solid_kinematics import (
    OUT_OF_REACH,
    signed_distance,
    velocity_at,
)
from pipeline.simulation.dynamics.compiled import Record, allocating, compiled, inlined
from pipeline.simulation.dynamics.vectors import (
    Vector,
    dot,
    inverse_turned,
    minus,
    rows_of,
    times,
    triple,
)
from pipeline.simulation.spatial import Array

MOST_BARRIERS = 6  # the nearest that are heeded
KNEE_LEVEL, PELVIS_LEVEL, HEAD_LEVEL = 0.28, 0.53, 1.0  # of what stops a body, in heights
INSET = 0.01  # of the place at which a solid is met from its top and bottom [m]
WALL_SPACE = 0.17  # of the middle of a body, in heights
WALL_TIME = 0.6  # within which no wall is met [s]
PASSAGE_RANGE = 4.0  # of walls between which walkers go one after the other [m]
PASSAGE_SIGHT = 16.0  # distance of walls up to which an opening between them is seen [m]
STEEP_COSINE = 0.7  # of the least angle to the level of a face that stops a body


@allocating
def find_barriers(person: Record, mass: float, solids: Solids, reach: float, found: Numbers) -> int:
    """Write the numbers of the solids nearest to a person that it cannot push aside.

    Args:
        person: `PERSON` record.
        mass: of the person [kg].
        solids: of other rooms.
        reach: distance up to which they are found [m].
        found: written; room for `MOST_BARRIERS`.

    Returns:
        How many there are.
    """
    count = 0
    if len(solids.bodies) == 0:
        return count
    squares = np.zeros(MOST_BARRIERS)
    for s in range(len(solids.bodies)):
        solid = solids.bodies[s]
        if not solid.is_present or not _is_high(person, solid) or _is_about(person, solid, s):
            continue
        x = max(solid.low[0] - person.at[0], person.at[0] - solid.high[0], 0.0)
        z = max(solid.low[2] - person.at[1], person.at[1] - solid.high[2], 0.0)
        square = x * x + z * z
        if square < reach * reach and obstruction(solid, mass) >= 1.0:
            count = insert_nearest(squares, found, count, square, s)
    return count


@inlined
def _is_high(person: Record, solid: Record) -> bool:
    """Tell whether a solid stands in the way of a body, rather than below or above it."""
    high: bool = solid.high[1] > person.floor + KNEE_LEVEL * person.height
    return high and solid.low[1] < person.floor + HEAD_LEVEL * person.height


@inlined
def _is_about(person: Record, solid: Record, s: int) -> bool:
    """Tell whether a person steps onto, steps over or does something with a solid."""
    thing = SOLID - solid.thing
    is_act = person.act_things[0] == thing or person.act_things[1] == thing
    return s == SOLID - person.deck or is_act or walks_into(person, s)


@inlined
def _place_beside(person: Record, solid: Record) -> Vector:
    """Return the place of a body at which it meets a solid: at the pelvis, if that is so high."""
    y = person.floor + PELVIS_LEVEL * person.height
    y = max(min(y, solid.high[1] - INSET), solid.low[1] + INSET)
    return (person.at[0], y, person.at[1])


@compiled
def forbid_wall(person: Record, solids: Solids, s: int, line: Array) -> bool:
    """Write the line of velocities beyond which a person would meet a solid; tell if there is one.

    Args:
        person: `PERSON` record.
        solids: of other rooms.
        s: number of the solid.
        line: written: x and z of a point and of the direction, to whose left all are allowed.
    """
    solid = solids.bodies[s]
    at = _place_beside(person, solid)
    space = WALL_SPACE * person.height
    gap, normal = signed_distance(solids, s, at, space + 2.0 * person.pace)
    size = math.hypot(normal[0], normal[2])
    if gap == OUT_OF_REACH or abs(normal[1]) > STEEP_COSINE:
        return False
    x, z = normal[0] / size, normal[2] / size
    v = velocity_at(solid, minus(minus(at, times(gap, normal)), triple(solid.p)))
    # One that is too near already is not driven off.
    room = max(gap - space, 0.0) / WALL_TIME
    away = v[0] * x + v[2] * z - room
    line[0], line[1] = away * x, away * z
    line[2], line[3] = z, -x
    return True


@compiled
def nearest_place(person: Record, solids: Solids, s: int, at: Vector) -> tuple[bool, Vector]:
    """Return whether a wall is near a place, at a person's height, and its place nearest to it."""
    from_place = _place_beside(person, solids.bodies[s])
    from_place = (at[0], from_place[1], at[2])
    gap, normal = signed_distance(solids, s, from_place, PASSAGE_SIGHT)
    return 0.0 < gap < PASSAGE_SIGHT, minus(from_place, times(gap, normal))


@compiled
def note_passage(person: Record, solids: Solids, s: int, x: float, z: float) -> None:
    """Note how far ahead along x and z the nearest wall, with number `s`, lies that is passed."""
    at = _place_beside(person, solids.bodies[s])
    gap, normal = signed_distance(solids, s, at, PASSAGE_RANGE)
    speed = math.hypot(x, z)
    person.has_passage = gap < PASSAGE_RANGE and speed > 0.0
    if person.has_passage:
        person.passage = -gap * (normal[0] * x + normal[2] * z) / speed


@compiled
def free_way(person: Record, solids: Solids, s: int, x: float, z: float, farthest: float) -> float:
    """Return how far a person gets in a direction before it meets a solid [m].

    Args:
        person: `PERSON` record.
        solids: of other rooms.
        s: number of the solid.
        x: of the unit vector of the direction.
        z: of the same.
        farthest: the most that is returned [m].
    """
    solid = solids.bodies[s]
    R = rows_of(solid.R)
    local = inverse_turned(R, minus(_place_beside(person, solid), triple(solid.p)))
    way, space = inverse_turned(R, (x, 0.0, z)), STANDOFF * person.height
    if solid.radius > 0.0:
        offset = minus(triple(solid.middle), local)
        along = dot(offset, way)
        reach = solid.radius + space
        root = along * along - dot(offset, offset) + reach * reach
        if along <= 0.0 or root < 0.0:
            return farthest
        return min(max(along - math.sqrt(root), 0.0), farthest)
    enter, leave, planes = 0.0, farthest, solids.planes
    nearest, approach = -OUT_OF_REACH, 0.0
    for k in range(solid.planes[0], solid.planes[0] + solid.planes[1]):
        normal = (planes[k, 0], planes[k, 1], planes[k, 2])
        gap, rate = dot(normal, local) - planes[k, 3] - space, dot(normal, way)
        if gap > nearest:
            nearest, approach = gap, rate
        if rate < 0.0:
            enter = max(enter, -gap / rate)
        elif gap > 0.0:
            return farthest
        elif rate > 0.0:
            leave = min(leave, -gap / rate)
        if enter >= leave:
            return farthest
    # One that is too near already gets away.
    return farthest if nearest <= 0.0 and approach >= 0.0 else enter
