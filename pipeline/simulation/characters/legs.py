"""Legs: knees between hips and feet, bent forward."""

from __future__ import annotations

import math

from pipeline.simulation.characters.arms import bent, within
from pipeline.simulation.characters.gait import wrapped
from pipeline.simulation.characters.record import FOOT, HIP, KNEE, SWING
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.vectors import cross, minus, plus, put, row, times

STRETCHED = 0.995
"""How long a leg is at most that swings, in the sum of its links."""

OUTWARD = 0.06
"""How far knees go outward as they bend, as a tangent; more for one who sits."""


@compiled
def hold_legs(person: Record) -> None:
    """Say where knees and feet should be."""
    for k in range(2):
        hip, ankle = row(person.wanted, HIP + k), row(person.ankles, k)
        if person.doing[k] == SWING:
            longest = STRETCHED * (person.thigh + person.shin)
            ankle = within(hip, ankle, 0.0, longest)
            put(person.ankles, k, ankle)
        toes = person.heading + 0.6 * wrapped(person.yaw[k] - person.heading)
        right = (math.sin(toes), 0.0, math.cos(toes))
        # Ahead of a leg that hangs, above one that lies ahead: nowhere do the two fall together.
        pole = cross(right, minus(ankle, hip))
        side = 1.0 if k == 1 else -1.0
        size = person.thigh + person.shin
        out = side * (OUTWARD + 0.25 * person.seated + 0.6 * person.crouch) * size
        knee = bent(hip, ankle, person.thigh, person.shin, plus(pole, times(out, right)))
        put(person.wanted, KNEE + k, knee)
        put(person.wanted, FOOT + k, ankle)
