"""Gait change: from one gait into another without a foot that lifts twice or waits.

Over the change each leg's own clock runs a little faster or slower than the creature's,
until the leg is where the other gait has it, the shorter way round. A leg's clock never
stands still, and how long a foot swings is settled when it goes up: so it comes down
once after each going up, whatever happens in between.

Phases count whole cycles and go on for ever, as a walking creature's do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.curves import ease
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.spatial import Array

STEEPEST = 1.875
"""Greatest slope of `ease`."""

SLOWEST = 0.5
"""Least speed of a leg's clock beside the creature's."""

HALVINGS = 60


@dataclass(frozen=True, eq=False)
class GaitChange:
    """A change of gait; before it the legs keep `before`, after it `after`.

    Attributes:
        before, after: gaits of the same legs.
        start: phase at which the change begins, whole cycles counted.
        length: how long it takes, in cycles.

    Raises:
        ValueError: if the legs are not the same, or the change is too short, see
            `shortest`.
    """

    before: Gait
    after: Gait
    start: float
    length: float

    def __post_init__(self) -> None:
        if len(self.before.up) != len(self.after.up):
            raise ValueError(
                f"gaits of {len(self.before.up)} and of {len(self.after.up)} legs do not go over "
                "into one another"
            )
        least = shortest(self.before, self.after)
        if not self.length >= least:
            raise ValueError(
                f"a change of gait of {self.length:g} cycles hurries the legs; "
                f"take {least:.3g} or more"
            )

    @property
    def end(self) -> float:
        """Phase at which the change has come to its end."""
        return self.start + self.length

    @cached_property
    def shift(self) -> Array:
        """(n,) by how much foot-up phases are put off, -0.5 to 0.5 cycles."""
        return shift(self.before, self.after)

    def offset(self, phase: Array | float) -> Array:
        """Return the foot-up phases (..., n) of the moment, as far as they have come."""
        result: Array = self.before.up + self._done(phase)[..., None] * self.shift
        return result

    def leg_phase(self, phase: Array | float) -> Array:
        """Return the phases (..., n) of the legs' own clocks, whole at every foot-up.

        They grow with `phase`, never slower than `SLOWEST` times as fast.
        """
        result: Array = np.asarray(phase)[..., None] - self.offset(phase)
        return result

    def at(self, phase: float) -> Gait:
        """Return the gait of the moment: `before` and `after` at the ends, blended between.

        It is for looking at; what feet do is said by `next_up` and `down_after`.
        """
        if phase <= self.start:
            return self.before
        if phase >= self.end:
            return self.after
        up = np.mod(self.offset(phase), 1.0)
        return Gait(up, np.mod(up + self._swing(np.full(len(up), phase)), 1.0))

    def next_up(self, phase: float) -> Array:
        """Return the phases (n,) at which feet go up next, at `phase` or after it."""
        return self._when(np.ceil(self.leg_phase(phase)))

    def down_after(self, up: Array) -> Array:
        """Return the phases (n,) at which feet come down that went up at `up` (n,)."""
        return self._when(self._clock(up) + self._swing(up))

    def _clock(self, phase: Array) -> Array:
        """Return what each leg's own clock shows (n,) at a phase of its own (n,)."""
        result: Array = phase - self.before.up - self._done(phase) * self.shift
        return result

    def _swing(self, phase: Array) -> Array:
        """Return how long (n,) feet swing that go up at `phase` (n,), by their own clocks."""
        swings = self.before.swing, self.after.swing
        result: Array = swings[0] + self._done(phase) * (swings[1] - swings[0])
        return result

    def _done(self, phase: Array | float) -> Array:
        """Return how much of the change is done at `phase`, 0 to 1."""
        return ease(np.clip((np.asarray(phase) - self.start) / self.length, 0.0, 1.0))

    def _when(self, clock: Array) -> Array:
        """Return the phases (n,) at which the legs' own clocks show `clock` (n,)."""
        ends = clock + np.stack([self.before.up, self.before.up + self.shift])
        low: Array = ends.min(axis=0)
        high: Array = ends.max(axis=0)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            late = self._clock(middle) >= clock
            low, high = np.where(late, low, middle), np.where(late, middle, high)
        return high


def shift(before: Gait, after: Gait) -> Array:
    """Return by how much legs (n,) are put off, the shorter way round, in cycles."""
    result: Array = np.mod(after.up - before.up + 0.5, 1.0) - 0.5
    return result


def shortest(before: Gait, after: Gait) -> float:
    """Return the least length of a change, in cycles, by which no leg is hurried.

    No leg's clock then goes slower than `SLOWEST` nor as much faster than the creature's.
    """
    way = float(np.abs(shift(before, after)).max(initial=0.0))
    return max(way * STEEPEST / (1.0 - SLOWEST), 0.5)
