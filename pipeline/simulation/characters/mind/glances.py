"""Glances: where somebody looks: to what it attends to, where it goes, and what wants watching.

A need to look at each that wants watching grows as fast as its priority says; who is due gets a
glance, and then the eyes go back.

Source: Horswill 2008, "Example application" (gaze control).
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.spatial import Array

RATE = 0.75
"""Glances a second at what has a priority of 1."""

LASTS = (0.55, 0.95)
"""How long a glance lasts [s]."""

BETWEEN = 0.5
"""How long eyes rest on their way between two glances, at least [s]."""

ON_TARGET, ON_FOCUS = 1.6, 0.8
"""How long they rest on where somebody goes, and on what else it attends to [s]."""


class Glances:
    """Where one looks.

    Attributes:
        at: number of whom it looks at, -1 for straight ahead.
        glancing: whether that is a glance aside.
    """

    def __init__(self, count: int, rng: np.random.Generator) -> None:
        self._need = 0.5 * rng.random(count)
        self._rng = rng
        self._until, self._rested = 0.0, 0.0
        self.at, self.glancing = -1, False

    def look(self, now: float, dt: float, priority: Array, focus: int, target: int) -> None:
        """Choose whom to look at for the next `dt` [s].

        Args:
            now: the time [s].
            dt: since it was last chosen [s].
            priority: (C,) of watching each.
            focus: of attention, -1 for none.
            target: where it goes, -1 for nowhere.
        """
        self._need += RATE * dt * priority
        if self.at >= 0:
            self._need[self.at] = 0.0
        if self.glancing and now < self._until:
            return
        if self.glancing:
            self.glancing, self._rested = False, now + BETWEEN
        due = int(self._need.argmax())
        if self._need[due] > 1.0 and now >= self._rested and due not in (focus, target):
            low, high = LASTS
            self.at, self.glancing = due, True
            self._until = now + low + (high - low) * float(self._rng.random())
            return
        if focus < 0 or target < 0 or focus == target:
            self.at = target if focus < 0 else focus
            return
        # Both in turn.
        turn = now % (ON_TARGET + ON_FOCUS)
        self.at = target if turn < ON_TARGET else focus
