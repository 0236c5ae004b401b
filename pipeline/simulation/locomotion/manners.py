"""Manners: how the creatures of a herd have been told to walk, and how they feel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.simulation.curves import ease
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.moods import Feeling, blended, in_mood
from pipeline.simulation.locomotion.pace import Pace, pace_of
from pipeline.simulation.spatial import Array
from pipeline.spec.cast import Creature
from pipeline.spec.mood import Mood
from pipeline.spec.script import ChangeGait

MOMENT = 0.9
"""Time in which a creature comes to carry itself otherwise [s]."""


class Manners:
    """Paces without moods, and moods, of a herd.

    Attributes of the state:
        plain: pace of each creature as it was last told, without its mood.
        feelings: of each creature: since when it has felt how, in order [s].
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        herd: Herd,
        moods: Mapping[str, Mood],
    ) -> None:
        self.herd = herd
        self.moods = moods
        self.plain = list(herd.plain)
        self.feelings = [[(0.0, blended(member.mood, moods))] for _, member, _ in cast]

    def possible(self, c: int, order: ChangeGait, where: str = "do") -> Pace:
        """Return the pace that a creature is asked to have, without its mood.

        Args:
            c: who.
            order: what it is told.
            where: path of the order in the scene.

        Raises:
            SceneError: if its legs cannot do so.
        """
        return pace_of(where, order, self.herd.figures[c], self.herd.spreads[c])

    def told(self, c: int, order: ChangeGait) -> Pace:
        """Return the pace of a creature that is told to change its gait.

        Raises:
            SceneError: if its legs cannot do so.
        """
        self.plain[c] = self.possible(c, order)
        return self._in_mood(c)

    def felt(self, c: int, mix: Mapping[str, float], time: float) -> Pace:
        """Return the pace of a creature that is in other moods from `time` on [s]."""
        self.feelings[c].append((time, blended(mix, self.moods)))
        return self._in_mood(c)

    def _in_mood(self, c: int) -> Pace:
        feeling = self.feelings[c][-1][1]
        return in_mood(self.plain[c], feeling, self.herd.figures[c], self.herd.spreads[c])

    def bearing(self, name: str, times: Array) -> Array:
        """Return how creatures carry themselves (n, C) at `times` (n,): a part of `Feeling`."""
        result = np.empty((len(times), len(self.feelings)))
        for c, course in enumerate(self.feelings):
            before: Feeling = course[0][1]
            result[:, c] = getattr(before, name)
            for since, feeling in course[1:]:
                step = getattr(feeling, name) - getattr(before, name)
                result[:, c] += step * ease(np.clip((times - since) / MOMENT, 0.0, 1.0))
                before = feeling
        return result
