"""Joint room: what joints may do about where they rest, without a corner at their limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.curves import bounded
from pipeline.simulation.spatial import Array

LEAST = 1e-6
"""Room of a joint that rests on its limit [rad or m]."""


@dataclass(frozen=True, eq=False)
class JointRoom:
    """Joints between their limits.

    Attributes:
        lower, preferred, upper: (...) [rad or m].
    """

    lower: Array
    preferred: Array
    upper: Array

    def at(self, wish: Array) -> Array:
        """Return joint values for wishes (..., relative to rest) of any size.

        Small wishes are met; a limit is come to ever more slowly and is never reached.
        """
        room = self._towards(wish)
        result: Array = self.preferred + room * bounded(wish / room)
        return result

    def slope(self, wish: Array) -> Array:
        """Return how much joint values change with their wishes, 0 to 1."""
        x = wish / self._towards(wish)
        result: Array = (1.0 + (x * x) * (x * x)) ** -1.25
        return result

    def _towards(self, wish: Array) -> Array:
        rooms = np.where(wish < 0.0, self.preferred - self.lower, self.upper - self.preferred)
        return np.maximum(rooms, LEAST)
