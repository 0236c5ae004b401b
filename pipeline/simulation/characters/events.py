"""Events: what touched in a step, in compiled code; more than there is room for is forgotten."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.layout import Numbers, Structures
from pipeline.simulation.dynamics.compiled import inlined
from pipeline.simulation.dynamics.records import zeros
from pipeline.simulation.dynamics.vectors import Vector, set_triple

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


class Log(NamedTuple):
    """Events of a step.

    Attributes:
        events: (ROOM,) `EVENT`.
        count: (1,) how many there are.
    """

    events: Structures
    count: Numbers


def new_log() -> Log:
    """Return an empty log."""
    return Log(zeros(ROOM, EVENT), np.zeros(1, dtype=np.int64))


@inlined
def note(
    log: Log,
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
    n = log.count[0]
    if n < len(log.events):
        event = log.events[n]
        event.moment, event.link, event.other = moment, pair[0], pair[1]
        event.speed, event.energy = hard[0], hard[1]
        set_triple(event.place, place)
        set_triple(event.normal, normal)
        log.count[0] = n + 1
