"""Surroundings: where all characters are just now, as those who have a mind see them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.characters.actor import SLIM, Stage
from pipeline.simulation.characters.layout import Numbers
from pipeline.simulation.characters.record import PELVIS
from pipeline.simulation.spatial import Array


class Surroundings:
    """All characters by arrays, one row each.

    Attributes:
        stage: where they are.
        kinds: what they are.
        people: (C,) who has the joints of people.
        radius: (C,) of the circle on the ground around each [m].
        places: (C, 3) their middles, of people their pelvises [m].
        velocities: (C, 3) of these [m/s].
        low: (2,) least x and z of the terrain [m].
        high: (2,) likewise the greatest.
        now: the time [s].
    """

    def __init__(self, stage: Stage, kinds: Sequence[str], heights: Sequence[float]) -> None:
        self.stage, self.kinds = stage, tuple(kinds)
        owners = stage.crowd.owners
        self._firsts: Numbers = owners["nodes"][:, 0].copy()
        self._counts: Array = owners["nodes"][:, 1].astype(float)
        self.people = np.array([k in stage.people for k in range(len(kinds))], dtype=bool)
        self._pelvises = self._firsts[self.people] + PELVIS
        self.radius = np.array([stage.circle(k)[1] for k in range(len(kinds))])
        self.radius[self.people] = SLIM * np.array(heights)[self.people]
        self.low, self.high = stage.edges
        self._p, self._before = stage.crowd.p, stage.crowd.before
        self.now = -1.0
        self.look(0.0, 1.0)

    def look(self, now: float, h: float) -> None:
        """See where everybody is now, and how fast; `h` is a sub-step [s]."""
        if now == self.now:
            return
        self.now = now
        self.places = self._middles(self._p)
        self.velocities = (self.places - self._middles(self._before)) / h

    def _middles(self, p: Array) -> Array:
        middles: Array = np.add.reduceat(p, self._firsts, axis=0) / self._counts[:, None]
        middles[self.people] = p[self._pelvises]
        return middles
