"""Impact law: the spring between two bodies in contact that gives the bounciness asked for.

While they approach, the spring pushes them apart with ω² d at depth d; once they part, with
b² ω² d. What the spring took up it gives back times b², so they part at b times the speed
at which they met, however fast that was and whatever they weigh. A damper instead, as
contacts usually have, gives a ratio that changes with the speed and with how deep the two
were when they were found to touch; b = 0.2 was off by 0.05, see `MEASURED`.

Within the step of length h in which they turn, v < 0 < v + ω² d h, the approach is stopped
and b² of the rest of the push stays: a = -v (1 - b²)/h + b² ω² d. Without that, b = 0 came
out as up to 0.19.

Contacts that began at less than the rest speed, or have lasted longer than a bounce, are
damped critically: what rests does not jitter, however bouncy it is.

Source: Walton and Braun 1986 for springs that are softer on the way back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array

STIFFNESS = 0.25
"""ω h: more is less exact, less costs more steps."""

REST_SPEED = 0.05
"""What comes nearer more slowly does not bounce [m/s]."""

SLAM_SPEED = 0.2
"""Likewise where the two touch already, at another corner [m/s]."""

DULL = 0.05
"""Bounciness below which nothing is given back."""

LONGER = 1.5
"""How long a bounce may last, in its own length by the formula."""

MEASURED = {
    0.0: (0.0, 0.0),
    0.2: (0.199, 0.202),
    0.4: (0.398, 0.403),
    0.6: (0.596, 0.605),
    0.8: (0.796, 0.805),
    0.95: (0.947, 0.954),
    1.0: (0.995, 1.007),
}
"""Bounciness asked for: least and greatest found, of balls and boxes that fall flat at 0.5
to 6 m/s and touch anywhere within a step; `benchmarks/bounciness.py` measures it."""


@dataclass(frozen=True, slots=True)
class Touching:
    """All places at which things touch at one moment.

    Attributes:
        pair: (n,) numbers of the pairs of things, equal for places of one pair.
        bounciness: (n,) of the pairs.
        depth: (n,) how far one is in the other [m].
        speed: (n,) at which they part, negative while they approach [m/s].
    """

    pair: NDArray[np.int64]
    bounciness: Array
    depth: Array
    speed: Array


@dataclass(frozen=True, slots=True)
class Response:
    """What the springs do: an acceleration of stiffness × depth - damping × speed.

    Attributes:
        stiffness: (n,) [1/s²].
        damping: (n,) [1/s].
        struck: places, one a pair, at which a bounce begins.
    """

    stiffness: Array
    damping: Array
    struck: NDArray[np.int64]


class ImpactLaw:
    """Which pairs bounce at the moment, and which rest."""

    def __init__(self) -> None:
        self._pairs = np.zeros(0, dtype=np.int64)
        self._onset = np.zeros(0)

    def respond(self, touching: Touching, time: float, h: float) -> Response:
        """Return what the springs do in a step of `h` [s] from `time` [s] on."""
        w = STIFFNESS / h
        b, v = touching.bounciness, touching.speed
        bounces, struck = self._bouncing(touching, time, w)
        push = w * w * touching.depth
        approaches = v < 0.0
        turns = approaches & (v + push * h > 0.0)
        back = b * b
        springs = bounces & (approaches | (b >= DULL))
        damping = np.where(turns, (1.0 - back) / h, 0.0)
        return Response(
            stiffness=w * w * np.where(springs & (turns | ~approaches), back, 1.0),
            damping=np.where(springs, damping, 2.0 * w),
            struck=struck,
        )

    def _bouncing(
        self, touching: Touching, time: float, w: float
    ) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Return which places (n,) bounce, and the places of bounces that begin."""
        order = np.lexsort((touching.speed, touching.pair))
        pairs = touching.pair[order]
        first = np.flatnonzero(np.r_[True, pairs[1:] != pairs[:-1]])
        # Of each pair the place that approaches fastest stands first.
        quickest, pairs = order[first], pairs[first]
        where = np.minimum(np.searchsorted(self._pairs, pairs), max(len(self._pairs) - 1, 0))
        known = self._pairs[where] == pairs if len(self._pairs) else np.zeros(len(pairs), bool)
        onset = np.full(len(pairs), -np.inf)
        onset[known] = self._onset[where[known]]
        lasts = LONGER * 0.5 * np.pi / w
        b = touching.bounciness[quickest]
        lasts = lasts * (1.0 + 1.0 / np.maximum(b, DULL))
        bounces = time - onset < lasts
        least = np.where(known, SLAM_SPEED, REST_SPEED)
        begins = ~bounces & (-touching.speed[quickest] > least)
        onset[begins] = time
        self._pairs, self._onset = pairs, onset
        each = np.searchsorted(pairs, touching.pair)
        return (bounces | begins)[each], quickest[begins]
