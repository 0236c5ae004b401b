"""Headway: how fast walkers may go behind others, and past them.

Who comes too near behind another treads on its heels, and a leg that swings past another closely
and fast strikes it. In the lane of an opening walkers close up, in files that keep apart; of two
that come together before it, the one that is nearer goes on.

Source: Seyfried, Steffen, Klingsch, Boltes, The fundamental diagram of pedestrian movement
revisited, 2005: the time to the one ahead.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.arm_clearance import least_distance
from pipeline.simulation.characters.neighbours import Numbers
from pipeline.simulation.characters.passage_lanes import goes_before, share_lane
from pipeline.simulation.characters.walking_group import walks_with
from pipeline.simulation.dynamics.compiled import Record, Records, compiled

HEADWAY_TIME = 1.06  # to the one ahead [s]
BODY_DEPTH, LANE = 0.21, 0.25  # distance of those who stand; half width of a lane, in heights

# Of those in one lane of an opening: time to the one ahead [s], half width of a file, in heights.
FILE_HEADWAY_TIME, FILE = 0.68, 0.27

LANE_EDGE, FILE_EDGE = 2, 8  # powers of the distance aside, by which those there hinder less
SLOWEST = 0.15  # behind others [m/s]
SAME_WAY = 0.5  # part of its speed at which others go ahead of a walker outside a crowd

# Of walkers that pass one another: distances, in heights, and relative speeds [m/s].
CLOSE, FREE_PASSING = 0.3, 0.42
SLOW_PASSING, FAST_PASSING = 0.5, 2.5


@compiled
def headway_share(
    persons: Records,
    person: Record,
    nearest: Numbers,
    count: int,
    x: float,
    z: float,
    in_crowd: bool = True,
) -> float:
    """Return the share of a velocity at which a walker treads on nobody's heels.

    Outside a crowd it overtakes those who stand or come towards it.
    """
    speed = math.hypot(x, z)
    if speed < 1e-9:
        return 1.0
    limit = speed
    for k in range(count):
        other = persons[nearest[k]]
        if not in_crowd:
            along = (other.velocity[0] * x + other.velocity[1] * z) / speed
            if along < SAME_WAY * speed or walks_with(person, other):
                continue
        dx, dz = other.at[0] - person.at[0], other.at[1] - person.at[1]
        size = 0.5 * (person.height + other.height)
        ahead, aside = (dx * x + dz * z) / speed, abs(dz * x - dx * z) / speed
        time, width, edge = HEADWAY_TIME, LANE * size, LANE_EDGE
        if in_crowd and share_lane(person, other):
            if goes_before(person, other):
                continue
            time, width, edge = FILE_HEADWAY_TIME, FILE * size, FILE_EDGE
        if ahead > 0.0 and aside < width:
            room = max(ahead - BODY_DEPTH * size, 0.0) / time
            limit = min(limit, max(room, SLOWEST) / max(1.0 - (aside / width) ** edge, 1e-3))
    return limit / speed


@compiled
def passing_share(persons: Records, person: Record, nearest: Numbers, count: int) -> float:
    """Return the share of its speed at which a walker passes others without a blow."""
    share = 1.0
    for k in range(count):
        other = persons[nearest[k]]
        vx, vz = other.velocity[0] - person.velocity[0], other.velocity[1] - person.velocity[1]
        size, speed = 0.5 * (person.height + other.height), math.hypot(vx, vz)
        part = (least_distance(person, other) / size - CLOSE) / (FREE_PASSING - CLOSE)
        if speed > SLOW_PASSING and part < 1.0:
            most = SLOW_PASSING + max(part, 0.0) * FAST_PASSING
            share = min(share, most / speed)
    return share
