"""Seat perch: how far back on a high seat people sit whose feet stay on the ground.

Legs that reach the ground only from the edge of a seat keep the pelvis there. The heels of short
legs rise, so that they stand on their toes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pipeline.simulation.characters.person_tasks import SEAT_HEIGHT
from pipeline.simulation.dynamics.compiled import Record

LEG_STRETCH = 0.99  # of a leg before a seat, in the sum of its links
HEEL_RISES = tuple(math.radians(angle) for angle in range(0, 51, 5))
"""Angles of feet on their toes that are tried, the flat foot first."""


class Perch(NamedTuple):
    """How a person sits.

    Attributes:
        back: distance of the pelvis behind the feet [m].
        heel_rise: angle of the feet, heels up [rad].
    """

    back: float
    heel_rise: float


def perch_on(person: Record, top: float, back: float) -> Perch:
    """Return how a person sits as far back as its legs let it, with the least rise of its heels.

    Args:
        person: `PERSON` record.
        top: height of the seat [m].
        back: distance behind its feet at which it would sit at ease [m].
    """
    best = Perch(0.0, 0.0)
    for angle in HEEL_RISES:
        reach = _reach_back(person, top, angle)
        if reach >= back:
            return Perch(back, angle)
        if reach > best.back:
            best = Perch(reach, angle)
    return best


def _reach_back(person: Record, top: float, angle: float) -> float:
    """Return how far behind its feet a pelvis on a seat can be with heels at an angle [m]."""
    ball, ankle = float(person.ball), float(person.ankle)
    c, s = math.cos(angle), math.sin(angle)
    # The foot turns about its ball, which takes the ankle up and ahead.
    rise, ahead = ball * s + ankle * (c - 1.0), ball * (1.0 - c) + ankle * s
    legs = LEG_STRETCH * (float(person.thigh) + float(person.shin))
    height = top + SEAT_HEIGHT * float(person.height) - float(person.floor) - ankle - rise
    return math.sqrt(max(legs * legs - height * height, 0.0)) - ahead
