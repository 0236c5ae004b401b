"""Springs: what hangs on something that moves, follows it late and swings on after it.

A point on a damped spring follows a goal. Between two rows the goal goes straight, and with
e the place of the point relative to it, w its speed relative to it,

    ë + 2ζω ė + ω² e = 0,

which is solved exactly, from row to row: where the goal goes evenly the point has no lag, and
where its speed changes, w changes by as much. So a finer grid of rows shows the same motion
more closely, and no spring however stiff blows up.

Source: Lasseter 1987 for overlapping action and follow-through.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class Oscillators:
    """Damped oscillators, and how they swing in a certain time.

    Attributes:
        frequency: (M,) ω without damping [rad/s].
        damping: (M,) ratio ζ of each to the critical damping, less than 1.
        dt: the time [s].
    """

    frequency: Array
    damping: Array
    dt: float

    @cached_property
    def _terms(self) -> tuple[Array, Array, Array, Array]:
        """How place and speed follow from both before: (M,) each."""
        fall = self.damping * self.frequency
        swing = self.frequency * np.sqrt(1.0 - self.damping**2)
        left = np.exp(-fall * self.dt)
        c, s = left * np.cos(swing * self.dt), left * np.sin(swing * self.dt) / swing
        return c + fall * s, s, -(self.frequency**2) * s, c - fall * s

    def swung(self, e: Array, w: Array) -> tuple[Array, Array]:
        """Return places and speeds (M, ...) after the time, of those that are left alone."""
        by_place, by_speed = self.by(e.ndim)
        place, speed = by_place * e + by_speed * w
        return place, speed

    def by(self, axes: int) -> tuple[Array, Array]:
        """Return what place and speed (2, M, ...) are after the time, by place and by speed."""
        a, b, c, d = (term.reshape(-1, *(1,) * (axes - 1)) for term in self._terms)
        return np.stack([a, c]), np.stack([b, d])


@dataclass(slots=True, eq=False)
class Trailing:
    """Points on springs, each behind its own goal.

    Rows may be given in any portions, which are one after the other in time.

    Attributes:
        springs: M of them, over the time between two rows.
    """

    springs: Oscillators
    _goal: Array | None = field(default=None, init=False)
    _speed: Array | None = field(default=None, init=False)
    _state: Array | None = field(default=None, init=False)

    def follow(self, goals: Array) -> Array:
        """Return where the points are relative to their goals; at rest in the first row of all.

        Args:
            goals: (n, M, ...) at n rows.
        """
        found = np.zeros_like(goals)
        if not len(goals):
            return found
        known = goals if self._goal is None else np.concatenate([self._goal[None], goals])
        self._goal = known[-1].copy()
        speeds = np.diff(known, axis=0) / self.springs.dt
        if not len(speeds):
            return found
        # How fast the goals went before the first row nobody knows: as after it.
        before = speeds[0] if self._speed is None else self._speed
        changes = np.diff(speeds, axis=0, prepend=before[None])
        by_place, by_speed = self.springs.by(goals.ndim - 1)
        state = np.zeros((2, *goals.shape[1:])) if self._state is None else self._state
        # What rests while its goal goes evenly goes on resting.
        moves = bool(state.any() or changes.any())
        for row, change in enumerate(changes if moves else (), len(goals) - len(changes)):
            state = by_place * state[0] + by_speed * (state[1] - change)
            found[row] = state[0]
        self._state, self._speed = state, speeds[-1].copy()
        return found
