"""Flight: how a body bounces whose feet all leave the ground.

While no foot is down the body is in free fall; while one is, it is thrown back into the
next flight. Heights are in units of g T², T the duration of a cycle, and 0 where the
last foot leaves and the first comes down.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class Bounce:
    """The bounce of a gait with flights.

    Attributes:
        flights: (k, 2) phase of the begin and length of each, in order; at least one.
    """

    flights: Array

    @staticmethod
    def of(gait: Gait) -> Bounce | None:
        """Return the bounce of a gait, None if a foot is always down."""
        flights = gait.flights()
        return Bounce(flights) if len(flights) else None

    def height(self, phase: Array) -> Array:
        """Return the height at `phase` [g T²]; speed is continuous all around the cycle."""
        begins, lengths = self.flights.T
        into = np.mod(np.asarray(phase)[..., None] - begins, 1.0)
        last = into.argmin(axis=-1)
        s, f = into.min(axis=-1), lengths[last]
        following = (last + 1) % len(begins)
        support = np.mod(begins[following] - begins[last] - 1e-12, 1.0) - f
        falling = 0.5 * s * (f - s)
        # A cubic that takes over the speed of the fall and gives that of the next flight.
        t = np.clip((s - f) / support, 0.0, 1.0)
        given = 0.5 * lengths[following]
        thrown = support * t * (1.0 - t) * (-0.5 * f * (1.0 - t) - given * t)
        result: Array = np.where(s < f, falling, thrown)
        return result

    @cached_property
    def amplitude(self) -> float:
        """Half of the whole way up [g T²]."""
        heights = self.height(np.linspace(0.0, 1.0, 1000, endpoint=False))
        return float(0.5 * (heights.max() - heights.min()))

    def beat(self, phase: Array) -> Array:
        """Return the height at `phase` in units of the amplitude."""
        return self.height(phase) / self.amplitude
