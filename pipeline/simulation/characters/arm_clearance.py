"""Arm clearance: in a crowd walkers keep their arms to the body where others pass close by.

The space that walkers leave between them is that of their trunks. Two hands that swing meet at the
sum of the speeds of both walks and of both swings, which is a blow; arms at rest only brush.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.neighbours import Numbers
from pipeline.simulation.characters.walking_group import walks_with
from pipeline.simulation.dynamics.compiled import Record, Records, compiled

LOOK_AHEAD = 0.6  # within which others pass [s]
KEPT, FREE = 0.5, 0.8  # distances at which arms are kept to the body, and swing freely, in heights


@compiled
def keep_arms_in(
    persons: Records, person: Record, nearest: Numbers, count: int, in_crowd: bool
) -> None:
    """Set how far a walker wants to keep its arms to the body, `arms_wanted_in`, 0 to 1.

    Args:
        persons: `PERSON` records.
        person: the walker; written.
        nearest: numbers of the nearest people.
        count: how many there are.
        in_crowd: whether it is in a crowd; elsewhere arms swing freely.
    """
    kept = 0.0
    for k in range(count if in_crowd else 0):
        other = persons[nearest[k]]
        if not walks_with(person, other):
            size = 0.5 * (person.height + other.height)
            near = least_distance(person, other) / size
            kept = max(kept, (FREE - near) / (FREE - KEPT))
    person.arms_wanted_in = min(kept, 1.0)


@compiled
def least_distance(person: Record, other: Record) -> float:
    """Return the least distance of two people within the time they look ahead [m]."""
    x, z = other.at[0] - person.at[0], other.at[1] - person.at[1]
    vx, vz = other.velocity[0] - person.velocity[0], other.velocity[1] - person.velocity[1]
    time = -(x * vx + z * vz) / max(vx * vx + vz * vz, 1e-9)
    time = min(max(time, 0.0), LOOK_AHEAD)
    return math.hypot(x + time * vx, z + time * vz)
