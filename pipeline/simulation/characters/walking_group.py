"""Walking group: people who belong together walk side by side and wait for one another.

Those of a group who go the same way keep the pace of the slowest. Each walks in a row across the
way, where it sees the others without turning its head far, drawn towards their middle and kept
apart by its own space. From three on the row is bent to a V among many others, with the middle
behind, and in a narrow place it becomes a single file. Who is ahead waits for who falls behind.
Others pass around the row.

Source: Moussaïd, Perozo, Garnier, Helbing and Theraulaz 2010, eq. 2 to 4: gaze, attraction to the
    middle, repulsion. Forces there are velocities here, and the place from which all are in view
    is given instead of found.
"""

from __future__ import annotations

import math

from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined

SPACING = 0.45  # between the middles of two side by side, in heights; 0.78 m there
FILE_SPACING = 0.75  # of two one behind the other, in heights
FARTHEST = 7.0  # from one another of those who walk together [m]
SAME_WAY = 0.3  # cosine of the angle between the ways of two who walk together
NEAR_GOAL = 1.5  # within which the way is no longer told from the goal [m]
TURNING = 0.05  # share of the way to a new direction that is taken in a step
VEE_RATE = 0.01  # change of the bend of the row in a step
CLOSING_RATE = 0.9  # at which places in the row are taken [1/s]
MOST_ASIDE = 0.4  # speed across the way at which they are [m/s]
CATCH_UP = 1.12  # speed of who falls behind, relative to the pace of the slowest
WAITING_DISTANCE, WAITING_RANGE = 1.0, 0.8  # behind from which others slow down, until they stand
WAITING = 0.0036  # share of its patience that one who waits loses in a look: 12 s
ARRIVAL_RANGE = 1.2  # before its goal within which each goes to its own [m]
RANK_HOLD = 0.35  # by which two who change places have to be past one another, in spacings
WIDEST_ROW = 1.5  # half width of a row that others pass around [m]
VEE_CROWD = 6  # people ahead among whom the row is bent most
VEE_SIGHT = 4.0  # ahead and to either side, in which they are counted [m]
VEE_DEPTH, VEE_CLOSENESS = 0.5, 0.2  # of the bent row: depth in spacings, part of its lost width


@inlined
def walks_with(one: Record, other: Record) -> bool:
    """Tell whether two people belong together and both walk in company."""
    result: bool = one.group >= 0 and one.group == other.group and one.group_size > 1
    return result


@inlined
def rows_apart(one: Record, other: Record) -> tuple[float, float]:
    """Return the offset along x and z from the row of one person to that of another [m]."""
    from_x, from_z, to_x, to_z = one.at[0], one.at[1], other.at[0], other.at[1]
    if one.group_width > 0.0:
        from_x, from_z = one.group_row[0], one.group_row[1]
    if other.group_width > 0.0:
        to_x, to_z = other.group_row[0], other.group_row[1]
    return to_x - from_x, to_z - from_z


@compiled
def are_on_one_way(one: Record, other: Record) -> bool:
    """Tell whether two who belong together walk the same way, near one another."""
    if one.group != other.group or not (one.has_goal and other.has_goal):
        return False
    if one.frozen or other.frozen or one.partner == other.owner or other.partner == one.owner:
        return False
    if math.hypot(other.at[0] - one.at[0], other.at[1] - one.at[1]) > FARTHEST:
        return False
    ax, az = one.goal[0] - one.at[0], one.goal[1] - one.at[1]
    bx, bz = other.goal[0] - other.at[0], other.goal[1] - other.at[1]
    a, b = math.hypot(ax, az), math.hypot(bx, bz)
    goals_apart = math.hypot(other.goal[0] - one.goal[0], other.goal[1] - one.goal[1])
    is_same = ax * bx + az * bz > SAME_WAY * a * b
    return is_same or goals_apart < 2.0 * NEAR_GOAL


@compiled
def gather_groups(persons: Records) -> None:
    """Find with whom each person walks, and the row in which they do."""
    for i in range(len(persons)):
        if persons[i].group >= 0:
            _count_companions(persons, i)
    for i in range(len(persons)):
        if persons[i].group >= 0:
            _find_row(persons, i)
    for i in range(len(persons)):
        persons[i].group_rank = persons[i].group_next


@compiled
def _count_companions(persons: Records, i: int) -> None:
    """Find how many walk together, where to, and at which pace."""
    person = persons[i]
    size, pace = 1, person.pace
    x, z = person.goal[0] - person.at[0], person.goal[1] - person.at[1]
    for j in range(len(persons)):
        other = persons[j]
        if j != i and are_on_one_way(person, other):
            size, pace = size + 1, min(pace, other.pace)
            x += other.goal[0] - other.at[0]
            z += other.goal[1] - other.at[1]
    if size > 1:
        far = math.hypot(x, z)
        if person.group_size == 1:
            # A new group; who has walked in it before knows the way.
            person.group_ahead[0] = person.group_ahead[1] = 0.0
        is_new = person.group_ahead[0] == 0.0 and person.group_ahead[1] == 0.0
        if far > size * NEAR_GOAL or (is_new and far > 1e-9):
            share = 1.0 if is_new else TURNING
            ax = person.group_ahead[0] + share * (x / far - person.group_ahead[0])
            az = person.group_ahead[1] + share * (z / far - person.group_ahead[1])
            far = max(math.hypot(ax, az), 1e-9)
            person.group_ahead[0], person.group_ahead[1] = ax / far, az / far
    else:
        person.group_wait = 0.0
    person.group_size, person.group_pace = size, pace
    person.group_width = 0.0


@compiled
def _middle(persons: Records, person: Record) -> tuple[float, float, float]:
    """Return the middle of those who walk together, x and z, and their mean height [m]."""
    x, z, height = person.at[0], person.at[1], person.height
    for j in range(len(persons)):
        other = persons[j]
        if other.owner != person.owner and are_on_one_way(person, other):
            x, z, height = x + other.at[0], z + other.at[1], height + other.height
    size = person.group_size
    return x / size, z / size, height / size


@compiled
def _find_row(persons: Records, i: int) -> None:
    """Find the place of a person in the row of its group, and how wide that is."""
    person = persons[i]
    if person.group_size == 1:
        return
    ax, az = person.group_ahead[0], person.group_ahead[1]
    x, z, height = _middle(persons, person)
    spacing = SPACING * height
    # In a file all are about in the middle, and keep the order they had.
    hold = RANK_HOLD + 1.0 - person.group_room
    own = aside(person, x, z, ax, az) + hold * spacing * person.group_rank
    rank, width = 0, abs(aside(person, x, z, ax, az))
    for j in range(len(persons)):
        other = persons[j]
        if j == i or not are_on_one_way(person, other):
            continue
        across = aside(other, x, z, ax, az)
        width = max(width, abs(across))
        place = across + hold * spacing * other.group_rank
        if place < own or (place == own and j < i):
            rank += 1
    across = aside(person, x, z, ax, az)
    person.group_row[0], person.group_row[1] = (
        person.at[0] + across * az,
        person.at[1] - across * ax,
    )
    person.group_width = min(width, WIDEST_ROW)
    person.group_next = rank
    person.group_file = _place_in_file(persons, person)
    bend = _crowd_ahead(persons, person, x, z) if person.group_size > 2 else 0.0
    person.group_vee += min(max(bend - person.group_vee, -VEE_RATE), VEE_RATE)


@compiled
def _place_in_file(persons: Records, person: Record) -> int:
    """Return the place of a person in a single file: behind who is followed, or by its rank."""
    leaders, rank = 0, 0
    for j in range(len(persons)):
        other = persons[j]
        is_own = other.owner == person.owner
        if not other.comes_along and (is_own or are_on_one_way(person, other)):
            leaders, rank = leaders + 1, other.group_rank
    place: int = person.group_rank
    if leaders != 1:
        return place
    if not person.comes_along:
        return 0
    return place + 1 if place < rank else place


@compiled
def _crowd_ahead(persons: Records, person: Record, x: float, z: float) -> float:
    """Return how crowded the way of a group is before its middle at x and z, from 0 to 1."""
    ax, az = person.group_ahead[0], person.group_ahead[1]
    count = 0
    for j in range(len(persons)):
        other = persons[j]
        if other.group != person.group:
            far, across = onward(other, x, z, ax, az), aside(other, x, z, ax, az)
            count += 0.0 < far < VEE_SIGHT and abs(across) < 0.5 * VEE_SIGHT
    return min(count / VEE_CROWD, 1.0)


@compiled
def detour_of_group(persons: Records, person: Record) -> float:
    """Return the mean turn towards gaps of those who walk together [rad]."""
    total = person.detour
    for j in range(len(persons)):
        other = persons[j]
        if other.owner != person.owner and are_on_one_way(person, other):
            total += other.detour
    result: float = total / person.group_size
    return result


@compiled
def _place(person: Record, height: float) -> tuple[float, float]:
    """Return the place of a person in the row, ahead and to the right of the middle [m].

    Args:
        person: who walks.
        height: mean of the group [m].
    """
    middle = 0.5 * (person.group_size - 1)
    off, room, vee = person.group_rank - middle, person.group_room, person.group_vee
    spacing = SPACING * height
    across = room * (1.0 - VEE_CLOSENESS * vee) * spacing * off
    # The mean distance from the middle of ranks 0 to n - 1 is n / 4, or a little less.
    size = person.group_size
    mean = 0.25 * size if size % 2 == 0 else 0.25 * (size - 1.0 / size)
    ahead = vee * VEE_DEPTH * spacing * (abs(off) - mean)
    ahead -= (1.0 - room) * FILE_SPACING * height * (person.group_file - middle)
    return ahead, across


@compiled
def _line(persons: Records, person: Record, height: float, x: float, z: float) -> float:
    """Return how far the row is to the right of the middle of the group at x and z [m].

    Who is followed by all others keeps to its way, and the row goes with it.
    """
    ax, az = person.group_ahead[0], person.group_ahead[1]
    leaders, line = 0, 0.0
    for j in range(len(persons)):
        other = persons[j]
        is_own = other.owner == person.owner
        if not other.comes_along and (is_own or are_on_one_way(person, other)):
            _, across = _place(other, height)
            leaders, line = leaders + 1, aside(other, x, z, ax, az) - across
    return line if leaders == 1 else 0.0


@inlined
def aside(person: Record, x: float, z: float, ax: float, az: float) -> float:
    """Return how far a person is to the right of a place on a way along ax, az [m]."""
    result: float = (person.at[1] - z) * ax - (person.at[0] - x) * az
    return result


@inlined
def onward(person: Record, x: float, z: float, ax: float, az: float) -> float:
    """Return how far a person is ahead of a place on a way along ax, az [m]."""
    result: float = (person.at[0] - x) * ax + (person.at[1] - z) * az
    return result


@compiled
def keep_together(
    persons: Records, person: Record, wanted_x: float, wanted_z: float
) -> tuple[float, float]:
    """Return the velocity at which a person walks to its goal in company [m/s].

    Args:
        persons: `PERSON` records.
        person: who walks.
        wanted_x: velocity at which it would walk alone [m/s].
        wanted_z: of the same.
    """
    speed = math.hypot(wanted_x, wanted_z)
    if speed < 1e-9:
        return wanted_x, wanted_z
    ax, az = person.group_ahead[0], person.group_ahead[1]
    x, z, height = _middle(persons, person)
    left = math.hypot(person.goal[0] - person.at[0], person.goal[1] - person.at[1])
    left -= person.stop_distance
    share = min(max(left / ARRIVAL_RANGE - 0.3, 0.0), 1.0)
    ahead, across = onward(person, x, z, ax, az), aside(person, x, z, ax, az)
    place_ahead, place_across = _place(person, height)
    # How far the last of the others is behind its place.
    behind = 0.0
    for j in range(len(persons)):
        other = persons[j]
        if other.owner != person.owner and are_on_one_way(person, other):
            other_ahead, _ = _place(other, height)
            off = (ahead - place_ahead) - (onward(other, x, z, ax, az) - other_ahead)
            behind = max(behind, off)
    pace = min(speed, person.group_pace)
    slow = min(max(1.0 - (behind - WAITING_DISTANCE) / WAITING_RANGE, 0.0), 1.0)
    if slow >= 1.0:
        person.group_wait = 0.0
    elif person.group_wait < 1.0:
        person.group_wait += WAITING
    else:
        slow = 1.0
    haste = CLOSING_RATE * share * (place_ahead - ahead)
    most = CATCH_UP * person.group_pace if left > ARRIVAL_RANGE else speed
    along = slow * min(max(pace + haste, 0.3 * pace), most)
    place_across += _line(persons, person, height, x, z)
    sideways = CLOSING_RATE * share * (place_across - across)
    sideways = min(max(sideways, -MOST_ASIDE), MOST_ASIDE)
    # Nobody steps aside faster than it goes on.
    sideways = min(max(sideways, -0.5 * along), 0.5 * along)
    return along * wanted_x / speed - sideways * az, along * wanted_z / speed + sideways * ax
