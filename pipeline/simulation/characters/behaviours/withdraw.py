"""Withdrawal: a fast, open-loop retreat from what has hurt.

Source: Horswill 2008, "High-level Control".
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.approach import leads_free
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.simulation.spatial import Array

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

LASTS = 0.8
"""How long it goes on [s]."""

STEPS_BACK = 1.4
"""How far away the place is that it goes to [m]."""

ASIDE = tuple(math.radians(k) for k in (0.0, 35.0, -35.0, 70.0, -70.0))
"""By how much it steps back aside from straight away, where something stands there."""

FAST = 0.55
"""How fast, as a part of √(g l)."""

URGENT = 2.0
"""Its activation: nothing else comes before it."""


class Withdraw:
    """Step back from pain; decided when it begins, and not changed after."""

    def __init__(self) -> None:
        self.struck = -math.inf
        self.told = Motor()

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        return URGENT if mind.now - mind.struck[0] < LASTS else 0.0

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        since, by = mind.struck
        if since != self.struck:
            self.struck, self.told = since, self._away(mind, by)
        return self.told

    def _away(self, mind: Mind, by: int) -> Motor:
        heading = float(mind.actor.me.heading)
        to = mind.place(by) - mind.at if by >= 0 else np.array([0.0, 0.0])
        size = math.hypot(to[0], to[1])
        if size < 1e-6:
            to, size = np.array([math.cos(heading), -math.sin(heading)]), 1.0
        away = math.atan2(-to[1], -to[0])
        goals = [self._place(mind, away + turn) for turn in ASIDE]
        free = [goal for goal in goals if leads_free(mind, goal)]
        goal = free[0] if free else goals[0]
        return Motor(
            goal=(float(goal[0]), float(goal[1])),
            pace=FAST * mind.root,
            facing=math.atan2(-to[1], to[0]),
            target=by,
        )

    @staticmethod
    def _place(mind: Mind, way: float) -> Array:
        around = mind.around
        goal = mind.at + STEPS_BACK * np.array([math.cos(way), math.sin(way)])
        result: Array = np.clip(goal, around.low + 0.5, around.high - 0.5)
        return result

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
