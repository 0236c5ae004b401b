"""Motions that are heard: all causes that are found in the rows as everybody stood in them.

Rows come in batches; what is found does not hang on where one ends, since every batch begins
with the last two rows of the one before.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.detect.scenery import Scenery, Seen
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, SoundEvent
from pipeline.spec.sound_thresholds import Cause, Detect

NEIGHBOURS = 2
"""Rows that are kept for the next batch: the last one told, and the one that waits."""


class Watch(Protocol):
    """Watches rows for one cause."""

    idle: bool
    """Whether there is nothing that it could hear."""

    def look(self, seen: Seen) -> list[SoundEvent]:
        """Take in rows that follow the last ones; return the sound events that are known now."""


class MakesWatch(Protocol):
    """Makes a watch of the words of its cause."""

    def __call__(self, scenery: Scenery, detect: Detect) -> Watch:
        """Return the watch."""


class Motions:
    """All causes that are motions.

    Args:
        causes: cause -> what makes its watch.
        detect: the author's thresholds.
        scenery: who there is to be heard.
    """

    def __init__(self, causes: Mapping[str, MakesWatch], detect: Detect, scenery: Scenery) -> None:
        heard = [make for cause, make in causes.items() if _words(detect, cause).heard]
        watches = [make(scenery, detect) for make in heard]
        self._watches = [watch for watch in watches if not watch.idle]
        self._clock = scenery.clock
        self._lifts: dict[str, list[float]] = {}
        self._kept: tuple[Array, Array, NDArray[np.bool_], Array] | None = None
        self._told = False

    def met(self, contacts: Iterable[Contact]) -> None:
        """Take in contacts: whose feet leave the ground is told more exactly than rows have it."""
        clock = self._clock
        for contact in contacts:
            if contact.kind == "lift":
                row = (contact.step + contact.fraction) * clock.samples / clock.steps
                self._lifts.setdefault(contact.performer, []).append(row)

    def look(
        self, which: slice, p: Array, R: Array, alive: NDArray[np.bool_], values: Array
    ) -> list[SoundEvent]:
        """Take in the rows `which`; return the sound events that are known now.

        Args:
            which: the rows after the last ones.
            p: (n, J, 3) positions of all nodes [m].
            R: (n, J, 3, 3) their rotations.
            alive: (n, J).
            values: (n, C) of all channels.
        """
        if not self._watches:
            return []
        if self._kept is not None:
            kept_p, kept_R, kept_alive, kept_values = self._kept
            p, R = np.concatenate([kept_p, p]), np.concatenate([kept_R, R])
            alive = np.concatenate([kept_alive, alive])
            values = np.concatenate([kept_values, values])
        final = which.stop == self._clock.rows
        first = which.stop - len(p)
        # The first row of all has no neighbour before it, the last one waits for its own.
        told = slice(1 if self._told else 0, len(p) - (not final))
        self._told = self._told or told.stop > told.start
        last = slice(-NEIGHBOURS, None)
        # Copies: the arrays that rows come in are written again.
        kept_p, kept_R = p[last].copy(), R[last].copy()
        self._kept = kept_p, kept_R, alive[last].copy(), values[last].copy()
        seen = Seen(first, told, p, R, alive, values, final, self._lifts)
        return [event for watch in self._watches for event in watch.look(seen)]


def _words(detect: Detect, cause: str) -> Cause:
    words: Any = getattr(detect, cause)
    assert isinstance(words, Cause)
    return words
