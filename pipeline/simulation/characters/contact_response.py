"""Contact response."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY, TERRAIN, IntArray, RecordArray
from pipeline.simulation.dynamics.body_record import zero_records
from pipeline.simulation.dynamics.compiled import Record, Records, inlined
from pipeline.simulation.dynamics.vectors import Vector, dot, length, minus, set_triple, times

ROOM = 256
"""Events of a step."""

PAUSE = 0.08
"""How long two links have to be apart for a new touch [s]."""

ABOVE = 0.15
"""Speed of approach of a touch that is told [m/s]."""

EVENT = np.dtype(
    [
        ("moment", "f8"),
        ("link", "i8"),
        ("other", "i8"),
        ("place", "f8", 3),
        ("normal", "f8", 3),
        ("speed", "f8"),
        ("energy", "f8"),
    ],
    align=True,
)
"""A touch that begins: when, as a part of the step; who, and what; the normal points to who."""


class TouchLog(NamedTuple):
    """Events of a step.

    Attributes:
        events: (ROOM,) `EVENT`.
        filled: (1,) how many there are.
    """

    events: RecordArray
    filled: IntArray


def new_touch_log() -> TouchLog:
    """Return an empty log."""
    return TouchLog(zero_records(ROOM, EVENT), np.zeros(1, dtype=np.int64))


@inlined
def log_touch(
    log: TouchLog,
    moment: float,
    pair: tuple[int, int],
    place: Vector,
    normal: Vector,
    hard: tuple[float, float],
) -> None:
    """Keep a touch of two links.

    Args:
        log: what is kept.
        moment: when, as a part of the step.
        pair: who, and what.
        place: where [m].
        normal: towards who.
        hard: speed of approach [m/s] and energy [J].
    """
    n = log.filled[0]
    if n < len(log.events):
        event = log.events[n]
        event.moment, event.link, event.other = moment, pair[0], pair[1]
        event.speed, event.energy = hard[0], hard[1]
        set_triple(event.place, place)
        set_triple(event.normal, normal)
        log.filled[0] = n + 1


PARTING = 0.4
"""Speed at which what was in one another parts [m/s]."""

LEAST_BOUNCE = 0.25
"""Speed of approach below which nothing bounces [m/s]."""

BORNE, STEEP = 0.02, 0.3
"""Part of its lightness, or of that of what presses, if that is less, which is left of what is
pressed on the ground, and the cosine of the least angle to the level at which it is."""

GENTLE = 0.5
"""Speed of approach below which a touch is one of those that rest on one another [m/s]."""

TINY = 1e-9


@inlined
def rub(node: Record, owner: Record, speed: float) -> None:
    """Let a node that touches gently be damped as on the ground; who acts damps itself."""
    if speed < GENTLE and not owner.acts and owner.bounciness == 0.0:
        node.contact_damping = owner.ground_damping


@inlined
def rubbed(slip: Vector, n: Vector, most: float) -> Vector:
    """Return what friction takes of a slip across n, so much at most."""
    along = minus(slip, times(dot(slip, n), n))
    size = length(along)
    return times(-min(most / size, 1.0), along) if size > TINY else (0.0, 0.0, 0.0)


@inlined
def borne(one: Record, other: Record, up: float, own: float, against: float) -> float:
    """Return how much is left of the lightness of what is pushed by a move so far up.

    What lies on the ground is borne by it: something heavy would press it in, and it bear
    nothing, however light it is.

    Args:
        one: the node at the begin of what is pushed.
        other: the node at its end.
        up: how far up the move goes, of its length.
        own: inverse mass of what is pushed [1/kg].
        against: that of what pushes, 0 of what nothing moves [1/kg].
    """
    if up >= -STEEP or one.ground_damping + other.ground_damping == 0.0:
        return 1.0
    return BORNE * against / own if 0.0 < against < own else BORNE


@inlined
def sense(link: Record, other: int, whose: int, energy: float) -> None:
    """Let a link know of a touch; the hardest one counts."""
    if link.age[0] > 0.0 or energy > link.energy:
        link.touched, link.touched_owner = other, whose
    link.energy = max(link.energy, energy)
    link.age[0] = 0.0


@inlined
def grow_old(links: Records, h: float) -> None:
    """Forget touches that have ended, a sub-step later."""
    for n in range(len(links)):
        link = links[n]
        link.age[0] += h
        link.age[1] += h
        if link.age[0] > PAUSE and (link.touched != TERRAIN or link.age[1] > PAUSE):
            link.touched, link.touched_owner = NOBODY, NOBODY


@inlined
def move_node(node: Record, share: float, move: Vector, part: Vector, back: Vector) -> None:
    """Move a node by its share of what changes position and velocity, position, velocity."""
    for k in range(3):
        node.p[k] += share * (move[k] + part[k])
        node.previous[k] += share * (part[k] - back[k])
