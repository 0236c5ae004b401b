"""Scene course: how tense and how lively a scene is from moment to moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class SceneCourse:
    """Tension and liveliness of a scene at even times.

    Attributes:
        step: time between values [s].
        tension: from 0 (calm) to 1; empty if unknown.
        motion: from 0 (still) to 1; empty if unknown.
    """

    step: float = 0.25
    tension: tuple[float, ...] = ()
    motion: tuple[float, ...] = ()

    def between(self, start: float, end: float) -> tuple[float, float]:
        """Return the mean tension and motion between two times [s]."""
        return self._mean(self.tension, start, end), self._mean(self.motion, start, end)

    def _mean(self, values: tuple[float, ...], start: float, end: float) -> float:
        if not values:
            return _UNKNOWN
        first = min(max(int(start / self.step), 0), len(values) - 1)
        last = min(max(int(np.ceil(end / self.step)), first + 1), len(values))
        return float(np.mean(values[first:last]))


_UNKNOWN = 0.3

UNKNOWN_COURSE = SceneCourse()
"""Course of a score without a take."""
