"""Gait transition: from one gait into another without a foot that lifts twice or waits.

During a transition each leg's own clock runs a little faster or slower than the creature's, until
the leg has its phase in the other gait, the shorter way round. A leg's clock never stops, and a
swing's duration is fixed at lift-off; so a foot comes down exactly once after each lift-off.

Phases count whole cycles and grow for ever, as a walking creature's do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.curves import ease
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.spatial import Array

# Greatest slope of `ease`.
MAX_EASE_SLOPE = 1.875

# Least rate of a leg's clock, relative to the creature's.
MIN_CLOCK_RATE = 0.5

BISECTIONS = 60

# Least length of a change of pace: in cycles, and in lengths of the shortest transition, because a
# leg whose clock is slowed stands longer and is stretched farther.
MIN_CYCLES, MIN_SLOWDOWN = 2.5, 2.5

# Greatest acceleration of a change of pace [m/s²].
MAX_ACCELERATION = 5.0


@dataclass(frozen=True, eq=False)
class GaitTransition:
    """A transition between two gaits; the legs keep `before` before it, and `after` after it.

    Attributes:
        before, after: gaits of the same legs.
        start: phase at which it starts, whole cycles counted.
        length: in cycles.
        strides: before and after; the ground that feet stand through changes evenly, so long
            strides never come with long stances [m].

    Raises:
        ValueError: if the legs differ, or it is shorter than `shortest_transition`.
    """

    before: Gait
    after: Gait
    start: float
    length: float
    strides: tuple[float, float] = (1.0, 1.0)

    def __post_init__(self) -> None:
        if len(self.before.up) != len(self.after.up):
            raise ValueError(
                f"cannot change from a gait of {len(self.before.up)} legs to one of "
                f"{len(self.after.up)} legs"
            )
        least = shortest_transition(self.before, self.after)
        if not self.length >= least:
            raise ValueError(
                f"a gait transition of {self.length:g} cycles is too fast for the legs; "
                f"take {least:.3g} or more"
            )

    @property
    def end(self) -> float:
        """Phase at which the transition ends."""
        return self.start + self.length

    @cached_property
    def shift(self) -> Array:
        """(n,) delays of the foot-up phases, -0.5 to 0.5 cycles."""
        return phase_shift(self.before, self.after)

    def done(self, phase: Array | float) -> Array:
        """Return the finished fraction of the transition at `phase`, 0 to 1."""
        return ease(np.clip((np.asarray(phase) - self.start) / self.length, 0.0, 1.0))

    def offset(self, phase: Array | float) -> Array:
        """Return the foot-up phases (..., n) that hold at `phase`."""
        return self.before.up + self.done(phase)[..., None] * self.shift

    def leg_phase(self, phase: Array | float) -> Array:
        """Return the phases (..., n) of the legs' own clocks, whole numbers at every foot-up.

        They grow with `phase`, never slower than `MIN_CLOCK_RATE` times as fast.
        """
        return np.asarray(phase)[..., None] - self.offset(phase)

    def at(self, phase: float) -> Gait:
        """Return the blended gait at `phase`, for display only."""
        if phase <= self.start:
            return self.before
        if phase >= self.end:
            return self.after
        up = np.mod(self.offset(phase), 1.0)
        return Gait(up, np.mod(up + self._swing(np.full(len(up), phase)), 1.0))

    def next_up(self, phase: float) -> Array:
        """Return the phases (n,) of the next foot-up of every leg, at `phase` or later."""
        return self._when(np.ceil(self.leg_phase(phase)))

    def down_after(self, up: Array) -> Array:
        """Return the phases (n,) at which feet come down that went up at `up` (n,)."""
        return self._when(self._clock(up) + self._swing(up))

    def _clock(self, phase: Array) -> Array:
        """Return the time (n,) of each leg's clock at its phase (n,)."""
        return phase - self.before.up - self.done(phase) * self.shift

    def _swing(self, phase: Array) -> Array:
        """Return the swings (n,), by the legs' own clocks, of feet that go up at `phase` (n,)."""
        done = self.done(phase)
        first, last = (1.0 - done) * self.strides[0], done * self.strides[1]
        duty: Array = (first * self.before.duty + last * self.after.duty) / (first + last)
        return 1.0 - duty

    def _when(self, clock: Array) -> Array:
        """Return the phases (n,) at which the legs' own clocks show `clock` (n,)."""
        ends = clock + np.stack([self.before.up, self.before.up + self.shift])
        low: Array = ends.min(axis=0)
        high: Array = ends.max(axis=0)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            late = self._clock(middle) >= clock
            low, high = np.where(late, low, middle), np.where(late, middle, high)
        return high


def phase_shift(before: Gait, after: Gait) -> Array:
    """Return the delays of the legs (n,), the shorter way round, in cycles."""
    return np.mod(after.up - before.up + 0.5, 1.0) - 0.5


def shortest_transition(before: Gait, after: Gait) -> float:
    """Return the least length of a transition, in cycles.

    No leg's clock then runs slower than `MIN_CLOCK_RATE`, nor as much faster than the creature's.
    """
    largest = float(np.abs(phase_shift(before, after)).max(initial=0.0))
    return max(largest * MAX_EASE_SLOPE / (1.0 - MIN_CLOCK_RATE), 0.5)


@dataclass(frozen=True, eq=False)
class PaceTransition:
    """A transition between two paces.

    Attributes:
        before, after: paces.
        gaits: transition of the feet, and the phases over which it happens.
    """

    before: Pace
    after: Pace
    gaits: GaitTransition

    @staticmethod
    def of(before: Pace, after: Pace, phase: float) -> PaceTransition:
        """Start a transition at `phase`, whole cycles counted."""
        least = MIN_CYCLES if before.gait_name != after.gait_name else 0.0
        change = abs(after.speed - before.speed) / (0.5 * (before.cycle + after.cycle))
        length = max(
            least,
            MIN_SLOWDOWN * shortest_transition(before.gait, after.gait),
            MAX_EASE_SLOPE * change / MAX_ACCELERATION,
        )
        strides = before.stride, after.stride
        gaits = GaitTransition(before.gait, after.gait, phase, length, strides)
        return PaceTransition(before, after, gaits)

    def done(self, phase: Array) -> Array:
        """Return the finished fraction at `phase`, 0 to 1."""
        return self.gaits.done(phase)

    def done_since(self, phase: Array) -> Array:
        """Return the integral of `done` up to `phase`, in cycles."""
        gaits = self.gaits
        u = np.maximum((phase - gaits.start) / gaits.length, 0.0)
        t = np.minimum(u, 1.0)
        return gaits.length * (t**4 * (2.5 + t * (t - 3.0)) + (u - t))
