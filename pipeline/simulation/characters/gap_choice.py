"""Gap choice: in a crowd, the direction in which a walker gets nearest to its goal.

Half planes alone make two dense groups that meet stand before one another: nobody gives way as
far as the next gap, which may be to the side. So a walker that sees several people looks in some
directions for how far it would get before it met somebody, and heads for the one that leads
nearest to its goal. People who walk the same way open gaps for one another, so lanes form.

Source: Moussaïd, Helbing and Theraulaz 2011, eq. 1.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.barriers import free_way
from pipeline.simulation.characters.neighbours import Numbers, find_within, insert_nearest
from pipeline.simulation.characters.passage_lanes import way_in_lane
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.walking_group import (
    detour_of_group,
    rows_apart,
    walks_with,
)
from pipeline.simulation.dynamics.compiled import (
    Record,
    Records,
    allocating,
    compiled,
    inlined,
)
from pipeline.simulation.dynamics.vectors import hypotenuse
from pipeline.simulation.spatial import Array

SIGHT = 6.0  # distance ahead up to which gaps are judged [m]
CROWD = 4  # people within sight and ahead from whom on a walker looks for gaps
WIDEST = math.radians(70.0)  # to either side of the way to the goal
DIRECTIONS = 10  # to each side
TURNS = np.array([k * WIDEST / DIRECTIONS for k in range(-DIRECTIONS, DIRECTIONS + 1)])
TURN_COSINES = np.array([math.cos(turn) for turn in TURNS])
TURN_SINES = np.array([math.sin(turn) for turn in TURNS])
GAP = 0.42  # between the middles of two people, in heights
STANDING_GAP = 0.36  # the same, where the other stands
HABIT = 0.85  # cost of the direction nearest to the one taken before, relative to others
RIGHT_SIDE = 0.02  # part of its cost by which a direction to the right is better
TURNING = 0.115  # share of the way to a new direction that is taken in a look
COMMON_WAY = 0.34  # share of the way to the direction of its group that is taken in a look
EXPECTED_SPEED = 0.4  # of those who are held up [m/s]
MOST_SEEN = 24


@compiled
def head_for_gap(
    persons: Records,
    places: Array,
    order: Numbers,
    n: int,
    near: Numbers,
    seen: Numbers,
    walls: Numbers,
    solids: Solids,
    x: float,
    z: float,
) -> tuple[float, float, bool]:
    """Return the wanted velocity of the n-th person in order, turned towards a gap.

    Also tell whether it is in a crowd.

    Args:
        persons: `PERSON` records.
        places: (P, 2) x and z of all people in their order along x [m].
        order: their numbers along x.
        n: the person's place in the order.
        near: room for all people.
        seen: room for those it sees.
        walls: numbers of the solids about it.
        solids: of other rooms.
        x: of its velocity to the goal [m/s].
        z: of the same.
    """
    person = persons[order[n]]
    speed = hypotenuse(x, z)
    count = 0
    if speed > 0.1:
        count = _people_ahead(persons, places, order, n, near, seen, x / speed, z / speed)
    angle = 0.0
    if count >= CROWD:
        left = hypotenuse(person.goal[0] - person.at[0], person.goal[1] - person.at[1])
        angle = _best_direction(
            persons, person, seen[:count], walls, solids, x, z, speed, min(left, SIGHT)
        )
    person.detour += TURNING * (angle - person.detour)
    if person.group_size > 1:
        person.detour += COMMON_WAY * (detour_of_group(persons, person) - person.detour)
    c, s = math.cos(person.detour), math.sin(person.detour)
    return c * x - s * z, s * x + c * z, count >= CROWD


@allocating
def _people_ahead(
    persons: Records,
    places: Array,
    order: Numbers,
    n: int,
    near: Numbers,
    seen: Numbers,
    x: float,
    z: float,
) -> int:
    """Write the numbers of the nearest people before one that goes along x, z; return how many."""
    person = persons[order[n]]
    count = 0
    squares = np.zeros(MOST_SEEN)
    for m in range(find_within(places, order, n, SIGHT, near)):
        other = persons[near[m]]
        dx, dz = other.at[0] - person.at[0], other.at[1] - person.at[1]
        is_other = other.owner != person.partner and not walks_with(person, other)
        square = dx * dx + dz * dz
        if is_other and dx * x + dz * z > 0.0:
            count = insert_nearest(squares, seen, count, square, near[m])
    return count


@allocating
def _best_direction(
    persons: Records,
    person: Record,
    seen: Numbers,
    walls: Numbers,
    solids: Solids,
    x: float,
    z: float,
    speed: float,
    farthest: float,
) -> float:
    """Return the turn from the way to the goal that leads nearest to it [rad]."""
    ways = _ways_between_walls(person, walls, solids, x, z, farthest)
    for m in seen:
        other = persons[m]
        x_off, z_off, room = _room_before(person, other)
        v_x, v_z = expected_velocity(other)
        _shorten_ways(ways, x_off, z_off, room, v_x, v_z)
    best, cheapest = 0.0, math.inf
    for k in range(len(TURNS)):
        free = ways[3, k]
        cost = farthest * farthest + free * free - 2.0 * farthest * free * TURN_COSINES[k]
        if abs(TURNS[k] - person.detour) < 0.6 * WIDEST / DIRECTIONS:
            cost *= HABIT
        if k > DIRECTIONS:
            cost *= 1.0 - RIGHT_SIDE
        if cost < cheapest:
            best, cheapest = TURNS[k], cost
    return best


@allocating
def _ways_between_walls(
    person: Record, walls: Numbers, solids: Solids, x: float, z: float, farthest: float
) -> Array:
    """Return (4, K) of all directions: velocity along x and z, its size, and the free way."""
    ways = np.empty((4, len(TURNS)))
    for k in range(len(TURNS)):
        c, s = TURN_COSINES[k], TURN_SINES[k]
        ways[0, k], ways[1, k] = c * x - s * z, s * x + c * z
        ways[2, k], ways[3, k] = hypotenuse(ways[0, k], ways[1, k]), farthest
    for k in range(len(TURNS)):
        size = max(ways[2, k], 1e-9)
        x_ahead, z_ahead = ways[0, k] / size, ways[1, k] / size
        ways[3, k] = way_in_lane(person, x_ahead, z_ahead, farthest)
        for wall in walls:
            free = free_way(person, solids, wall, x_ahead, z_ahead, farthest)
            ways[3, k] = min(ways[3, k], free)
    return ways


@inlined
def expected_velocity(other: Record) -> tuple[float, float]:
    """Return the velocity along x and z at which another is expected to go on [m/s].

    One that is held up goes where it wants to as soon as it can.
    """
    x, z = other.velocity[0], other.velocity[1]
    if other.has_goal and not other.frozen:
        to_x, to_z = other.goal[0] - other.at[0], other.goal[1] - other.at[1]
        far = max(hypotenuse(to_x, to_z), 1e-9)
        more = max(min(EXPECTED_SPEED, other.pace) - hypotenuse(x, z), 0.0)
        x, z = x + more * to_x / far, z + more * to_z / far
    return x, z


@inlined
def _room_before(person: Record, other: Record) -> tuple[float, float, float]:
    """Return the offset of another along x and z [m], and squared distance less squared gap."""
    x, z = other.at[0] - person.at[0], other.at[1] - person.at[1]
    gap = 0.5 * (GAP if other.has_goal else STANDING_GAP) * (person.height + other.height)
    # A group passes around others as a whole, and they around it.
    width = person.group_width + other.group_width
    if width > 0.0:
        row_x, row_z = rows_apart(person, other)
        if hypotenuse(row_x, row_z) > gap + width:
            x, z, gap = row_x, row_z, gap + width
    square = x * x + z * z
    gap = min(gap, 0.95 * math.sqrt(square))
    return x, z, square - gap * gap


@inlined
def _shorten_ways(
    ways: Array, x: float, z: float, room: float, other_x: float, other_z: float
) -> None:
    """Shorten ways of a person to where it meets another, all at once: without branches.

    Args:
        ways: (4, K) velocities along x and z, their sizes [m/s], and free ways [m]; changed.
        x: offset of the other [m].
        z: of the same.
        room: its squared distance less the squared gap at which they meet [m²].
        other_x: velocity of the other [m/s].
        other_z: of the same.
    """
    for k in range(ways.shape[1]):
        wx, wz = ways[0, k] - other_x, ways[1, k] - other_z
        along, speed = x * wx + z * wz, wx * wx + wz * wz
        root = along * along - speed * room
        time = (along - math.sqrt(max(root, 0.0))) / (speed if speed > 0.0 else 1.0)
        met = time * ways[2, k]
        is_nearer = (along > 0.0) & (root >= 0.0) & (met < ways[3, k])
        ways[3, k] = met if is_nearer else ways[3, k]
