"""Flights: what speeds through the air, in spells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.detect.hearing import event_of_spell
from pipeline.simulation.detect.scenery import Scenery, Seen, Solid
from pipeline.simulation.detect.spells import Spells
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import SoundEvent
from pipeline.spec.sound_thresholds import Moving


class Flights:
    """Solids whose flight is heard as one cause.

    Args:
        scenery: who there is.
        solids: that are watched.
        words: the author's, of the cause.
        cause: its name.
        least: (N,) speeds under which no solid is heard, whatever the words say [m/s].
    """

    def __init__(
        self, scenery: Scenery, solids: Sequence[Solid], words: Moving, cause: str, least: Array
    ) -> None:
        self.scenery, self.solids, self.cause = scenery, solids, cause
        self.idle = not solids
        self._nodes = np.array([s.node for s in solids], dtype=np.int64)
        upper = np.maximum(words.above, least)
        # What is raised keeps the ratio of its two thresholds.
        lower = upper * (words.ends / words.above if words.above else 1.0)
        self._spells = Spells(lower, upper, words, scenery.dt)

    def look(self, seen: Seen) -> list[SoundEvent]:
        """See `Watch`."""
        p = seen.p[:, self._nodes]
        moved = p[1:] - p[:-1]
        alive = seen.alive[1:, self._nodes] & seen.alive[:-1, self._nodes]
        between = alive * np.sqrt((moved * moved).sum(axis=-1)) / self.scenery.dt
        speed = seen.by_row(between)
        values = np.concatenate([speed[..., None], p[seen.told]], axis=-1)
        first = seen.first + seen.told.start
        return [
            event_of_spell(spell, self.cause, self.solids[spell.thing], self.scenery.clock)
            for spell in self._spells.look(first, speed, values, seen.final)
        ]
