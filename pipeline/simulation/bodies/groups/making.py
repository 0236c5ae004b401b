"""Making for: what a flock or a school goes to.

What it was sent to by the script, otherwise whom it follows, otherwise the places of its path
one after the other, otherwise the place where it began.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeline.simulation.bodies.groups.others import Cast, Others
from pipeline.simulation.bodies.groups.rule import Setting, start_of
from pipeline.simulation.spatial import Array
from pipeline.spec.group import Flock, School

NEAR = 1.2
"""How long before it would be at a place of its path it makes for the next [s]."""


class Making:
    """What one group makes for."""

    def __init__(self, setting: Setting, words: Flock | School) -> None:
        self.setting = setting
        self.words = words
        self._followed: int | None = None
        self._next = 0
        self._sent: list[tuple[float, Array]] = []

    def meet(self, cast: Cast) -> None:
        """Find whom it follows.

        Raises:
            SceneError: nobody is called so.
        """
        if self.words.follow is not None:
            path = f"{self.setting.path}.group.follow"
            self._followed = cast.number(self.words.follow, path)

    def send(self, time: float, goal: tuple[float, float], above: float) -> None:
        """Make for a place (x, z), `above` the ground [m], from `time` [s] on."""
        place = start_of(goal, self.setting.world) + np.array([0.0, above, 0.0])
        self._sent.append((time, place))

    def goals(self, times: Array, others: Others) -> Callable[[int, Array], Array]:
        """Return what says the goal (3,) of the k-th of `times`, given the places (N, 3)."""

        def goal(k: int, p: Array) -> Array:
            sent = [place for time, place in self._sent if time <= times[k]]
            if sent:
                return sent[-1]
            if self._followed is not None:
                up = np.array([0.0, self.words.above, 0.0])
                followed: Array = others.p[k, self._followed] + up
                return followed
            return self._of_path(p) if self.words.path else self.setting.place

        return goal

    def _of_path(self, p: Array) -> Array:
        path = self.words.path
        place = np.array(path[self._next])
        away = place - p.mean(axis=0)
        if (away * away).sum() < (NEAR * self.words.speed) ** 2:
            self._next = (self._next + 1) % len(path)
        return np.array(path[self._next])
