"""Paces: how the creatures of a herd are paced at every phase, and how one pace becomes another.

A creature keeps the pace that it begins with until it is told otherwise. Then its feet go
over into the new gait (see `GaitTransition`), and with them, by the same measure of phase,
the length and duration of its cycle, its height and its bounce. What was, stays known,
because poses are worked out later than steps are taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import cyclic, ease
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.pace import BOUNCE, Pace
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array

STEEPEST = 1.875
"""Greatest slope of `ease`."""

SLOWEST = 0.5
"""Least speed of a leg's clock beside the creature's."""

HALVINGS = 60


@dataclass(frozen=True, eq=False)
class GaitTransition:
    """A change of gait; before it the legs keep `before`, after it `after`.

    Attributes:
        before, after: gaits of the same legs.
        start: phase at which the change begins, whole cycles counted.
        length: how long it takes, in cycles.

    Raises:
        ValueError: if the legs are not the same, or the change is too short, see
            `shortest_transition`.
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
        least = shortest_transition(self.before, self.after)
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
        return phase_shift(self.before, self.after)

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


def phase_shift(before: Gait, after: Gait) -> Array:
    """Return by how much legs (n,) are put off, the shorter way round, in cycles."""
    result: Array = np.mod(after.up - before.up + 0.5, 1.0) - 0.5
    return result


def shortest_transition(before: Gait, after: Gait) -> float:
    """Return the least length of a change, in cycles, by which no leg is hurried.

    No leg's clock then goes slower than `SLOWEST` nor as much faster than the creature's.
    """
    way = float(np.abs(phase_shift(before, after)).max(initial=0.0))
    return max(way * STEEPEST / (1.0 - SLOWEST), 0.5)


@dataclass(frozen=True, slots=True)
class StepTiming:
    """When a foot swings and stands.

    Attributes:
        up: phase at which it goes up, whole cycles counted.
        swing, stance: how long it is in the air, and down after that, in cycles.
    """

    up: float
    swing: float
    stance: float


CYCLES = 2.5
"""How long a change takes at least, in cycles."""

UNHURRIED = 2.5
"""How much longer than it has to be: a leg whose clock is slowed stands longer, and is
drawn out farther."""


@dataclass(frozen=True, eq=False)
class PaceTransition:
    """One pace that becomes another.

    Attributes:
        before, after: paces.
        gaits: how the feet go over, and over which phases.
    """

    before: Pace
    after: Pace
    gaits: GaitTransition

    @staticmethod
    def of(before: Pace, after: Pace, phase: float) -> PaceTransition:
        """Begin a change at `phase`, whole cycles counted."""
        length = max(CYCLES, UNHURRIED * shortest_transition(before.gait, after.gait))
        return PaceTransition(before, after, GaitTransition(before.gait, after.gait, phase, length))

    def done(self, phase: Array) -> Array:
        """Return how much of it is done at `phase`, 0 to 1."""
        gaits = self.gaits
        return ease(np.clip((phase - gaits.start) / gaits.length, 0.0, 1.0))

    def done_since(self, phase: Array) -> Array:
        """Return the integral of `done` up to `phase`, in cycles."""
        gaits = self.gaits
        u = np.maximum((phase - gaits.start) / gaits.length, 0.0)
        t = np.minimum(u, 1.0)
        result: Array = gaits.length * (t**4 * (2.5 + t * (t - 3.0)) + (u - t))
        return result


class PaceSchedule:
    """The paces of a herd.

    Attributes of the state:
        changes: of the creatures that were told to walk otherwise, in their order.
    """

    def __init__(self, herd: Herd) -> None:
        self.herd = herd
        self.changes: dict[int, list[PaceTransition]] = {}

    def change(self, c: int, pace: Pace, phase: float) -> float:
        """Let creature `c` go over to `pace`, from `phase` on or from the end of its last change.

        Returns:
            The phase at which that will have been done.
        """
        own = self.changes.setdefault(c, [])
        start = max(phase, own[-1].gaits.end) if own else phase
        own.append(PaceTransition.of(self.last(c), pace, start))
        return own[-1].gaits.end

    def last(self, c: int) -> Pace:
        """Return the pace that a creature has, or is about to have."""
        own = self.changes.get(c)
        return own[-1].after if own else self.herd.paces[c]

    def value(self, name: str, creature: NDArray[np.int64], phase: Array) -> Array:
        """Return a number of the pace of creatures (N,) at their phases (N,), by its name."""
        result: Array = getattr(self.herd, name)[creature]
        for c in self.changes:
            own = creature == c
            result[own] = self.number(name, c, phase[own])
        return result

    def number(self, name: str, c: int, phase: Array) -> Array:
        """Return a number of the pace of one creature at phases (n,), by its name."""
        result = np.full(np.shape(phase), float(getattr(self.herd.paces[c], name)))
        for change in self.changes.get(c, ()):
            step = getattr(change.after, name) - getattr(change.before, name)
            result = result + change.done(phase) * step
        return result

    def heave(self, creature: NDArray[np.int64], phase: Array) -> Array:
        """Return how far bodies (N,) bounce above their heights at phases (N,) [m]."""
        herd = self.herd
        turns = herd.beats[creature] * (phase - self._first_down[creature])
        result = herd.bounciness[creature] * cyclic(BOUNCE, turns)
        for c in {*self._flying, *self.changes}:
            own = creature == c
            result[own] = self._heave(c, phase[own])
        return result

    def _heave(self, c: int, phase: Array) -> Array:
        result = self.herd.paces[c].heave(phase)
        for change in self.changes.get(c, ()):
            result = result + change.done(phase) * (
                change.after.heave(phase) - change.before.heave(phase)
            )
        return result

    def flies(self, creature: NDArray[np.int64], phase: Array) -> NDArray[np.bool_]:
        """Tell of creatures (N,) at phases (..., N) whether their gaits have, or had, flights."""
        result = np.tile(np.isin(creature, self._flying), (*phase.shape[:-1], 1))
        for c, changes in self.changes.items():
            for change in changes:
                if change.after.flight is not None:
                    result |= (creature == c) & (phase >= change.gaits.start)
        return result

    @cached_property
    def _first_down(self) -> Array:
        return np.array([pace.first_down for pace in self.herd.paces])

    @cached_property
    def _flying(self) -> list[int]:
        return [c for c, pace in enumerate(self.herd.paces) if pace.flight is not None]

    def way(self, c: int, start: float, phase: Array) -> Array:
        """Return the way (n,) that a creature goes from phase `start` to `phase` (n,) [m]."""
        result: Array = (phase - start) * float(self.herd.stride[c])
        for change in self.changes.get(c, ()):
            step = change.after.stride - change.before.stride
            result = result + step * (
                change.done_since(phase) - change.done_since(np.asarray(start))
            )
        return result

    def gait(self, c: int, phase: float) -> Gait | GaitTransition:
        """Return what a creature's feet keep to from `phase` on."""
        result: Gait | GaitTransition = self.herd.paces[c].gait
        for change in self.changes.get(c, ()):
            if change.gaits.start <= phase:
                done = change.gaits.end <= phase
                result = change.after.gait if done else change.gaits
        return result

    def step(self, leg: int, phase: float) -> StepTiming:
        """Return when a foot swings and stands that goes up at `phase`."""
        c = int(self.herd.owner[leg])
        if c not in self.changes:
            swing = float(self.herd.swings[leg])
            return StepTiming(phase, swing, 1.0 - swing)
        gait, own = self.gait(c, phase), leg - int(self.herd.first_leg[c])
        count = len(self.herd.paces[c].gait.up)
        down = float(gait.down_after(np.full(count, phase))[own])
        return StepTiming(phase, down - phase, float(gait.next_up(down)[own]) - down)

    def stances(self, leg: int, first: float, last: float) -> Array:
        """Return from which phase to which (n, 2) a leg was planned to be down.

        Args:
            leg: which.
            first: phase from which all are wanted, whole cycles counted.
            last: phase up to which they are.
        """
        c = int(self.herd.owner[leg])
        own = leg - int(self.herd.first_leg[c])
        count = len(self.herd.paces[c].gait.up)
        found, up = list[tuple[float, float]](), self._next_up(c, own, first - 2.0)
        while up < last:
            if self.held(leg, up):
                up = self._next_up(c, own, up + 0.5)
                continue
            down = float(self.gait(c, up).down_after(np.full(count, up))[own])
            up = self._next_up(c, own, down)
            found.append((down, up))
        return np.array(found).reshape(-1, 2)

    def _next_up(self, c: int, own: int, phase: float) -> float:
        """Return when a leg goes up after `phase`, also if a change begins before that."""
        gait = self.gait(c, phase)
        up = float(gait.next_up(phase)[own])
        later = self.gait(c, up)
        return up if later is gait else float(later.next_up(phase)[own])

    def held(self, leg: int, phase: float) -> bool:
        """Return whether a leg that goes up at `phase` is held up then."""
        c = int(self.herd.owner[leg])
        pace = self.herd.paces[c]
        for change in self.changes.get(c, ()):
            pace = change.after if change.gaits.start <= phase else pace
        return bool(pace.held[leg - self.herd.first_leg[c]])
