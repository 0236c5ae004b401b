"""Patience: when a hand that is held up is taken back, and whence it reaches anew.

A field pulls along a straight line. An arm may be wound up on it, a joint at its limit or the
forearm against the trunk, where another way of holding the elbow would do. Who is held up so
takes the arm back and reaches for the place from elsewhere, instead of pulling on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.dancers.force_fields import Point

OFF = 0.012
"""How far from its point a hand may stay for good [m]."""

STAYS, WAIT = 0.01, 0.25
"""A hand that has moved less than this [m] in such a time [s] is held up."""

_DEGREES = ((-30.0, 20.0, 20.0, 40.0), (150.0, 30.0, 0.0, 60.0), (20.0, 80.0, 0.0, 60.0))

RETREAT_POSTURES: tuple[list[float] | None, ...] = (
    None,
    *(np.radians(angles).tolist() for angles in _DEGREES),
)
"""Angles of shoulder and elbow that an arm is taken back to, one after another: as it is held
anyway, then low behind the body, high above it, and aside [rad]."""

NOWHERE: Point = (math.inf, math.inf, math.inf)


class StallDetector:
    """The patience of one hand on its way to one place.

    Args:
        tries: how often it is taken back at most.
    """

    def __init__(self, tries: int = len(RETREAT_POSTURES)) -> None:
        self._left = tries
        self._place, self._since = NOWHERE, 0.0

    def is_lost(self, hand: Point, point: Point, now: float) -> bool:
        """Tell whether the hand is held up: off its point, which rests, and not moving."""
        if not self._left or math.dist(hand, point) < OFF:
            return False
        if math.dist(hand, self._place) > STAYS:
            self._place, self._since = hand, now
        return now >= self._since + WAIT

    def withdraws_to(self, held: Sequence[float]) -> list[float]:
        """Return the angles (4,) to take the arm back to, which is `held` near others [rad]."""
        posture = RETREAT_POSTURES[len(RETREAT_POSTURES) - self._left]
        self._left -= 1
        self._place = NOWHERE
        return list(held if posture is None else posture)
