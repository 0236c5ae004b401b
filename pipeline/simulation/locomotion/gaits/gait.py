"""Gaits: when each foot goes up and comes down within the cycle, and when all feet are in the air.

Phases run from 0 to 1. A foot swings from its foot-up to its foot-down phase and stands from there
to its next foot-up.

Source: Sims 1987, 9.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.spec.walk import GaitPhases

# Difference between phases that count as one, as a fraction of the cycle.
PHASE_TOLERANCE = 1e-6

# Duty factors between which a walk goes over into a run.
WALKING_DUTY, RUNNING_DUTY = 0.52, 0.45


def share_of_run(duty: float) -> float:
    """Return how far a duty factor is that of a run, 0 to 1."""
    part = (WALKING_DUTY - duty) / (WALKING_DUTY - RUNNING_DUTY)
    return min(max(part, 0.0), 1.0)


@dataclass(frozen=True, eq=False)
class Gait:
    """A gait for n legs.

    Attributes:
        up: (n,) foot-up phases, 0 to 1.
        down: (n,) foot-down phases, 0 to 1.
    """

    up: Array
    down: Array

    @staticmethod
    def of(down: Array, duty: Array | float) -> Gait:
        """Return the gait of feet that come down at `down` and stand for `duty` of the cycle."""
        return Gait(np.mod(down + duty, 1.0), np.mod(down, 1.0))

    @property
    def swing(self) -> Array:
        """(n,) fractions of the cycle that the feet are in the air."""
        return np.mod(self.down - self.up, 1.0)

    @property
    def duty(self) -> Array:
        """(n,) duty factors: fractions of the cycle that the feet are down."""
        return 1.0 - self.swing

    @property
    def beats(self) -> int:
        """Number of different foot-down phases."""
        return len(np.unique(np.round(self.down, 6)))

    def with_duty(self, duty: float) -> Gait:
        """Return the gait with another duty factor, the middle of each swing kept."""
        middle = self.up + 0.5 * self.swing
        half = 0.5 * (1.0 - duty)
        return Gait(np.mod(middle - half, 1.0), np.mod(middle + half, 1.0))

    def among(self, carrying: NDArray[np.bool_]) -> Gait:
        """Return this gait for a figure whose `carrying` legs (m,) walk.

        Legs that are held up have no phases of their own and get those of the first leg.
        """
        place = np.where(carrying, np.cumsum(carrying) - 1, 0)
        return Gait(self.up[place], self.down[place])

    def standing(self, phase: Array) -> NDArray[np.bool_]:
        """Return which feet (..., n) are down at `phase` (...)."""
        into = np.mod(np.asarray(phase)[..., None] - self.up, 1.0)
        return into >= self.swing

    def flights(self) -> Array:
        """Return start phase and length in cycles (k, 2) of the times when all feet are up."""
        if not len(self.up):
            return np.zeros((0, 2))
        moments = np.unique(np.concatenate([self.up, self.down]))
        spans = np.diff(moments, append=moments[0] + 1.0)
        # Between two moments nothing goes up or comes down: one test per span is enough.
        free = ~self.standing(moments + 0.5 * spans).any(axis=-1) & (spans > PHASE_TOLERANCE)
        return np.stack([moments[free], spans[free]], axis=-1)

    def next_up(self, phase: float) -> Array:
        """Return the phases (n,), whole cycles counted, of the next foot-up of every leg."""
        return phase + np.mod(self.up - phase, 1.0)

    def down_after(self, up: Array) -> Array:
        """Return the phases (n,) at which feet come down that went up at `up` (n,)."""
        return up + self.swing


def gait_from_config(config: GaitPhases, names: Sequence[str]) -> Gait:
    """Return the gait that the author wrote out for the legs called `names`."""
    return Gait(
        np.array([config.up[name] for name in names]) % 1.0,
        np.array([config.down[name] for name in names]) % 1.0,
    )


@dataclass(frozen=True, eq=False)
class FlightBounce:
    """The bounce of a body whose gait has flights.

    While no foot is down the body falls freely; while one is, it is thrown into the next flight.
    Heights are in units of g T², T the duration of a cycle, and 0 at lift-off and touchdown.

    Attributes:
        flights: (k, 2) start phase and length of each, in order; at least one.
    """

    flights: Array

    @staticmethod
    def of(gait: Gait) -> FlightBounce | None:
        """Return the bounce of a gait, None if a foot is always down."""
        flights = gait.flights()
        return FlightBounce(flights) if len(flights) else None

    def height(self, phase: Array) -> Array:
        """Return the height at `phase` [g T²]; its rate is continuous around the cycle."""
        starts, lengths = self.flights.T
        into = np.mod(np.asarray(phase)[..., None] - starts, 1.0)
        last = into.argmin(axis=-1)
        s, f = into.min(axis=-1), lengths[last]
        following = (last + 1) % len(starts)
        support = np.mod(starts[following] - starts[last] - 1e-12, 1.0) - f
        falling = 0.5 * s * (f - s)
        # A cubic that takes over the rate of the fall and gives that of the next flight.
        t = np.clip((s - f) / support, 0.0, 1.0)
        given = 0.5 * lengths[following]
        thrown = support * t * (1.0 - t) * (-0.5 * f * (1.0 - t) - given * t)
        return np.where(s < f, falling, thrown)

    @cached_property
    def amplitude(self) -> float:
        """Half of the total rise [g T²]."""
        heights = self.height(np.linspace(0.0, 1.0, 1000, endpoint=False))
        return float(0.5 * (heights.max() - heights.min()))

    def beat(self, phase: Array) -> Array:
        """Return the height at `phase` in units of the amplitude."""
        return self.height(phase) / self.amplitude
