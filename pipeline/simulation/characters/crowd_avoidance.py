"""Crowd avoidance: walkers choose velocities at which they will not meet other people.

Each person that another will meet within a few seconds forbids a half plane of velocities. Two that
both walk share the way that is to be made, in a crowd by their right of way; of a standing person a
walker makes all of it. Within all half planes, the velocity nearest to the wanted one is taken. In
a throng where there is none, it keeps clear of their bodies and offends least against the space
around them. Who gets no further squeezes through, for whom standing people make way. In a crowd
walkers keep a headway, or their feet would strike the legs of those ahead, and brake rather than
step aside; they pass one another the more slowly the closer, heed walls, and keep to the right in
openings that others come through. Others are visited in order along x, so that a crowd costs little
more than a few. Walkers look at others in turns, a few of them in each step, and keep to what they
chose in between.

Source: van den Berg, Guy, Lin, Manocha, Reciprocal n-body collision avoidance, 2011 (ORCA): half
planes in section 4.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.arm_clearance import keep_arms_in
from pipeline.simulation.characters.barriers import (
    MOST_BARRIERS,
    find_barriers,
    forbid_wall,
    note_passage,
)
from pipeline.simulation.characters.gap_choice import (
    MOST_SEEN,
    expected_velocity,
    head_for_gap,
)
from pipeline.simulation.characters.half_planes import allowed_velocity, velocity_by_braking
from pipeline.simulation.characters.headway import headway_share, passing_share
from pipeline.simulation.characters.making_way import PERSONAL_SPACE, SMOOTHING, make_way
from pipeline.simulation.characters.neighbours import (
    Numbers,
    find_within,
    insert_nearest,
    order_along_x,
    places_in_order,
)
from pipeline.simulation.characters.passage_lanes import (
    forbid_other_lane,
    leave_lane,
    share_lane,
    take_lane,
)
from pipeline.simulation.characters.pelvis_motion import goal_velocity
from pipeline.simulation.characters.person_record import SITTING
from pipeline.simulation.characters.right_of_way import (
    MOST_SHARED,
    PATIENCE,
    hold_up_one_another,
    lag_at_crossing,
    lag_at_passage,
    lag_of_held_up,
)
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.walking_group import (
    gather_groups,
    keep_together,
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

LOOK_INTERVAL = 4  # steps from one look at others to the next
HORIZON = 3.0  # within which nobody is met [s]
STANDING_HORIZON = 1.2  # of a walker in a crowd that is held up, for people who stand [s]
SQUEEZING_HORIZON = 1.2  # of one that squeezes through: with more it stops far before a row [s]
PARTING_TIME = 0.5  # within which two that are too near part [s]
SIGHT_RANGE = 4.5  # [m]
WALL_SIGHT = 14.0  # of walls, between which it sees openings [m]
COMPANION_SPACE = 0.4  # of those who walk together
LANE_HORIZON = 0.7  # of those in one lane of an opening [s]
LANE_SPACE, SWAY = 0.36, 0.06  # of the same, in heights; more at a speed [heights / (m/s)]
TIGHT_SPACE = 0.36  # of one who squeezes through, by walkers
STANDING_SPACE = 0.3  # the same, by those who stand and swing no legs
STANDING_ROOM = 0.34  # around those in a crowd, or nobody would pass between rows that have arrived
SLOW = 0.4  # part of the wanted speed below which a walker begins to squeeze through
SQUEEZING, CROWD_SQUEEZING = 0.028, 0.012  # change of that in a look; in a crowd
THRONG_SIDESTEP = 0.3  # from which it is others that keep a walker, relative to its speed
SITTING_SPACE = 1.0  # of a sitting person, relative to a standing one
BESIDE = 0.8  # space to a person at the goal, relative to its distance from the goal
MOST_NEIGHBOURS = 10  # the nearest that are heeded
FIRMNESS = 0.5  # of the right of way where bodies would meet
QUICKEST = 1.15  # velocity in stepping aside, relative to the pace
HEAD_ON = 0.1  # sine of the angle to the right within which walkers head on pass on the right

# Of velocity across the way, relative to that along it, where all others come from the side.
MORE_SIDESTEP_COST = 1.0

HELD_UP_RATE = 0.25  # share of the change by which others hold it up that is noticed in a look
LATENESS_RATE, CALMING_RATE = 0.02, 0.0025  # change of it in a look: held up; walking freely
ARM_RATE = 0.06  # share of the change by which arms are kept in that is taken in a step


@allocating
def avoid_people(persons: Records, owners: Records, solids: Solids) -> None:
    """Choose the sidestep of every person, once a step."""
    gather_groups(persons)
    order, near = order_along_x(persons), np.zeros(len(persons), dtype=np.int64)
    places = places_in_order(persons, order)
    nearest = np.zeros(MOST_NEIGHBOURS, dtype=np.int64)
    seen = np.zeros(MOST_SEEN, dtype=np.int64)
    barriers = np.zeros(MOST_BARRIERS, dtype=np.int64)
    # Lines of velocities, x and z of a point and of the direction, to whose left all are allowed.
    lines = np.zeros((MOST_BARRIERS + 1 + 2 * MOST_NEIGHBOURS, 4))
    projected = np.zeros((MOST_BARRIERS + 1 + 2 * MOST_NEIGHBOURS, 4))
    for n in range(len(order)):
        person = persons[order[n]]
        person.looked = (person.looked + 1) % LOOK_INTERVAL
        if not person.has_goal:
            person.detour, person.impatience, person.held_up = 0.0, -PATIENCE, 0.0
            person.lateness, person.in_throng = 0.0, False
            person.arms_wanted_in = 0.0
            leave_lane(person)
            person.wanted_sidestep[0] = person.wanted_sidestep[1] = 0.0
            make_way(persons, places, order, n, near)
        else:
            person.gave_way = False
            if person.looked == 0:
                count = _find_nearest(persons, places, order, n, near, nearest)
                rooms = near, seen, barriers, lines, projected
                crowd = places, order
                _choose_sidestep(persons, owners, solids, crowd, n, nearest[:count], rooms)
            for c in range(2):
                change = person.wanted_sidestep[c] - person.sidestep[c]
                person.sidestep[c] += SMOOTHING * change
        person.arms_in += ARM_RATE * (person.arms_wanted_in - person.arms_in)


@allocating
def _choose_sidestep(
    persons: Records,
    owners: Records,
    solids: Solids,
    crowd: tuple[Array, Numbers],
    n: int,
    nearest: Numbers,
    rooms: tuple[Numbers, Numbers, Numbers, Array, Array],
) -> None:
    """Choose the sidestep of a walker, the n-th person in order.

    Args:
        persons: `PERSON` records.
        owners: `OWNER` records.
        solids: what stands about.
        crowd: (P, 2) x and z of the persons in their order along x [m], and their numbers in it.
        n: the person's place in the order.
        nearest: numbers of the nearest people.
        rooms: for the numbers of all people, of those it sees and of walls, and for the lines of
            walls and two of each of the nearest, twice.
    """
    (places, order), (near, seen, barriers, lines, projected) = crowd, rooms
    person = persons[order[n]]
    person.has_passage = False
    count = len(nearest)
    alone_x, alone_z = goal_velocity(person)
    wanted_x, wanted_z = alone_x, alone_z
    if person.group_size > 1:
        wanted_x, wanted_z = keep_together(persons, person, alone_x, alone_z)
    found = 0
    if count > 0:
        found = _find_walls(owners, person, solids, barriers, wanted_x, wanted_z)
        wanted_x, wanted_z = take_lane(
            persons, places, order, n, near, barriers[:found], solids, wanted_x, wanted_z
        )
    else:
        leave_lane(person)
    x, z, in_crowd = head_for_gap(
        persons, places, order, n, near, seen, barriers[:found], solids, wanted_x, wanted_z
    )
    keep_arms_in(persons, person, nearest, count, in_crowd)
    free_x, free_z = wanted_x, wanted_z
    if count > 0:
        walls = 0
        for k in range(found):
            if forbid_wall(person, solids, barriers[k], lines[walls]):
                walls += 1
        if forbid_other_lane(person, lines[walls]):
            walls += 1
        limit = QUICKEST * person.pace
        free_x, free_z = allowed_velocity(lines, projected, walls, 0, limit, wanted_x, wanted_z)
        _forbid_people(persons, person, nearest, in_crowd, x, z, lines[walls:])
        x, z = _choose_velocity(
            persons, person, nearest, count, in_crowd, x, z, walls, lines, projected
        )
    person.held_up += HELD_UP_RATE * (hypotenuse(x - free_x, z - free_z) - person.held_up)
    _squeeze(person, CROWD_SQUEEZING if in_crowd else SQUEEZING, wanted_x, wanted_z)
    person.wanted_sidestep[0], person.wanted_sidestep[1] = x - alone_x, z - alone_z


@allocating
def _find_walls(
    owners: Records, person: Record, solids: Solids, barriers: Numbers, x: float, z: float
) -> int:
    """Write the numbers of the walls beside a walker that goes along x and z; return how many."""
    found = find_barriers(person, owners[person.owner].mass, solids, WALL_SIGHT, barriers)
    if found > 0:
        note_passage(person, solids, barriers[0], x, z)
    return found


@compiled
def _forbid_people(
    persons: Records,
    person: Record,
    nearest: Numbers,
    in_crowd: bool,
    x: float,
    z: float,
    lines: Array,
) -> None:
    """Write the lines of velocities at which a walker meets the nearest people.

    First those of their bodies, then those of the space around them.
    """
    squeeze = max(person.impatience, 0.0)
    for k in range(len(nearest)):
        other = persons[nearest[k]]
        tight = TIGHT_SPACE if other.has_goal else STANDING_SPACE
        room = PERSONAL_SPACE if other.has_goal or not in_crowd else STANDING_ROOM
        own_space = room - squeeze * (room - tight)
        if walks_with(person, other):
            own_space = min(own_space, COMPANION_SPACE)
        horizon = HORIZON
        if in_crowd and not other.has_goal:
            waited = min(1.0 + person.impatience / PATIENCE, 1.0)
            horizon += waited * (STANDING_HORIZON - HORIZON)
        if share_lane(person, other):
            horizon = LANE_HORIZON
            swaying = SWAY * hypotenuse(person.velocity[0], person.velocity[1])
            own_space = min(own_space, LANE_SPACE + swaying)
        lag, firmness = 0.0, FIRMNESS
        if in_crowd and _shares_way(person, other):
            lag = lag_at_passage(person, other)
            if lag == 0.0:
                lag = lag_at_crossing(person, other)
                if lag == 0.0:
                    lag = lag_of_held_up(person, other)
            else:
                # Between walls there is no room to evade one that does not.
                firmness = 0.0
        # Bodies keep clear of one another more alike than the space around them.
        _forbid(person, other, tight, horizon, firmness * lag, 0.0, x, z, lines[k])
        space_line = lines[len(nearest) + k]
        _forbid(person, other, own_space, horizon, lag, 1.0 - squeeze, x, z, space_line)


@compiled
def _choose_velocity(
    persons: Records,
    person: Record,
    nearest: Numbers,
    count: int,
    in_crowd: bool,
    x: float,
    z: float,
    walls: int,
    lines: Array,
    projected: Array,
) -> tuple[float, float]:
    """Return the allowed velocity nearest to a wanted one, as fast as others let it be."""
    limit = QUICKEST * person.pace
    if not in_crowd:
        x, z = allowed_velocity(lines, projected, walls, count, limit, x, z)
        share = headway_share(persons, person, nearest, count, x, z, False)
    else:
        cost = 1.0 + MORE_SIDESTEP_COST * _crossing(persons, nearest, count, x, z)
        x, z = velocity_by_braking(lines, projected, walls, count, limit, cost, x, z)
        share = headway_share(persons, person, nearest, count, x, z)
        share = min(share, passing_share(persons, person, nearest, count))
    return share * x, share * z


@compiled
def _crossing(persons: Records, nearest: Numbers, count: int, x: float, z: float) -> float:
    """Return how much the nearest people walk across the way of a walker, 0 to 1."""
    across, total, speed = 0.0, 1e-9, max(hypotenuse(x, z), 1e-9)
    for k in range(count):
        v = persons[nearest[k]].velocity
        across += abs(v[0] * z - v[1] * x) / speed
        total += hypotenuse(v[0], v[1])
    return across / total


@inlined
def _squeeze(person: Record, change: float, wanted_x: float, wanted_z: float) -> None:
    """Let a walker that hardly gets on squeeze through, and others keep their distance again.

    Whom others hold up meanwhile grows late.
    """
    speed = wanted_x * wanted_x + wanted_z * wanted_z
    gain = person.velocity[0] * wanted_x + person.velocity[1] * wanted_z
    sign = 1.0 if gain < SLOW * speed else -1.0
    person.impatience = min(max(person.impatience + sign * change, -PATIENCE), 1.0)
    is_held_up = person.held_up * person.held_up > THRONG_SIDESTEP * THRONG_SIDESTEP * speed
    person.in_throng = is_held_up and person.impatience > 0.0
    growth = LATENESS_RATE if person.in_throng and sign > 0.0 else -CALMING_RATE
    person.lateness = min(max(person.lateness + growth, 0.0), 1.0)


@allocating
def _find_nearest(
    persons: Records, places: Array, order: Numbers, n: int, near: Numbers, nearest: Numbers
) -> int:
    """Write the numbers of the nearest people whom the n-th in order sees; return how many."""
    person = persons[order[n]]
    squares = np.zeros(MOST_NEIGHBOURS)
    count = 0
    for m in range(find_within(places, order, n, SIGHT_RANGE, near)):
        other = persons[near[m]]
        x, z = other.at[0] - person.at[0], other.at[1] - person.at[1]
        square = x * x + z * z
        if other.owner != person.partner and square > 1e-18:
            count = insert_nearest(squares, nearest, count, square, near[m])
    return count


@inlined
def _shares_way(one: Record, other: Record) -> bool:
    """Tell whether another walks as well, and shares the way that two must make."""
    result: bool = other.has_goal and not other.frozen and other.partner != one.owner
    return result


@inlined
def _coming_velocity(one: Record, other: Record, lag: float) -> tuple[float, float]:
    """Return the velocity along x and z at which another comes, for one with a lag [m/s].

    Of two who hold one another up, the second steps back before the first, who would stand before
    it for good.
    """
    x, z = other.velocity[0], other.velocity[1]
    if lag > 0.0 and hold_up_one_another(one, other):
        x, z = expected_velocity(other)
    return x, z


@compiled
def _forbid(
    one: Record,
    other: Record,
    own_space: float,
    horizon: float,
    lag: float,
    keeps_groups: float,
    wanted_x: float,
    wanted_z: float,
    line: Array,
) -> None:
    """Write the line of velocities beyond which one person would meet another.

    Args:
        one: the person.
        other: the other.
        own_space: around a person, in heights.
        horizon: within which nobody is met [s].
        lag: of the person at the crossing of their ways, -1 to 1.
        keeps_groups: share of the width of groups that is passed around, 0 to 1.
        wanted_x: velocity [m/s].
        wanted_z: of the same.
        line: written.
    """
    share, own_x, own_z = 0.5 + MOST_SHARED * lag, one.velocity[0], one.velocity[1]
    # By its own velocity a walker that has stopped before a standing person, or with the right of
    # way, would stay there.
    if not _shares_way(one, other):
        share, own_x, own_z = 1.0, wanted_x, wanted_z
    elif lag < 0.0:
        own_x, own_z = own_x - lag * (wanted_x - own_x), own_z - lag * (wanted_z - own_z)
    others_x, others_z = _coming_velocity(one, other, lag)
    space = 0.5 * own_space * (one.height + other.height)
    if other.posture == SITTING:
        space *= SITTING_SPACE
    # Nobody would arrive within the space of a person that stays there.
    beside = hypotenuse(one.goal[0] - other.at[0], one.goal[1] - other.at[1])
    beside = min(max(beside, one.stop_distance), one.neighbour_distance)
    tight = 0.5 * TIGHT_SPACE * (one.height + other.height)
    tight = min(tight, BESIDE * one.neighbour_distance)
    space = min(space, max(BESIDE * beside, tight))
    x, z = other.at[0] - one.at[0], other.at[1] - one.at[1]
    width = keeps_groups * (one.group_width + other.group_width)
    if width > 0.0 and not walks_with(one, other):
        row_x, row_z = rows_apart(one, other)
        if hypotenuse(row_x, row_z) > space + width:
            x, z, space = row_x, row_z, space + width
    square = x * x + z * z
    # Velocity of one relative to the other, and that from the middle of the cut-off circle.
    vx = own_x + one.carry_velocity[0] - others_x - other.carry_velocity[0]
    vz = own_z + one.carry_velocity[1] - others_z - other.carry_velocity[1]
    is_apart = square > space * space
    is_beside = one.neighbour_distance < math.inf
    if one.impatience > 0.0 or is_beside:
        # It will not go beyond its goal, least of all one that takes a place beside others.
        left = hypotenuse(one.goal[0] - one.at[0], one.goal[1] - one.at[1])
        arrival = left / max(hypotenuse(wanted_x, wanted_z), 1e-9)
        shortest = min(max(arrival, PARTING_TIME), SQUEEZING_HORIZON)
        shortest = min(shortest, horizon)
        horizon += (1.0 if is_beside else one.impatience) * (shortest - horizon)
    wx, wz = vx - x / horizon, vz - z / horizon
    size, along = hypotenuse(wx, wz), wx * x + wz * z
    if is_apart and (along >= 0.0 or along * along <= space * space * size * size):
        # A side of the cone of all velocities that meet: the nearer, if it is not about the same.
        leg = math.sqrt(square - space * space)
        if x * wz - z * wx > -HEAD_ON * size * math.sqrt(square):
            dx, dz = (x * leg - z * space) / square, (x * space + z * leg) / square
        else:
            dx, dz = -(x * leg + z * space) / square, (x * space - z * leg) / square
        part = vx * dx + vz * dz
        ux, uz = part * dx - vx, part * dz - vz
    elif is_apart:
        size = max(size, 1e-9)
        wx, wz = wx / size, wz / size
        dx, dz = wz, -wx
        ux, uz = (space / horizon - size) * wx, (space / horizon - size) * wz
    else:
        # Straight away from one another: a cut-off circle so near has no side that is nearer.
        distance = math.sqrt(square)
        wx, wz = -x / distance, -z / distance
        dx, dz = wz, -wx
        more = (space - distance) / PARTING_TIME - (vx * wx + vz * wz)
        ux, uz = more * wx, more * wz
    line[0], line[1] = own_x + share * ux, own_z + share * uz
    line[2], line[3] = dx, dz
