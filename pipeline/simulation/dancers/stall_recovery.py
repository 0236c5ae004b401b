"""Stall recovery: a hand that stops short of its target retreats and approaches anew.

A force field pulls along a straight line. The arm may stall on it, with a joint at its limit or the
forearm against the trunk, where another elbow posture would reach. A stalled hand retreats to
another posture and starts again from there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.dancers.force_fields import Point

TARGET_TOLERANCE = 0.012
"""Distance to the target within which a hand has arrived [m]."""

STALL_DISTANCE, STALL_TIME = 0.01, 0.25
"""A hand that moves less than this [m] in this time [s] has stalled."""

RETREAT_POSTURES: tuple[list[float] | None, ...] = (
    None,
    np.radians([-30.0, 20.0, 20.0, 40.0]).tolist(),
    np.radians([150.0, 30.0, 0.0, 60.0]).tolist(),
    np.radians([20.0, 80.0, 0.0, 60.0]).tolist(),
)
"""Angles of shoulder and elbow to retreat to, in turn: the preferred posture, low behind the body,
high above it, and to the side [rad]."""

UNKNOWN: Point = (math.inf, math.inf, math.inf)


class StallDetector:
    """Detects the stalls of one hand on its way to one target.

    Args:
        retreats: largest number of retreats.
    """

    def __init__(self, retreats: int = len(RETREAT_POSTURES)) -> None:
        self._left = retreats
        self._place, self._since = UNKNOWN, 0.0

    def is_stalled(self, hand: Point, point: Point, now: float) -> bool:
        """Returns whether the hand rests away from its target point, which rests too."""
        if not self._left or math.dist(hand, point) < TARGET_TOLERANCE:
            return False
        if math.dist(hand, self._place) > STALL_DISTANCE:
            self._place, self._since = hand, now
        return now >= self._since + STALL_TIME

    def next_retreat(self, preferred: Sequence[float]) -> list[float]:
        """Returns the angles (4,) of the next retreat [rad].

        Args:
            preferred: angles that the arm is held near to [rad].
        """
        posture = RETREAT_POSTURES[len(RETREAT_POSTURES) - self._left]
        self._left -= 1
        self._place = UNKNOWN
        return list(preferred if posture is None else posture)
