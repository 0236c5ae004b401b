"""Passage lanes: where others come the other way through an opening, walkers keep to its right half.

Without that, two streams that meet in a doorway stand before one another, interleaved over its
width. So a walker that will meet others in an opening between two walls aims at the right half of
it, well before it, and does not go beyond its middle again before it is through: those who come out
find their half free, in front of the opening as well.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.barriers import nearest_place
from pipeline.simulation.characters.neighbours import Numbers, find_within
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.vectors import Vector, hypotenuse
from pipeline.simulation.spatial import Array

NARROWEST, WIDEST = 1.4, 8.0  # opening with two lanes; with room enough without them [m]
LANE_RANGE = 9.0  # before an opening, in which walkers take their lane [m]
LANE_END, FADING = 4.0, 2.0  # behind it, in which they keep it, at last less and less [m]
ROUND_WALL = 1.5  # distance of a place at the end of a wall, before or beside the opening [m]
SEEN_BEFORE = 10.0  # distance at which others that come the other way are seen [m]
MIDDLE_ROOM, WALL_ROOM = 0.3, 0.5  # of a walker's middle to that of the opening, to a wall [m]
READY = 2.0  # distance before the opening at which a walker is in its lane [m]
LEAST_RUN = 0.4  # along the way, in which it gets into it [m]
NEARLY = 0.5  # distance from its lane at which it goes on all the same [m]
MOST_BACK = -0.5  # way back, to get into it in front of those who come out [m]
MANY = 3  # who come the other way, for whom a walker keeps wholly to its lane
CLOSEST_STEPS = 3  # of the search for the places at which two walls are nearest
TURN_TIME = 0.8  # within which the middle is not passed [s]


@compiled
def take_lane(
    persons: Records,
    places: Array,
    order: Numbers,
    n: int,
    near: Numbers,
    walls: Numbers,
    solids: Solids,
    x: float,
    z: float,
) -> tuple[float, float]:
    """Return the wanted velocity of the n-th person in order, turned towards its lane.

    Args:
        persons: `PERSON` records; that of the person is changed.
        places: (P, 2) x and z of all people in their order along x [m].
        order: their numbers along x.
        n: the person's place in the order.
        near: room for all people.
        walls: numbers of the solids about it.
        solids: of other rooms.
        x: of its velocity to the goal [m/s].
        z: of the same.
    """
    person = persons[order[n]]
    person.lane_room = math.inf
    speed = hypotenuse(x, z)
    if len(walls) < 2 or speed < 0.1:
        return x, z
    for i in range(len(walls)):
        for j in range(i):
            found, a, b = _closest_places(person, solids, walls[j], walls[i])
            if not found:
                continue
            width = hypotenuse(b[0] - a[0], b[2] - a[2])
            if width < NARROWEST or width > WIDEST:
                continue
            middle_x, middle_z = 0.5 * (a[0] + b[0]), 0.5 * (a[2] + b[2])
            # Through the opening, the way the person goes.
            tx, tz = (a[2] - b[2]) / width, (b[0] - a[0]) / width
            if tx * x + tz * z < 0.0:
                tx, tz = -tx, -tz
            left = (middle_x - person.at[0]) * tx + (middle_z - person.at[1]) * tz
            aside = (person.at[1] - middle_z) * tx - (person.at[0] - middle_x) * tz
            if not _leads_through(person, middle_x, middle_z, tx, tz, width, left, aside):
                continue
            share = _met_share(persons, places, order, n, near, middle_x, middle_z, tx, tz, left)
            if share == 0.0:
                continue
            return _turned_to_lane(person, x, z, speed, tx, tz, width, left, aside, share)
    return x, z


@inlined
def _closest_places(
    person: Record, solids: Solids, first: int, second: int
) -> tuple[bool, Vector, Vector]:
    """Return whether two walls are near, and the places at which they are nearest to each other."""
    at = (person.at[0], 0.0, person.at[1])
    found, a = nearest_place(person, solids, first, at)
    b = a
    if found:
        for _ in range(CLOSEST_STEPS):
            found, b = nearest_place(person, solids, second, a)
            if found:
                found, a = nearest_place(person, solids, first, b)
            if not found:
                break
    return found, a, b


@inlined
def _leads_through(
    person: Record,
    middle_x: float,
    middle_z: float,
    tx: float,
    tz: float,
    width: float,
    left: float,
    aside: float,
) -> bool:
    """Tell whether a person walks through an opening, or has just done so."""
    if left < 0.0:
        return left > -LANE_END and abs(aside) < 0.5 * width + ROUND_WALL
    if left > LANE_RANGE:
        return False
    gx, gz = person.goal[0] - middle_x, person.goal[1] - middle_z
    beyond, goal_aside = gx * tx + gz * tz, gz * tx - gx * tz
    if beyond < -ROUND_WALL:
        return False
    # Where it passes between the walls, or at the end of one that it walks around.
    passes = aside
    if beyond > 0.0:
        passes += (goal_aside - aside) * left / max(left + beyond, 1e-9)
    else:
        passes = goal_aside
    return abs(passes) < 0.5 * width + 0.2


@inlined
def _met_share(
    persons: Records,
    places: Array,
    order: Numbers,
    n: int,
    near: Numbers,
    middle_x: float,
    middle_z: float,
    tx: float,
    tz: float,
    left: float,
) -> float:
    """Return how much a person keeps to its lane, 0 to 1, by how many come the other way."""
    count = 0
    person = persons[order[n]]
    for m in range(find_within(places, order, n, SEEN_BEFORE, near)):
        other = persons[near[m]]
        if not other.has_goal or other.frozen:
            continue
        ox, oz = other.goal[0] - other.at[0], other.goal[1] - other.at[1]
        far = max(hypotenuse(ox, oz), 1e-9)
        ahead = (other.at[0] - person.at[0]) * tx + (other.at[1] - person.at[1]) * tz
        if ahead > 0.0 and ox * tx + oz * tz < -0.5 * far:
            count += 1
    return min(count / MANY, 1.0)


@inlined
def _turned_to_lane(
    person: Record,
    x: float,
    z: float,
    speed: float,
    tx: float,
    tz: float,
    width: float,
    left: float,
    aside: float,
    share: float,
) -> tuple[float, float]:
    """Return a wanted velocity turned to the right half of an opening."""
    right_x, right_z = -tz, tx
    low = min(MIDDLE_ROOM, 0.25 * width)
    high = max(0.5 * width - WALL_ROOM, low)
    # Behind the opening it may go farther to the right.
    wanted = max(aside, low) if left < 0.0 else min(max(aside, low), high)
    run = left - READY - max(low - aside, 0.0)
    run = max(run, LEAST_RUN if aside > low - NEARLY or left < 0.0 else MOST_BACK)
    lane_x = run * tx + (wanted - aside) * right_x
    lane_z = run * tz + (wanted - aside) * right_z
    size = max(hypotenuse(lane_x, lane_z), 1e-9)
    if left < 0.0:
        # It turns to its goal as soon as it is through.
        share *= min(max((LANE_END + left) / FADING, 0.0), 1.0)
    x += share * (speed * lane_x / size - x)
    z += share * (speed * lane_z / size - z)
    person.lane_right[0], person.lane_right[1] = right_x, right_z
    person.lane_room = max(aside - 0.5 * low, 0.0) if left < 2.0 * READY else math.inf
    return x, z


@compiled
def forbid_other_lane(person: Record, line: Array) -> bool:
    """Write the line of velocities beyond which a person leaves its lane; tell if there is one."""
    if person.lane_room == math.inf:
        return False
    right_x, right_z = person.lane_right[0], person.lane_right[1]
    away = -person.lane_room / TURN_TIME
    line[0], line[1] = away * right_x, away * right_z
    line[2], line[3] = right_z, -right_x
    return True


@inlined
def way_in_lane(person: Record, x: float, z: float, farthest: float) -> float:
    """Return how far a person gets along a unit vector x, z before it leaves its lane [m]."""
    leaving = -(person.lane_right[0] * x + person.lane_right[1] * z)
    if person.lane_room == math.inf or leaving <= 0.0:
        return farthest
    return min(person.lane_room / leaving, farthest)
