"""Swing: the ways of feet in the air, relative to the body.

Three points a foot: where it left the ground, a middle one higher than both, so that the leg
folds while the body rises, and where it is stretched forward for the landing.

Source: Sims 1987, 11.1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array

MIDDLE = 0.46
"""When feet are at the middle point, as a part of the flight."""


@dataclass(frozen=True, eq=False)
class Swing:
    """The ways of n feet.

    Attributes:
        begin: (n,) [s].
        time: (n,) how long they take [s].
        start, middle, end: (n, 3) in the frame of the body [m].
        trail: (n, 3) speed with which they begin [m/s].
    """

    begin: Array
    time: Array
    start: Array
    middle: Array
    end: Array
    trail: Array

    @staticmethod
    def still(feet: Array) -> Swing:
        """Return feet (n, 3) that do not move."""
        n, zero = len(feet), np.zeros_like(feet)
        return Swing(np.zeros(n), np.ones(n), feet, feet, feet, zero)

    def tips(self, time: float) -> Array:
        """Return the feet (n, 3) in the frame of the body [m]."""
        s = np.minimum(np.maximum((time - self.begin) / self.time, 0.0), 1.0)[:, None]
        late = s > MIDDLE
        span = np.where(late, 1.0 - MIDDLE, MIDDLE)
        u = np.where(late, s - MIDDLE, s) / span
        a, b = np.where(late, self.middle, self.start), np.where(late, self.end, self.middle)
        through = self.end - self.start
        through[:, 1] = 0.0
        reach = self.time[:, None] * span
        m_a = np.where(late, span * through, reach * self.trail)
        m_b = np.where(late, 0.0, span * through)
        return _hermite(u, a, b, m_a, m_b)

    def again(self, which: NDArray[np.bool_], time: float, start: Array, takes: float) -> Swing:
        """Return the ways where some feet begin another one, straight to their ends."""
        one = which[:, None]
        middle = 0.5 * (start + self.end)
        return replace(
            self,
            begin=np.where(which, time, self.begin),
            time=np.where(which, takes, self.time),
            start=np.where(one, start, self.start),
            middle=np.where(one, middle, self.middle),
            trail=np.where(one, 0.0, self.trail),
        )


def _hermite(u: Array, a: Array, b: Array, m_a: Array, m_b: Array) -> Array:
    """Return the cubic from a to b whose slopes there are m_a and m_b."""
    v = 1.0 - u
    result: Array = v * v * ((1.0 + 2.0 * u) * a + u * m_a) + u * u * (
        (1.0 + 2.0 * v) * b - v * m_b
    )
    return result
