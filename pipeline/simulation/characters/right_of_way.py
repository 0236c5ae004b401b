"""Right of way: of two walkers whose ways cross, the one nearer to the crossing goes first.

It hardly gives way and holds to the velocity that it wants; the other makes most of the way. Where
both gave way alike, two dense groups that cross would stand before one another for good.

Source: Olivier, Marin, Crétual, Berthoz and Pettré 2013: the one that passes second does more.
"""

from __future__ import annotations

import math

from pipeline.simulation.dynamics.compiled import Record, compiled, inlined

HELD_UP = 0.9  # impatience of two who hold one another up
LEAST_SINE, SURE_SINE = 0.3, 0.6  # of the angle of two ways that cross; that certainly do
LEAD = 1.0  # that is certain: difference of the distances to the crossing [m]
WAITED_LEAD = 0.1  # the same for two that have waited for one another [m]
PATIENCE = 0.4  # of a walker before it squeezes through
MOST_SHARED = 0.4  # of the way to be made, beyond the half, that is left to the second


@compiled
def lag_at_crossing(one: Record, other: Record) -> float:
    """Return how certainly a walker is the second at the crossing of its way and another's.

    From -1, where it goes first, to 1; 0 where their ways do not cross.
    """
    ax, az = one.goal[0] - one.at[0], one.goal[1] - one.at[1]
    bx, bz = other.goal[0] - other.at[0], other.goal[1] - other.at[1]
    size = math.hypot(ax, az) * math.hypot(bx, bz)
    cross = ax * bz - az * bx
    sine = cross / max(size, 1e-9)
    if abs(sine) < LEAST_SINE:
        return 0.0
    x, z = other.at[0] - one.at[0], other.at[1] - one.at[1]
    own_left = (x * bz - z * bx) / cross * math.hypot(ax, az)
    other_left = (x * az - z * ax) / cross * math.hypot(bx, bz)
    certainty = min((abs(sine) - LEAST_SINE) / (SURE_SINE - LEAST_SINE), 1.0)
    # The longer both wait, the less of a lead decides.
    waited = 1.0 + min(one.impatience, other.impatience) / PATIENCE
    lead = LEAD + min(max(waited, 0.0), 1.0) * (WAITED_LEAD - LEAD)
    return certainty * min(max((own_left - other_left) / lead, -1.0), 1.0)


@compiled
def lag_at_passage(one: Record, other: Record) -> float:
    """Return how certainly a walker is to wait for another between the walls that both pass.

    From -1, where it goes first, to 1; 0 away from walls, and where both are as near to them.
    Those who come out go first, and of those who go in the one that is nearer. Of two that hold
    one another up that is certain, or both would press on for good.
    """
    if not (one.has_passage and other.has_passage):
        return 0.0
    lead = one.passage - other.passage
    if lead != 0.0 and hold_up_one_another(one, other):
        return math.copysign(1.0, lead)
    return min(max(lead / LEAD, -1.0), 1.0)


@inlined
def hold_up_one_another(one: Record, other: Record) -> bool:
    """Tell whether two walkers come from opposite sides, and neither gets on."""
    if one.impatience < HELD_UP or other.impatience < HELD_UP:
        return False
    ax, az = one.goal[0] - one.at[0], one.goal[1] - one.at[1]
    bx, bz = other.goal[0] - other.at[0], other.goal[1] - other.at[1]
    return bool(ax * bx + az * bz <= 0.0)


@compiled
def lag_of_held_up(one: Record, other: Record) -> float:
    """Return -1 for the first and 1 for the second of two who stand before one another, else 0.

    They come from opposite sides, and neither gets on; the one with the shorter way goes first.
    """
    if not hold_up_one_another(one, other):
        return 0.0
    left = math.hypot(one.goal[0] - one.at[0], one.goal[1] - one.at[1])
    others_left = math.hypot(other.goal[0] - other.at[0], other.goal[1] - other.at[1])
    return 0.0 if left == others_left else math.copysign(1.0, left - others_left)
