"""Sliding tracker: intervals during which bodies roll or slide over the ground.

A body slides if its contact moves along the ground; a ball rolls if its middle does and the
contact hardly. (A polyhedron that rolls strikes with edge after edge.) An interval begins when the
body has been fast for a while, and ends when it has been slow, or in the air, for a while: a
rattle is one interval, and settling or shivering is none. Its limits are those of the motion.

Source: Sims 1987, 13.1.2, sounds from motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Place
from pipeline.spec.sound_thresholds import Roll

MAX_GAP_STEPS = 2
"""Steps without it that take a rub back which has not yet lasted, and are not heard in one."""

ROLLING_SLIP_RATIO = 0.2
"""Part of a ball's speed that its contact has at most while it rolls."""

SlidingKind = Literal["roll", "slide"]


@dataclass(frozen=True, slots=True)
class SlidingInterval:
    """A body has rolled or slid.

    Attributes:
        body: its number.
        kind: which.
        first: the first step at which it did.
        last: the last one.
        place: (3,) where it began [m].
        normal: (3,) of the ground there.
        speed: the greatest along the ground [m/s].
        other: on what it did, in the begin.
        speeds: at each step from the first to the last [m/s].
        places: of the contact at each of them [m].
    """

    body: int
    kind: SlidingKind
    first: int
    last: int
    place: Place
    normal: Place
    speed: float
    other: int
    speeds: tuple[float, ...]
    places: tuple[Place, ...]


class SlidingTracker:
    """One way in which N bodies rub.

    Attributes:
        kind: which.
        words: from when on that is a rub.
    """

    def __init__(self, kind: SlidingKind, count: int, dt: float, words: Roll) -> None:
        self.kind, self.words = kind, words
        self._begins, self._ends = max(round(words.least / dt), 1), max(round(words.pause / dt), 1)
        self._first = np.full(count, -1)
        self._last = np.full(count, -1)
        self._on = np.zeros(count, dtype=bool)
        self._speed = np.zeros(count)
        self._other = np.zeros(count, dtype=np.int64)
        self._way: dict[int, list[tuple[float, Place]]] = {}
        self._place, self._normal = np.zeros((count, 3)), np.zeros((count, 3))

    def look(
        self,
        step: int,
        touches: NDArray[np.bool_],
        speed: Array,
        place: Array,
        normal: Array,
        final: bool,
        other: NDArray[np.int64] | int = 0,
    ) -> list[SlidingInterval]:
        """Take in how bodies move at a step; return the rubs that have ended.

        Args:
            step: the number of it, counted on by one.
            touches: (N,) who may rub.
            speed: (N,) along the ground [m/s].
            place: (N, 3) of the contacts [m].
            normal: (N, 3) of the ground there.
            final: whether no step follows.
            other: (N,) on what they move.
        """
        least = np.where(self._first >= 0, self.words.ends, self.words.above)
        goes = touches & (speed > least)
        new = goes & (self._first < 0)
        self._first[new], self._speed[new] = step, 0.0
        self._place[new], self._normal[new] = place[new], normal[new]
        self._other[new] = np.broadcast_to(other, new.shape)[new]
        self._last[goes] = step
        self._speed[goes] = np.maximum(self._speed, speed)[goes]
        for i in np.flatnonzero(self._first >= 0).tolist():
            x, y, z = place[i].tolist()
            at = float(speed[i]) if touches[i] else 0.0, (x, y, z)
            self._way.setdefault(i, []).append(at)
        self._on |= goes & (step - self._first >= self._begins)
        # Before it has begun a pause takes it back; after that only a long one ends it.
        rest = np.where(self._on, self._ends, MAX_GAP_STEPS)
        over = (self._first >= 0) & ((step - self._last >= rest) | final)
        ended = [self._rub(int(i)) for i in np.flatnonzero(over & self._on)]
        self._first[over], self._on[over] = -1, False
        for i in np.flatnonzero(over).tolist():
            self._way.pop(i, None)
        return ended

    def _rub(self, i: int) -> SlidingInterval:
        x, y, z = self._place[i].tolist()
        a, b, c = self._normal[i].tolist()
        first, last = int(self._first[i]), int(self._last[i])
        speed, other = float(self._speed[i]), int(self._other[i])
        # Of the pause in which it ended nothing is heard.
        speeds, places = zip(*self._way[i][: last - first + 1], strict=True)
        where = (x, y, z), (a, b, c)
        return SlidingInterval(
            i, self.kind, first, last, *where, speed, other, _bridge_gaps(speeds), places
        )


def _bridge_gaps(speeds: Sequence[float]) -> tuple[float, ...]:
    """Return speeds with shaking contacts left out: a step or two at 0 between two others."""
    found, moving = list(speeds), [k for k, speed in enumerate(speeds) if speed > 0.0]
    for a, b in pairwise(moving):
        if 1 < b - a <= MAX_GAP_STEPS + 1:
            for k in range(a + 1, b):
                found[k] = speeds[a] + (speeds[b] - speeds[a]) * (k - a) / (b - a)
    return tuple(found)
