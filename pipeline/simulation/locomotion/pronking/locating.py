"""Locating: when within a sub-step something happens."""

from __future__ import annotations

import math
from collections.abc import Callable

EXACT = 1e-13
"""Time within which an event is located [s]."""

MOST = 60


def crossing(gap: Callable[[float], float], left: float, right: float) -> float:
    """Return the time at which `gap` has just come to 0 or less, by regula falsi and halving.

    Args:
        gap: of the time; positive at `left`, 0 or less at `right`.
        left: [s].
        right: [s].
    """
    at_left, at_right = gap(left), gap(right)
    for k in range(MOST):
        if right - left <= EXACT or at_right == 0.0:
            break
        middle = 0.5 * (left + right)
        # Every third time in the middle: a jump of the gap would hold one end for ever.
        if k % 3 != 2 and at_left < math.inf and at_right > -math.inf:
            between = left + (right - left) * at_left / (at_left - at_right)
            middle = between if left < between < right else middle
        value = gap(middle)
        if value > 0.0:
            left, at_left = middle, value
        else:
            right, at_right = middle, value
    return right
