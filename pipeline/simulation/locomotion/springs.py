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
        a, b, c, d = (term.reshape(-1, *(1,) * (e.ndim - 1)) for term in self._terms)
        return a * e + b * w, c * e + d * w


@dataclass(slots=True, eq=False)
class Trailing:
    """Points on springs, each behind its own goal.

    Rows may be given in any portions, which are one after the other in time.

    Attributes:
        springs: M of them, over the time between two rows.
    """

    springs: Oscillators
    _goal: Array | None = field(default=None, init=False)
    _state: tuple[Array, Array, Array] | None = field(default=None, init=False)

    def follow(self, goals: Array) -> Array:
        """Return where the points are relative to their goals; at rest in the first row of all.

        Args:
            goals: (n, M, ...) at n rows.
        """
        found = np.zeros_like(goals)
        for row, goal in enumerate(goals):
            if self._goal is not None:
                speed = (goal - self._goal) / self.springs.dt
                if self._state is None:
                    # How fast the goals went before the first row nobody knows: as after it.
                    self._state = np.zeros_like(goal), np.zeros_like(goal), speed
                e, w, before = self._state
                found[row], w = self.springs.swung(e, w - (speed - before))
                self._state = found[row].copy(), w, speed
            self._goal = goal.copy()
        return found
