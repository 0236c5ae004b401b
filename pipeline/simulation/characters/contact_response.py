"""Contact response: the parts that contacts of links, boxes, solids and the terrain share.

A contact moves its nodes apart by position. What two came nearer in the sub-step is taken out of
the positions alone, and so out of the velocities; the overlap before that is taken out of both
the present and the previous positions, so that nothing is shot off for having begun inside
something. Shares go by mobility, so momentum is kept. Links are rows of balls where they meet
boxes, solids and the terrain.

Source: Horswill 2008, "Collision handling" and "Friction, drag and damping".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import (
    NOBODY,
    RECENT_TOUCHES,
    TERRAIN,
    IntArray,
    RecordArray,
)
from pipeline.simulation.dynamics.compiled import Record, Records, inlined
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.vectors import (
    Vector,
    dot,
    length,
    minus,
    plus,
    set_triple,
    times,
    triple,
)
from pipeline.simulation.spatial import Array

MAX_TOUCHES = 256  # logged in a step; further ones are dropped
TOUCH_PAUSE = 0.08  # time apart after which two links touch anew [s]
MIN_TOUCH_SPEED = 0.15  # of approach of a logged touch [m/s]

PARTING_SPEED = 0.4  # at which old overlap is resolved [m/s]
MIN_BOUNCE_SPEED = 0.25  # of approach [m/s]
RESTING_SPEED = 0.5  # of approach, below which a touch is one of resting on one another [m/s]
BALL_SPACING = 0.08  # along a link, about [m]
TINY = 1e-9

# What lies on the ground keeps this share of its mobility, or of that of what presses it if that
# is less, against moves into the ground at least this steep (cosine).
SUPPORTED_MOBILITY, SUPPORT_COSINE = 0.02, 0.3

TOUCH = np.dtype(
    [
        # Fraction of the step; the link; the other link, TERRAIN or SOLID - k.
        ("moment", "f8"),
        ("link", "i8"),
        ("other", "i8"),
        # In the world, the normal towards the link [m].
        ("place", "f8", 3),
        ("normal", "f8", 3),
        # Speed of approach [m/s], its kinetic energy [J].
        ("speed", "f8"),
        ("energy", "f8"),
    ],
    align=True,
)
"""The onset of a touch."""


class TouchLog(NamedTuple):
    """Touches of a step.

    Attributes:
        events: (MAX_TOUCHES,) `TOUCH`.
        filled: (1,) number of touches.
    """

    events: RecordArray
    filled: IntArray


class SubStep(NamedTuple):
    """The sub-step of a contact.

    Attributes:
        h: its length [s].
        slack: old overlap that may be resolved [m].
        moment: fraction of the step that has gone.
    """

    h: float
    slack: float
    moment: float


def new_touch_log() -> TouchLog:
    """Return an empty log."""
    return TouchLog(zero_records(MAX_TOUCHES, TOUCH), np.zeros(1, dtype=np.int64))


@inlined
def log_touch(
    log: TouchLog,
    moment: float,
    pair: tuple[int, int],
    where: tuple[Vector, Vector],
    speed: float,
    energy: float,
) -> None:
    """Log a touch, of a link and another number, at a place with a normal towards the link."""
    n = log.filled[0]
    if n < len(log.events):
        event = log.events[n]
        event.moment, event.link, event.other = moment, pair[0], pair[1]
        event.speed, event.energy = speed, energy
        set_triple(event.place, where[0])
        set_triple(event.normal, where[1])
        log.filled[0] = n + 1


@inlined
def touch_links(
    links: Records,
    pair: tuple[int, int],
    where: tuple[Vector, Vector],
    speed: float,
    energy: float,
    moment: float,
    log: TouchLog,
) -> None:
    """Let two links of different characters sense one another, and log the onset."""
    a, b = links[pair[0]], links[pair[1]]
    if is_new_touch(a, b.owner) and speed > MIN_TOUCH_SPEED:
        log_touch(log, moment, pair, where, speed, energy)
    sense_touch(a, pair[1], b.owner, energy)
    sense_touch(b, pair[0], a.owner, energy)


@inlined
def is_new_touch(link: Record, other: int) -> bool:
    """Note that a link touches another, and tell whether they were apart for a while before.

    A link that lies between several keeps them apart, or each of their turns would sound anew.

    Args:
        link: a `LINK`.
        other: owner that is touched, or SOLID - its thing.
    """
    oldest = 0
    for k in range(RECENT_TOUCHES):
        if link.recent[k] == other:
            is_new = link.recent_age[k] > TOUCH_PAUSE
            link.recent_age[k] = 0.0
            return is_new
        if link.recent_age[k] > link.recent_age[oldest]:
            oldest = k
    link.recent[oldest] = other
    link.recent_age[oldest] = 0.0
    return True


@inlined
def sense_touch(link: Record, other: int, other_owner: int, energy: float) -> None:
    """Record a touch on a link; the hardest one counts."""
    if link.age[0] > 0.0 or energy > link.energy:
        link.touched, link.touched_owner = other, other_owner
    link.energy = max(link.energy, energy)
    link.age[0] = 0.0


@inlined
def begin_touches(links: Records, dt: float) -> None:
    """Let links feel the blows of the step before, age touches by a step [s], forget ended ones."""
    for n in range(len(links)):
        link = links[n]
        link.energy, link.blow = link.blow, 0.0
        link.age[0] += dt
        link.age[1] += dt
        for k in range(RECENT_TOUCHES):
            link.recent_age[k] += dt
        if link.age[0] > TOUCH_PAUSE and (link.touched != TERRAIN or link.age[1] > TOUCH_PAUSE):
            link.touched, link.touched_owner = NOBODY, NOBODY


@inlined
def ball_count(link: Record, most: int) -> int:
    """Return the number of balls along a link."""
    return min(int(link.length_limits[0] / BALL_SPACING) + 1, most)


@inlined
def place_between(a: Array, b: Array, t: float) -> Vector:
    """Return the place at a fraction t of the way from a to b."""
    return plus(times(1.0 - t, triple(a)), times(t, triple(b)))


@inlined
def move_between(one: Record, other: Record, t: float) -> Vector:
    """Return the motion in this sub-step at a fraction t of the way between two nodes [m]."""
    return plus(
        times(1.0 - t, minus(triple(one.p), triple(one.previous))),
        times(t, minus(triple(other.p), triple(other.previous))),
    )


@inlined
def link_overlaps(nodes: Records, link: Record, radius: float, bounds: Record) -> bool:
    """Tell whether the bounding box of a link overlaps that of a character or a solid."""
    p, q = nodes[link.ends[0]].p, nodes[link.ends[1]].p
    for k in range(3):
        if min(p[k], q[k]) - radius > bounds.high[k] or max(p[k], q[k]) + radius < bounds.low[k]:
            return False
    return True


@inlined
def damp_resting(node: Record, owner: Record, speed: float) -> None:
    """Damp a node that touches gently as on the ground; acting people damp themselves."""
    if speed < RESTING_SPEED and not owner.acts and owner.bounciness == 0.0:
        node.contact_damping = owner.ground_damping


@inlined
def friction_move(slip: Vector, n: Vector, most: float) -> Vector:
    """Return the move by friction against a slip across n, limited to a length [m]."""
    along = minus(slip, times(dot(slip, n), n))
    size = length(along)
    return times(-min(most / size, 1.0), along) if size > TINY else (0.0, 0.0, 0.0)


@inlined
def support_factor(one: Record, other: Record, up: float, own: float, against: float) -> float:
    """Return the fraction of its mobility that a pushed link keeps where the ground bears it.

    Otherwise something heavy would press it in, and it would bear nothing however light it is.

    Args:
        one: first node of the link.
        other: its last node.
        up: vertical component of the unit move.
        own: mobility of the link [1/kg].
        against: mobility of what pushes, 0 of what nothing moves [1/kg].
    """
    if up >= -SUPPORT_COSINE or one.ground_damping + other.ground_damping == 0.0:
        return 1.0
    return SUPPORTED_MOBILITY * against / own if 0.0 < against < own else SUPPORTED_MOBILITY


@inlined
def move_node(node: Record, share: float, move: Vector, part: Vector, back: Vector) -> None:
    """Move a node by its share of a contact.

    Args:
        node: changed.
        share: its part of the moves.
        move: changes position and velocity [m].
        part: changes the position alone [m].
        back: changes the velocity alone [m].
    """
    for k in range(3):
        node.p[k] += share * (move[k] + part[k])
        node.previous[k] += share * (part[k] - back[k])
