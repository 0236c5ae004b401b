"""Making way: standing people step aside for those who squeeze through, and go back after it."""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.neighbours import Numbers, find_neighbours
from pipeline.simulation.characters.person_record import SITTING, SWINGING
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.spatial import Array

WAY_RANGE, WAY_WIDTH = 1.6, 0.7  # ahead and aside, in which standing people make way [m]
WAY_SPEED = 0.6  # at which they do [m/s]
RETURN_SPEED = 0.3  # back to where they stood [m/s]
AT_POST, FAR_FROM_POST = 0.08, 2.0  # distances from there: back again; driven off for good [m]
LEAST_SPACE, CLOSING_TIME = 0.36, 0.8  # to those beside it, in heights; to come so near [s]
LEAST_SIDESTEP = 1e-3  # that is none [m/s]
PERSONAL_SPACE = 0.47  # between the middles of two people, in heights
SMOOTHING = 0.5  # share of the wanted sidestep taken over in a step


@compiled
def make_way(persons: Records, places: Array, order: Numbers, n: int, near: Numbers) -> None:
    """Let a standing person with nothing to do step aside for those who squeeze through.

    When they have passed, it goes back to where it stood, as soon as that is free.

    Args:
        persons: `PERSON` records.
        places: (P, 2) x and z of all people in their order along x [m].
        order: their numbers along x.
        n: the person's place in the order.
        near: room for all people.
    """
    person = persons[order[n]]
    x, z = 0.0, 0.0
    if _is_idle(person):
        x, z = _way_asked(persons, places, order, n, near)
        x, z = _clear_of_others(persons, places, order, n, near, x, z)
        if x != 0.0 or z != 0.0:
            if not person.gave_way:
                person.gave_way = True
                person.post[0], person.post[1] = person.at[0], person.at[1]
        elif person.gave_way:
            x, z = _way_back(persons, order, n)
    else:
        person.gave_way = False
    person.sidestep[0] += SMOOTHING * (x - person.sidestep[0])
    person.sidestep[1] += SMOOTHING * (z - person.sidestep[1])
    if math.hypot(person.sidestep[0], person.sidestep[1]) < LEAST_SIDESTEP:
        person.sidestep[0], person.sidestep[1] = 0.0, 0.0


@inlined
def _is_idle(person: Record) -> bool:
    """Tell whether a person without a goal stands about with nothing to do."""
    free = person.partner == NOBODY and not person.has_facing and person.kick_foot < 0
    swings = person.arm_mode[0] == SWINGING and person.arm_mode[1] == SWINGING
    # One that still arrives would drift on, and never end its walk.
    stands = not person.stepping or person.gave_way
    result: bool = free and swings and stands and person.posture != SITTING
    return result


@compiled
def _way_asked(
    persons: Records, places: Array, order: Numbers, n: int, near: Numbers
) -> tuple[float, float]:
    """Return the velocity at which a person makes way for those who squeeze through [m/s]."""
    person = persons[order[n]]
    x, z = 0.0, 0.0
    for m in range(find_neighbours(places, order, n, WAY_RANGE, near)):
        other = persons[near[m]]
        dx, dz = person.at[0] - other.at[0], person.at[1] - other.at[1]
        if other.has_goal and other.impatience > 0.0 and other.partner != person.owner:
            gx, gz = other.goal[0] - other.at[0], other.goal[1] - other.at[1]
            far = max(math.hypot(gx, gz), 1e-9)
            ahead, aside = (gx * dx + gz * dz) / far, (gx * dz - gz * dx) / far
            if 0.0 < ahead < WAY_RANGE and abs(aside) < WAY_WIDTH:
                step = other.impatience * (1.0 - abs(aside) / WAY_WIDTH)
                step *= 1.0 if aside > 0.0 else -1.0
                x -= step * gz / far
                z += step * gx / far
    return WAY_SPEED * x, WAY_SPEED * z


@compiled
def _clear_of_others(
    persons: Records, places: Array, order: Numbers, n: int, near: Numbers, x: float, z: float
) -> tuple[float, float]:
    """Return a velocity without what leads into the way of other people [m/s]."""
    person = persons[order[n]]
    if x == 0.0 and z == 0.0:
        return x, z
    for m in range(find_neighbours(places, order, n, WAY_RANGE, near)):
        other = persons[near[m]]
        dx, dz = other.at[0] - person.at[0], other.at[1] - person.at[1]
        distance = max(math.hypot(dx, dz), 1e-9)
        dx, dz = dx / distance, dz / distance
        room = distance - 0.5 * LEAST_SPACE * (person.height + other.height)
        leaves = other.velocity[0] * dx + other.velocity[1] * dz
        most = max(max(room, 0.0) / CLOSING_TIME + min(leaves, 0.0), 0.0)
        excess = x * dx + z * dz - most
        if excess > 0.0:
            x, z = x - excess * dx, z - excess * dz
    return x, z


@compiled
def _way_back(persons: Records, order: Numbers, n: int) -> tuple[float, float]:
    """Return the velocity at which a person goes back to its post, or end that [m/s]."""
    person = persons[order[n]]
    x, z = person.post[0] - person.at[0], person.post[1] - person.at[1]
    left = math.hypot(x, z)
    person.gave_way = AT_POST < left < FAR_FROM_POST
    if not person.gave_way:
        return 0.0, 0.0
    for k in range(len(order)):
        other = persons[order[k]]
        room = 0.5 * PERSONAL_SPACE * (person.height + other.height)
        off = math.hypot(person.post[0] - other.at[0], person.post[1] - other.at[1])
        if k != n and off < room:
            return 0.0, 0.0
    return RETURN_SPEED * x / left, RETURN_SPEED * z / left
