"""Manners: how the creatures of a herd have been told to walk, and how they feel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.simulation.curves import ease
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.carriage.bearing import Bearing
from pipeline.simulation.locomotion.gaits.moods import Feeling, blended, in_mood
from pipeline.simulation.locomotion.gaits.pace import Pace, pace_of
from pipeline.simulation.locomotion.herd import Herd
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
        self._bearing: Bearing | None = None
        self.feelings = [[(-2.0 * MOMENT, blended(member.mood, moods))] for _, member, _ in cast]

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

    def bearing(self, time: float) -> Bearing:
        """Return how all carry themselves at `time` [s]; the same object while nothing changes."""
        if self._bearing is None or time <= self._settled:
            self._bearing = Bearing(
                head_raise=self._felt("head", time),
                head_turn=np.ones(len(self.feelings)),
                tail_raise=self._felt("tail", time),
                body_pitch=self._felt("pitch", time),
                sway=self._felt("sway", time),
                wander=self._felt("wander", time),
                looseness=self._felt("looseness", time),
            )
        return self._bearing

    @property
    def _settled(self) -> float:
        """Time from which on nobody carries itself otherwise [s]."""
        return max(since for course in self.feelings for since, _ in course) + 2.0 * MOMENT

    def _felt(self, name: str, time: float) -> Array:
        """Return a part of what creatures (C,) feel at `time` [s]."""
        result = np.empty(len(self.feelings))
        for c, course in enumerate(self.feelings):
            before: Feeling = course[0][1]
            result[c] = getattr(before, name)
            for since, feeling in course[1:]:
                step = getattr(feeling, name) - getattr(before, name)
                done = min(max((time - since) / MOMENT, 0.0), 1.0)
                result[c] += step * ease(np.array(done))
                before = feeling
        return result
