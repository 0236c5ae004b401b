"""Pace schedule: the pace of every creature of a herd at every phase.

A creature keeps its first pace until it is ordered to change. Then its feet go over into the new
gait (see `GaitTransition`), and stride, cycle, height and bounce change with them by the same
measure of phase. Past transitions stay known, because poses are solved later than steps are taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import cyclic
from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.locomotion.gaits.gait_transition import GaitTransition, PaceTransition
from pipeline.simulation.locomotion.gaits.pace import BOUNCE_SHAPE, Pace
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, slots=True)
class StepTiming:
    """When a foot swings and stands.

    Attributes:
        up: foot-up phase, whole cycles counted.
        swing, stance: durations of the swing and of the stance after it, in cycles.
    """

    up: float
    swing: float
    stance: float


class PaceSchedule:
    """The paces of a herd.

    Attributes:
        changes: transitions of each creature that was ordered to change, in order.
    """

    def __init__(self, herd: Herd) -> None:
        self.herd = herd
        self.changes: dict[int, list[PaceTransition]] = {}

    def change(self, c: int, pace: Pace, phase: float) -> float:
        """Change creature `c` to `pace`, from `phase` or the end of its last transition.

        Args:
            c: number of the creature.
            pace: the new one.
            phase: now, whole cycles counted.

        Returns:
            The phase at which the transition ends.
        """
        own = self.changes.setdefault(c, [])
        start = max(phase, own[-1].gaits.end) if own else phase
        own.append(PaceTransition.of(self.last(c), pace, start))
        return own[-1].gaits.end

    def last(self, c: int) -> Pace:
        """Return the pace that a creature has, or changes to."""
        own = self.changes.get(c)
        return own[-1].after if own else self.herd.paces[c]

    def value(self, name: str, creature: NDArray[np.int64], phase: Array) -> Array:
        """Return the pace parameter `name` of creatures (N,) at phases (N,)."""
        result: Array = getattr(self.herd, name)[creature]
        for c in self.changes:
            own = creature == c
            result[own] = self.number(name, c, phase[own])
        return result

    def number(self, name: str, c: int, phase: Array) -> Array:
        """Return the pace parameter `name` of one creature at phases (n,)."""
        result = np.full(np.shape(phase), float(getattr(self.herd.paces[c], name)))
        for change in self.changes.get(c, ()):
            step = getattr(change.after, name) - getattr(change.before, name)
            result = result + change.done(phase) * step
        return result

    def heave(self, creature: NDArray[np.int64], phase: Array) -> Array:
        """Return how far bodies (N,) bounce above their heights at phases (N,) [m]."""
        herd = self.herd
        turns = herd.beats[creature] * (phase - self._first_down[creature])
        result = herd.bounciness[creature] * cyclic(BOUNCE_SHAPE, turns)
        for c in {*self._flying, *self.changes}:
            own = creature == c
            at, heave = phase[own], herd.paces[c].heave(phase[own])
            for change in self.changes.get(c, ()):
                step = change.after.heave(at) - change.before.heave(at)
                heave = heave + change.done(at) * step
            result[own] = heave
        return result

    def had_flights(self, creature: NDArray[np.int64], phase: Array) -> NDArray[np.bool_]:
        """Return whether gaits of creatures (N,) have had flights by phases (..., N)."""
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

    def distances(self, creature: NDArray[np.int64], start: Array, phase: Array) -> Array:
        """Return how far creatures (N,) go at full speed from phases (N,) to (N, m) [m]."""
        start = start[:, None]
        result: Array = (phase - start) * self.herd.stride[creature, None]
        for c, changes in self.changes.items():
            own = creature == c
            for change in changes:
                step = change.after.stride - change.before.stride
                since = change.done_since(phase[own]) - change.done_since(start[own])
                result[own] += step * since
        return result

    def distance(self, c: int, start: float, phase: float) -> float:
        """Return how far a creature goes at full speed from one phase to another [m]."""
        return float(self.distances(np.array([c]), np.array([start]), np.array([[phase]]))[0, 0])

    def gait(self, c: int, phase: float) -> Gait | GaitTransition:
        """Return the gait or transition that a creature's feet follow from `phase` on."""
        result: Gait | GaitTransition = self.herd.paces[c].gait
        for change in self.changes.get(c, ()):
            if change.gaits.start <= phase:
                done = change.gaits.end <= phase
                result = change.after.gait if done else change.gaits
        return result

    def step(self, leg: int, phase: float) -> StepTiming:
        """Return the timing of the step of a foot that goes up at `phase`."""
        c = int(self.herd.owner[leg])
        if c not in self.changes:
            swing = float(self.herd.swings[leg])
            return StepTiming(phase, swing, 1.0 - swing)
        gait, own = self.gait(c, phase), leg - int(self.herd.first_leg[c])
        count = len(self.herd.paces[c].gait.up)
        down = float(gait.down_after(np.full(count, phase))[own])
        return StepTiming(phase, down - phase, float(gait.next_up(down)[own]) - down)

    def stances(self, leg: int, first: float, last: float) -> Array:
        """Return the planned stances (n, 2) of a leg between two phases, whole cycles counted."""
        c = int(self.herd.owner[leg])
        own = leg - int(self.herd.first_leg[c])
        count = len(self.herd.paces[c].gait.up)
        found, up = list[tuple[float, float]](), self._next_up(c, own, first - 2.0)
        while up < last:
            if self.is_held_up(leg, up):
                up = self._next_up(c, own, up + 0.5)
                continue
            down = float(self.gait(c, up).down_after(np.full(count, up))[own])
            up = self._next_up(c, own, down)
            found.append((down, up))
        return np.array(found).reshape(-1, 2)

    def _next_up(self, c: int, own: int, phase: float) -> float:
        """Return the next foot-up phase of a leg, also if a transition starts before it."""
        gait = self.gait(c, phase)
        up = float(gait.next_up(phase)[own])
        later = self.gait(c, up)
        return up if later is gait else float(later.next_up(phase)[own])

    def is_held_up(self, leg: int, phase: float) -> bool:
        """Return whether a leg that goes up at `phase` stays held up."""
        c = int(self.herd.owner[leg])
        pace = self.herd.paces[c]
        for change in self.changes.get(c, ()):
            pace = change.after if change.gaits.start <= phase else pace
        return bool(pace.held[leg - self.herd.first_leg[c]])
