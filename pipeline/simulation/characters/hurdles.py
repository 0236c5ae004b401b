"""Hurdles: low things in the way of a walker's feet, which it steps over once it has seen them.

Each person minds one hurdle at a time, the nearest: a low solid of another room, or a thing, a doll
or a lying person of this one. It is a rectangle on the ground with a height. A person sees it that
has it in view, near enough, for a while, and does not run. Over one that is seen feet are lifted,
and they land before or behind it; in one that is not seen a foot is caught (`trip`).

Source: Patla and Vickers 1997 (walkers look at an obstacle up to two steps ahead, and not while
they step over it); Patla and Rietdyk 1993 (clearance of the toes).
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID, CharacterArrays, IntArray
from pipeline.simulation.characters.gait_timing import (
    ground_speed,
    leg_length,
    run_blend,
    wrap_angle,
)
from pipeline.simulation.characters.person_record import SITTING
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.dynamics.compiled import (
    Record,
    Records,
    allocating,
    compiled,
    inlined,
)
from pipeline.simulation.dynamics.vectors import Vector, hypotenuse

# What is a hurdle. Lengths in leg lengths.
LEAST_RISE, HIGHEST_HURDLE = 0.035, 0.4  # above the ground; feet clear what is lower
HIGHEST_STEP_OVER, DEEPEST_STEP_OVER = 0.22, 0.45  # that a person steps over; depth on its way
WIDEST_HURDLE = 2.0  # half extents beyond which a thing is a floor
STILL_SPEED = 0.4  # beyond which a thing is no hurdle, but moves out of the way or hits [m/s]
LIFTED = 0.15  # of the lowest point of a thing above the ground, below which it lies there

# How it is noticed.
NOTICE_RANGE = 2.2  # in leg lengths: two steps ahead
NOTICE_TIME = 0.45  # for which it has to be in view [s]
TOO_NEAR = 0.15  # in leg lengths, where a person does not look any more
HALF_VIEW = math.radians(40.0)  # from the gaze, within which it is in view
BEHIND_RANGE = 0.7  # behind the body up to which a hurdle is minded, in leg lengths

FOOT_MARGIN = 0.55  # of the middle of a foot from the edge of a hurdle, in foot lengths
LONGEST_STRIDE = 0.72  # from the other foot, of one that lands behind a hurdle, in leg lengths
RUNNING_STRIDE = 0.6  # by which that of runners is longer
EASE = 0.65  # of the speed, so near a hurdle that a person steps over it
EASING_RANGE = 0.6  # in leg lengths
MIDDLE_OF_FOOT = 0.2  # ahead of the ankle, in foot lengths
OVERHANG = 0.7  # of its rise, by which a foot with only its heel or toes above a hurdle is lower
TOE_CLEARANCE = 0.035  # above a hurdle, in leg lengths


@allocating
def notice_hurdles(arrays: CharacterArrays, persons: Records, solids: Solids, dt: float) -> None:
    """Let all people choose the hurdle that they mind, and look whether they see it.

    Args:
        arrays: all characters.
        persons: `PERSON` records; changed.
        solids: of other rooms.
        dt: time since this was last done [s].
    """
    still = _still_owners(arrays.owners)
    for i in range(len(persons)):
        person = persons[i]
        if person.posture == SITTING or person.frozen or person.kick_foot >= 0:
            person.hurdle, person.hurdle_time, person.hurdle_seen = NOBODY, 0.0, False
            continue
        if not person.stepping and not person.has_goal:
            continue
        last = person.hurdle
        _choose(person, arrays, still, solids)
        if person.hurdle != last:
            person.hurdle_time, person.hurdle_seen = 0.0, False
        if person.hurdle != NOBODY and not person.hurdle_seen:
            _look(person, dt)


@compiled
def _choose(person: Record, arrays: CharacterArrays, still: IntArray, solids: Solids) -> None:
    """Choose the nearest thing that a person comes upon, and describe its rectangle."""
    person.hurdle = NOBODY
    least = _choose_solid(person, solids, NOTICE_RANGE * leg_length(person))
    _choose_owner(person, arrays, still, least)


@compiled
def _choose_solid(person: Record, solids: Solids, least: float) -> float:
    """Choose the nearest solid of another room within a distance, and return how near it is [m]."""
    highest = person.floor + HIGHEST_HURDLE * leg_length(person)
    for n in range(len(solids.bodies)):
        solid = solids.bodies[n]
        if not _may_catch(person, solid) or n == SOLID - person.deck:
            continue
        x, z = 0.5 * (solid.low[0] + solid.high[0]), 0.5 * (solid.low[2] + solid.high[2])
        if _outside(person, x, z, solid.low, solid.high) < least:
            c, s, along, across = _shadow_of_solid(solid)
            gap = _distance(person, (x, z, c, s), along, across)
            if gap < least and not _is_covered(solids, n, highest):
                least = gap
                rise = solid.high[1] - person.floor
                _describe(person, SOLID - n, (x, z, c, s), along, across, rise)
    return least


@compiled
def _may_catch(person: Record, solid: Record) -> bool:
    """Tell whether a solid is low and lies still."""
    if not solid.is_present or not _is_low(person, solid.low[1], solid.high[1]):
        return False
    moves = hypotenuse(solid.v[0], solid.v[2]) > STILL_SPEED
    return not (moves or _is_acted_on(person, SOLID - solid.thing))


@allocating
def _still_owners(owners: Records) -> IntArray:
    """Return the numbers of characters that lie or stand still, and do not act."""
    found, count = np.empty(len(owners), dtype=np.int64), 0
    for n in range(len(owners)):
        if not owners[n].acts and owners[n].speed <= STILL_SPEED:
            found[count] = n
            count += 1
    return found[:count]


@compiled
def _choose_owner(person: Record, arrays: CharacterArrays, still: IntArray, least: float) -> None:
    """Choose the nearest low character, of those still, that is nearer than a distance [m]."""
    for n in still:
        owner = arrays.owners[n]
        if n == person.owner or n == person.deck:
            continue
        if not _is_low(person, owner.low[1], owner.high[1]):
            continue
        if _is_acted_on(person, n) or n == person.partner or _is_held(arrays.nodes, owner):
            continue
        x, z = 0.5 * (owner.low[0] + owner.high[0]), 0.5 * (owner.low[2] + owner.high[2])
        if _outside(person, x, z, owner.low, owner.high) < least:
            middle, along, across = _shadow_of_owner(arrays.nodes, owner)
            gap = _distance(person, middle, along, across)
            if gap < least:
                least = gap
                _describe(person, n, middle, along, across, owner.high[1] - person.floor)


Middle = tuple[float, float, float, float]
"""X and z of the middle of a rectangle on the ground [m], cosine and sine of its long axis, which
goes along x times the cosine and z times the sine."""


@inlined
def _is_low(person: Record, low: float, high: float) -> bool:
    """Tell whether what reaches from one height to another lies low on the ground [m]."""
    leg, rise = leg_length(person), high - person.floor
    is_flat: bool = LEAST_RISE * leg < rise < HIGHEST_HURDLE * leg
    return is_flat and low - person.floor < LIFTED * leg


@inlined
def _is_acted_on(person: Record, thing: int) -> bool:
    """Tell whether what a person does is about a thing."""
    return bool(person.act_things[0] == thing or person.act_things[1] == thing)


@inlined
def _outside(person: Record, x: float, z: float, low: Record, high: Record) -> float:
    """Return the distance of a person from a bounding box on the ground [m]."""
    away_x = max(abs(person.at[0] - x) - 0.5 * (high[0] - low[0]), 0.0)
    away_z = max(abs(person.at[1] - z) - 0.5 * (high[2] - low[2]), 0.0)
    return hypotenuse(away_x, away_z)


@compiled
def _shadow_of_solid(solid: Record) -> tuple[float, float, float, float]:
    """Return the long axis, x and z, of the shadow of a solid's box, and its half extents [m]."""
    if solid.radius > 0.0:
        return 1.0, 0.0, solid.radius, solid.radius
    longest, c, s = 0.0, 1.0, 0.0
    for k in range(3):
        x, z = solid.R[0, k] * solid.half[k], solid.R[2, k] * solid.half[k]
        size = hypotenuse(x, z)
        if size > longest:
            longest, c, s = size, x / size, z / size
    along = across = 0.0
    for k in range(3):
        x, z = solid.R[0, k] * solid.half[k], solid.R[2, k] * solid.half[k]
        along += abs(x * c + z * s)
        across += abs(z * c - x * s)
    return c, s, along, across


@compiled
def _shadow_of_owner(nodes: Records, owner: Record) -> tuple[Middle, float, float]:
    """Return the rectangle along the principal axis of a character, and half extents [m]."""
    first, count = owner.nodes[0], owner.nodes[1]
    x = z = 0.0
    for n in range(first, first + count):
        x, z = x + nodes[n].p[0] / count, z + nodes[n].p[2] / count
    xx = zz = xz = 0.0
    for n in range(first, first + count):
        u, v = nodes[n].p[0] - x, nodes[n].p[2] - z
        xx, zz, xz = xx + u * u, zz + v * v, xz + u * v
    angle = 0.5 * math.atan2(2.0 * xz, xx - zz)
    c, s = math.cos(angle), math.sin(angle)
    low_u = low_v = 1e9
    high_u = high_v = -1e9
    for n in range(first, first + count):
        u, v = nodes[n].p[0] - x, nodes[n].p[2] - z
        radius = nodes[n].radius
        low_u, high_u = min(low_u, u * c + v * s - radius), max(high_u, u * c + v * s + radius)
        low_v, high_v = min(low_v, v * c - u * s - radius), max(high_v, v * c - u * s + radius)
    u, v = 0.5 * (low_u + high_u), 0.5 * (low_v + high_v)
    middle = (x + u * c - v * s, z + u * s + v * c, c, s)
    return middle, 0.5 * (high_u - low_u), 0.5 * (high_v - low_v)


@inlined
def _hurdle_middle(person: Record) -> Middle:
    """Return the middle of the hurdle of a person, and its long axis."""
    x, z, c, s = (
        person.hurdle_middle[0],
        person.hurdle_middle[1],
        person.hurdle_middle[2],
        person.hurdle_middle[3],
    )
    return x, z, c, s


@inlined
def _coordinates(middle: Middle, x: float, z: float) -> tuple[float, float]:
    """Return how far along and across a rectangle a place is from its middle [m]."""
    u, v = x - middle[0], z - middle[1]
    return u * middle[2] + v * middle[3], v * middle[2] - u * middle[3]


@compiled
def _distance(person: Record, middle: Middle, along: float, across: float) -> float:
    """Return the distance to a rectangle that a person comes upon, else a very great one [m]."""
    leg = leg_length(person)
    if along > WIDEST_HURDLE * leg or across > WIDEST_HURDLE * leg:
        return 1e9
    u, v = _coordinates(middle, person.at[0], person.at[1])
    gap = hypotenuse(max(abs(u) - along, 0.0), max(abs(v) - across, 0.0))
    speed = ground_speed(person)
    if gap > 0.0 and speed > 1e-6:
        # How far ahead its nearest place is.
        near_u, near_v = min(max(u, -along), along), min(max(v, -across), across)
        way_u = (person.velocity[0] * middle[2] + person.velocity[1] * middle[3]) / speed
        way_v = (person.velocity[1] * middle[2] - person.velocity[0] * middle[3]) / speed
        if (near_u - u) * way_u + (near_v - v) * way_v < -BEHIND_RANGE * leg:
            return 1e9
    return gap


@compiled
def _is_held(nodes: Records, owner: Record) -> bool:
    """Tell whether a hand holds a character."""
    for n in range(owner.nodes[0], owner.nodes[0] + owner.nodes[1]):
        if nodes[n].grip_partner != NOBODY:
            return True
    return False


@compiled
def _is_covered(solids: Solids, s: int, high: float) -> bool:
    """Tell whether something higher stands on a solid, or right behind it."""
    solid = solids.bodies[s]
    for n in range(len(solids.bodies)):
        other = solids.bodies[n]
        if n == s or not other.is_present or other.high[1] < high or other.low[1] > high + 1.0:
            continue
        overlaps_x = other.low[0] < solid.high[0] and other.high[0] > solid.low[0]
        if overlaps_x and other.low[2] < solid.high[2] and other.high[2] > solid.low[2]:
            return True
    return False


@inlined
def _describe(
    person: Record, thing: int, middle: Middle, along: float, across: float, rise: float
) -> None:
    person.hurdle, person.hurdle_rise = thing, rise
    for k in range(4):
        person.hurdle_middle[k] = middle[k]
    person.hurdle_half[0], person.hurdle_half[1] = along, across


@compiled
def _look(person: Record, dt: float) -> None:
    """Let a person see its hurdle that has it in view for long enough."""
    middle = _hurdle_middle(person)
    u, v = _coordinates(middle, person.at[0], person.at[1])
    near_u = min(max(u, -person.hurdle_half[0]), person.hurdle_half[0]) - u
    near_v = min(max(v, -person.hurdle_half[1]), person.hurdle_half[1]) - v
    x, z = near_u * middle[2] - near_v * middle[3], near_u * middle[3] + near_v * middle[2]
    bearing = abs(wrap_angle(math.atan2(-z, x) - person.gaze[0]))
    # A person that has come up to it looks beyond it.
    is_in_view = bearing < HALF_VIEW and hypotenuse(x, z) > TOO_NEAR * leg_length(person)
    hurries = run_blend(ground_speed(person), leg_length(person)) > 0.5
    if is_in_view and not hurries:
        person.hurdle_time += dt
        person.hurdle_seen = person.hurdle_time > NOTICE_TIME


@compiled
def hurdle_depth(person: Record) -> float:
    """Return the depth of the hurdle along the way of a person [m]."""
    x, z = person.velocity[0], person.velocity[1]
    size = hypotenuse(x, z)
    if size < 1e-6:
        x, z, size = math.cos(person.heading), -math.sin(person.heading), 1.0
    c, s = person.hurdle_middle[2], person.hurdle_middle[3]
    along, across = abs(x * c + z * s) / size, abs(z * c - x * s) / size
    half = min(person.hurdle_half[0] / max(along, 1e-6), person.hurdle_half[1] / max(across, 1e-6))
    return 2.0 * half


@compiled
def is_stepped_over(person: Record) -> bool:
    """Tell whether a person sees its hurdle and can step over it."""
    if person.hurdle == NOBODY or not person.hurdle_seen:
        return False
    leg = leg_length(person)
    if person.hurdle_rise > HIGHEST_STEP_OVER * leg:
        return False
    return bool(hurdle_depth(person) < DEEPEST_STEP_OVER * leg)


@compiled
def hurdle_ease(person: Record) -> float:
    """Return the factor by which stepping over a hurdle slows walking."""
    if not is_stepped_over(person):
        return 1.0
    near = hurdle_gap(person, person.at[0], person.at[1]) < EASING_RANGE * leg_length(person)
    return EASE if near else 1.0


@compiled
def walks_into(person: Record, s: int) -> bool:
    """Tell whether a solid does not stop a person: it steps over it, or does not see it."""
    if person.hurdle != SOLID - s:
        return False
    return not person.hurdle_seen or is_stepped_over(person)


@compiled
def hurdle_gap(person: Record, x: float, z: float) -> float:
    """Return the distance of a place from the hurdle, negative inside [m]."""
    middle = _hurdle_middle(person)
    u, v = _coordinates(middle, x, z)
    u, v = abs(u) - person.hurdle_half[0], abs(v) - person.hurdle_half[1]
    if u > 0.0 and v > 0.0:
        return hypotenuse(u, v)
    return max(u, v)


@compiled
def height_over_hurdle(person: Record, x: float, z: float, heading: float) -> float:
    """Return the height to which an ankle at a place is lifted over the hurdle [m].

    Args:
        person: `PERSON` record.
        x: of the ankle [m].
        z: of the ankle [m].
        heading: of the foot [rad].
    """
    ahead = MIDDLE_OF_FOOT * person.foot
    gap = hurdle_gap(person, x + ahead * math.cos(heading), z - ahead * math.sin(heading))
    margin = FOOT_MARGIN * person.foot
    if gap > margin:
        return -1e9
    # Beyond an edge only heel or toes are above it, and these are raised.
    over = 1.0 - OVERHANG * max(gap, 0.0) / margin
    clearance = TOE_CLEARANCE * leg_length(person)
    height: float = person.floor + over * person.hurdle_rise + person.ankle + clearance
    return height


@compiled
def clear_of_hurdle(
    person: Record, k: int, x: float, z: float, heading: float, other: Vector
) -> tuple[float, float]:
    """Return the foothold nearest to one on a hurdle along the way, before or behind it.

    Args:
        person: `PERSON` record.
        k: the foot; changed is on which side of the hurdle it lands.
        x: of the ankle [m].
        z: of the ankle [m].
        heading: of the foot [rad].
        other: the ankle of the other foot [m].
    """
    offset = MIDDLE_OF_FOOT * person.foot
    cos, sin = math.cos(heading), -math.sin(heading)
    margin = FOOT_MARGIN * person.foot
    middle_x, middle_z = x + offset * cos, z + offset * sin
    way_x, way_z = person.velocity[0], person.velocity[1]
    size = hypotenuse(way_x, way_z)
    if size < 1e-6:
        way_x, way_z, size = cos, sin, 1.0
    way_x, way_z = way_x / size, way_z / size
    if hurdle_gap(person, middle_x, middle_z) > margin:
        # No farther behind it than needed, where the other foot is before it.
        along = (x - other[0]) * way_x + (z - other[2]) * way_z
        running = run_blend(ground_speed(person), leg_length(person))
        longest = LONGEST_STRIDE + RUNNING_STRIDE * running
        too_far = along - longest * leg_length(person)
        is_near = hurdle_gap(person, person.at[0], person.at[1]) < EASING_RANGE * leg_length(person)
        if too_far <= 0.0 or not is_near:
            return x, z
        near_x, near_z = x - too_far * way_x, z - too_far * way_z
        if hurdle_gap(person, near_x + offset * cos, near_z + offset * sin) > margin:
            return near_x, near_z
        x, z, middle_x, middle_z = near_x, near_z, near_x + offset * cos, near_z + offset * sin
        person.hurdle_side[k] = 1
    ahead = _way_out(person, middle_x, middle_z, way_x, way_z, margin)
    back = _way_out(person, middle_x, middle_z, -way_x, -way_z, margin)
    if person.hurdle_side[k] == 0:
        person.hurdle_side[k] = 1 if ahead <= back else -1
    move = ahead if person.hurdle_side[k] == 1 else -back
    return x + move * way_x, z + move * way_z


@compiled
def _way_out(
    person: Record, x: float, z: float, way_x: float, way_z: float, margin: float
) -> float:
    """Return how far a place on the hurdle is from where a way leaves it, and a margin [m]."""
    middle = _hurdle_middle(person)
    u, v = _coordinates(middle, x, z)
    c, s = middle[2], middle[3]
    along, across = way_x * c + way_z * s, way_z * c - way_x * s
    far_u = person.hurdle_half[0] + margin - u * math.copysign(1.0, along)
    far_v = person.hurdle_half[1] + margin - v * math.copysign(1.0, across)
    return max(min(far_u / max(abs(along), 1e-6), far_v / max(abs(across), 1e-6)), 0.0)
