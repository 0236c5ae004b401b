"""Passage lanes: where others come the other way through an opening, walkers keep to its right.

Without that, two streams that meet in an opening stand before one another, mixed over its whole
width. So a walker that will meet others between two walls aims at the right half of the opening,
already at some distance, and does not go beyond its middle before it is through: those who come out
find their half free, in front of the opening as well. Who comes from the left waits farther off.
Those in one lane close up, or fewer would pass than do among real people.

Sources: Helbing et al. 2001: of two doors each comes to serve one stream, and they let more people
through than one that both share. Hoogendoorn and Daamen 2005: in a bottleneck people walk in files
that overlap like the teeth of a zip.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pipeline.simulation.characters.barriers import nearest_place
from pipeline.simulation.characters.neighbours import Numbers, find_within
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.vectors import Vector, hypotenuse
from pipeline.simulation.spatial import Array

NARROWEST, WIDEST = 1.4, 8.0  # opening with two lanes; with room enough without them [m]
LANE_RANGE = 14.0  # before an opening, in which walkers take their lane [m]
LANE_END, FADING = 4.0, 2.0  # behind it, in which they keep it, at last less and less [m]
ROUND_WALL = 1.5  # from an opening to the places on ways around its walls [m]
AT_WALL = 0.2  # from the edge of an opening to where ways go through it [m]
SEEN_BEFORE = 14.0  # distance at which others that come the other way are seen [m]
OPPOSITE = 0.5  # cosine of the angle between their way and the opposite of one's own
MANY = 3  # who come the other way, for whom a walker keeps wholly to its lane
MIDDLE_ROOM, WALL_ROOM = 0.3, 0.5  # of a walker's middle to that of the opening, to a wall [m]
KEPT = 0.5  # of the former, that a walker in its lane keeps
READY = 2.0  # distance before the opening at which a walker is in its lane [m]
NEAR_LANE = 4.0  # distance before the opening from which lanes are kept, and orders in them [m]
SAME_OPENING = 2.0  # between the middles of openings that are one, also in a corridor [m]
ABREAST = 0.05  # difference of ways to a lane at which none is the nearer [m]
LIKE_SPEED = 0.6  # most that the velocities of those differ who walk alike [m/s]
LEAST_RUN = 0.4  # along the way, in which it gets into it [m]
NEARLY = 0.5  # distance from its lane at which it goes on all the same [m]
MOST_BACK = 0.5  # way back, to get into it in front of those who come out [m]
TURN_TIME = 0.8  # within which the middle is not passed [s]
CLOSEST_STEPS = 3  # of the search for the places at which two walls are nearest


class Opening(NamedTuple):
    """An opening between two walls, seen by a person that goes through it.

    Attributes:
        x: of its middle [m].
        z: of the same.
        ahead_x: of the unit vector through it, in which the person goes.
        ahead_z: of the same.
        width: [m].
        left: way of the person to it, less than 0 behind it [m].
        aside: of the person, to the right of its middle [m].
    """

    x: float
    z: float
    ahead_x: float
    ahead_z: float
    width: float
    left: float
    aside: float


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
    leave_lane(person)
    if len(walls) < 2 or hypotenuse(x, z) < 0.1:
        return x, z
    for i in range(len(walls)):
        for j in range(i):
            found, a, b = _closest_places(person, solids, walls[j], walls[i])
            width = hypotenuse(b[0] - a[0], b[2] - a[2])
            if not found or width < NARROWEST or width > WIDEST:
                continue
            opening = _opening_between(person, a, b, width, x, z)
            if _leads_through(person, opening):
                share = _met_share(persons, places, order, n, near, opening)
                if share > 0.0:
                    return _turned_to_lane(person, opening, share, x, z)
    return x, z


@inlined
def leave_lane(person: Record) -> None:
    """Let a person keep to no lane."""
    person.lane_room = math.inf
    person.lane_right[0] = person.lane_right[1] = 0.0


@inlined
def _closest_places(
    person: Record, solids: Solids, first: int, second: int
) -> tuple[bool, Vector, Vector]:
    """Return whether two walls are near, and the places at which they are nearest to each other."""
    found, a = nearest_place(person, solids, first, (person.at[0], 0.0, person.at[1]))
    b = a
    for _ in range(CLOSEST_STEPS):
        if found:
            found, b = nearest_place(person, solids, second, a)
        if found:
            found, a = nearest_place(person, solids, first, b)
    return found, a, b


@inlined
def _opening_between(
    person: Record, a: Vector, b: Vector, width: float, x: float, z: float
) -> Opening:
    """Return the opening between two places of walls, for a person with a velocity x, z."""
    middle_x, middle_z = 0.5 * (a[0] + b[0]), 0.5 * (a[2] + b[2])
    ahead_x, ahead_z = (a[2] - b[2]) / width, (b[0] - a[0]) / width
    if ahead_x * x + ahead_z * z < 0.0:
        ahead_x, ahead_z = -ahead_x, -ahead_z
    to_x, to_z = middle_x - person.at[0], middle_z - person.at[1]
    left = to_x * ahead_x + to_z * ahead_z
    aside = to_x * ahead_z - to_z * ahead_x
    return Opening(middle_x, middle_z, ahead_x, ahead_z, width, left, aside)


@inlined
def _leads_through(person: Record, opening: Opening) -> bool:
    """Tell whether a person walks through an opening, or has just done so."""
    left, half = opening.left, 0.5 * opening.width
    if left < 0.0:
        return left > -LANE_END and abs(opening.aside) < half + ROUND_WALL
    x, z = person.goal[0] - opening.x, person.goal[1] - opening.z
    beyond = x * opening.ahead_x + z * opening.ahead_z
    if left > LANE_RANGE or beyond < -ROUND_WALL:
        return False
    # Where it passes between the walls, or goes around the end of one.
    passes = z * opening.ahead_x - x * opening.ahead_z
    if beyond > 0.0:
        passes = opening.aside + (passes - opening.aside) * left / (left + beyond)
    return abs(passes) < half + AT_WALL


@inlined
def _met_share(
    persons: Records, places: Array, order: Numbers, n: int, near: Numbers, opening: Opening
) -> float:
    """Return how much a person keeps to its lane, 0 to 1, by how many come the other way."""
    count, person = 0, persons[order[n]]
    for m in range(find_within(places, order, n, SEEN_BEFORE, near)):
        other = persons[near[m]]
        if not other.has_goal or other.frozen or other.owner == person.partner:
            continue
        x, z = other.at[0] - person.at[0], other.at[1] - person.at[1]
        to_x, to_z = other.goal[0] - other.at[0], other.goal[1] - other.at[1]
        along = to_x * opening.ahead_x + to_z * opening.ahead_z
        is_ahead = x * opening.ahead_x + z * opening.ahead_z > 0.0
        past_x, past_z = other.goal[0] - opening.x, other.goal[1] - opening.z
        if past_x * opening.ahead_x + past_z * opening.ahead_z > ROUND_WALL:
            continue  # It stays behind the opening.
        if is_ahead and along < -OPPOSITE * hypotenuse(to_x, to_z):
            count += 1
    return min(count / MANY, 1.0)


@inlined
def _turned_to_lane(
    person: Record, opening: Opening, share: float, x: float, z: float
) -> tuple[float, float]:
    """Return a wanted velocity turned to the right half of an opening, and note the lane."""
    left, aside = opening.left, opening.aside
    right_x, right_z = -opening.ahead_z, opening.ahead_x
    low = min(MIDDLE_ROOM, 0.25 * opening.width)
    high = max(0.5 * opening.width - WALL_ROOM, low)
    # Behind the opening it may go farther to the right.
    change = max(low - aside, 0.0)
    if left > 0.0 and aside > high:
        change = high - aside
    run = left - READY - max(low - aside, 0.0)
    run = max(run, LEAST_RUN if aside > low - NEARLY or left < 0.0 else -MOST_BACK)
    lane_x = run * opening.ahead_x + change * right_x
    lane_z = run * opening.ahead_z + change * right_z
    size = max(hypotenuse(lane_x, lane_z), 1e-9)
    share *= min(max((LANE_END + left) / FADING, 0.0), 1.0)
    speed = hypotenuse(x, z)
    person.lane_right[0], person.lane_right[1] = right_x, right_z
    person.lane_middle[0], person.lane_middle[1] = opening.x, opening.z
    outside = max(max(low - aside, aside - high), 0.0)
    person.way_to_lane = hypotenuse(left, outside) if left > 0.0 else left
    if left < NEAR_LANE:
        person.lane_room = max(aside - KEPT * low, 0.0)
    return x + share * (speed * lane_x / size - x), z + share * (speed * lane_z / size - z)


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


@inlined
def share_lane(person: Record, other: Record) -> bool:
    """Tell whether two people go along the same lane of an opening.

    Far from it some still cross the ways of others.
    """
    x, z = person.lane_right[0], person.lane_right[1]
    if x * other.lane_right[0] + z * other.lane_right[1] <= 0.0:
        return False
    x = person.lane_middle[0] - other.lane_middle[0]
    z = person.lane_middle[1] - other.lane_middle[1]
    if hypotenuse(x, z) > SAME_OPENING:
        return False
    x, z = person.velocity[0] - other.velocity[0], person.velocity[1] - other.velocity[1]
    is_near: bool = max(person.way_to_lane, other.way_to_lane) < NEAR_LANE
    return is_near or hypotenuse(x, z) < LIKE_SPEED


@inlined
def goes_before(person: Record, other: Record) -> bool:
    """Tell whether a person near an opening is nearer to it than another in its lane."""
    result: bool = person.way_to_lane < min(other.way_to_lane - ABREAST, NEAR_LANE)
    return result
