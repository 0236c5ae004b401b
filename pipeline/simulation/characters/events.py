"""Events: what touched in a step, in compiled code; more than there is room for is forgotten."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.simulation.characters.layout import Numbers, Structures
from pipeline.simulation.dynamics.compiled import Records, compiled
from pipeline.simulation.dynamics.records import zeros
from pipeline.simulation.dynamics.vectors import Vector

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
        pause: how long two links have to be apart for a new touch [s].
        above: speed of approach of a touch that is told [m/s].
    """

    events: Structures
    count: Numbers
    pause: float
    above: float


def new_log() -> Log:
    """Return an empty log."""
    return Log(zeros(ROOM, EVENT), np.zeros(1, dtype=np.int64), PAUSE, ABOVE)


@compiled
def note(
    log: Log,
    moment: float,
    link: int,
    other: int,
    place: Vector,
    normal: Vector,
    speed: float,
    energy: float,
) -> None:
    """Keep a touch."""
    n = log.count[0]
    if n == len(log.events):
        return
    event = _at(log.events, n)
    event.moment, event.link, event.other = moment, link, other
    event.speed, event.energy = speed, energy
    for k in range(3):
        event.place[k], event.normal[k] = place[k], normal[k]
    log.count[0] = n + 1


@compiled
def _at(records: Records, n: int) -> Records:
    return records[n]
