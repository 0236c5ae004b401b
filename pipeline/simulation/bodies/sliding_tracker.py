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
"""Observations without motion that cancel an interval that has not lasted yet, and that are bridged
within one."""

ROLLING_SLIP_RATIO = 0.2
"""Largest slip of the contact of a rolling ball, relative to its speed."""

SlidingKind = Literal["roll", "slide"]


@dataclass(frozen=True, slots=True)
class SlidingInterval:
    """An interval during which a body rolled or slid.

    Attributes:
        body: number of the body.
        kind: "roll" or "slide".
        first: first observation of the motion.
        last: last one.
        place: (3,) where it began [m].
        normal: (3,) of the ground there.
        speed: greatest tangential speed [m/s].
        other: the other thing at the start.
        speeds: at each observation from the first to the last [m/s].
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
    """Intervals of one kind of N bodies.

    Attributes:
        kind: "roll" or "slide".
        config: thresholds.
    """

    def __init__(self, kind: SlidingKind, count: int, dt: float, config: Roll) -> None:
        self.kind, self.config = kind, config
        self._begins, self._ends = (
            max(round(config.least / dt), 1),
            max(round(config.pause / dt), 1),
        )
        self._first = np.full(count, -1)
        self._last = np.full(count, -1)
        self._on = np.zeros(count, dtype=bool)
        self._speed = np.zeros(count)
        self._other = np.zeros(count, dtype=np.int64)
        self._way: dict[int, list[tuple[float, Place]]] = {}
        self._place, self._normal = np.zeros((count, 3)), np.zeros((count, 3))

    def observe(
        self,
        step: int,
        touches: NDArray[np.bool_],
        speed: Array,
        place: Array,
        normal: Array,
        final: bool,
        other: NDArray[np.int64] | int = 0,
    ) -> list[SlidingInterval]:
        """Adds an observation of all bodies; returns the intervals that ended.

        Args:
            step: number of the observation.
            touches: (N,) which bodies may move in this way.
            speed: (N,) along the ground [m/s].
            place: (N, 3) of the contacts [m].
            normal: (N, 3) of the ground there.
            final: whether this is the last observation.
            other: (N,) the things they move on.
        """
        least = np.where(self._first >= 0, self.config.ends, self.config.above)
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
        # A short gap cancels a young interval; only a long one ends a lasting one.
        rest = np.where(self._on, self._ends, MAX_GAP_STEPS)
        over = (self._first >= 0) & ((step - self._last >= rest) | final)
        ended = [self._interval(int(i)) for i in np.flatnonzero(over & self._on)]
        self._first[over], self._on[over] = -1, False
        for i in np.flatnonzero(over).tolist():
            self._way.pop(i, None)
        return ended

    def _interval(self, i: int) -> SlidingInterval:
        x, y, z = self._place[i].tolist()
        a, b, c = self._normal[i].tolist()
        first, last = int(self._first[i]), int(self._last[i])
        speed, other = float(self._speed[i]), int(self._other[i])
        # Without the gap at its end.
        speeds, places = zip(*self._way[i][: last - first + 1], strict=True)
        where = (x, y, z), (a, b, c)
        return SlidingInterval(
            i, self.kind, first, last, *where, speed, other, _bridge_gaps(speeds), places
        )


def _bridge_gaps(speeds: Sequence[float]) -> tuple[float, ...]:
    """Returns speeds in which single observations of zero between two others are interpolated."""
    found, moving = list(speeds), [k for k, speed in enumerate(speeds) if speed > 0.0]
    for a, b in pairwise(moving):
        if 1 < b - a <= MAX_GAP_STEPS + 1:
            for k in range(a + 1, b):
                found[k] = speeds[a] + (speeds[b] - speeds[a]) * (k - a) / (b - a)
    return tuple(found)
