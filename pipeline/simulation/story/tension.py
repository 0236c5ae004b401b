"""Tension: the one that a story wants over the film, and the one that its beats give."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from pipeline.simulation.spatial import Array

RESPONSE_TIME = 1.5
"""Time in which the tension goes 63 % of the way to that of the present beat [s]."""

Curve = Sequence[tuple[float, float]]
"""Times [s], ascending, and tensions from 0 to 1."""


def wanted_tension(curve: Curve, time: float) -> float | None:
    """Returns the wanted tension at a time [s], None without a curve."""
    if not curve:
        return None
    times, values = zip(*curve, strict=True)
    return float(np.interp(time, times, values))


def played_tension(beats: Iterable[tuple[float, float]], start: float, times: Array) -> Array:
    """Returns the tension (K,) that beats give: it follows that of the latest beat with a lag.

    Args:
        beats: the beginning [s] and the tension of each, in the order of time.
        start: tension at the start of the film.
        times: (K,) ascending [s].
    """
    values = np.full(len(times), start)
    begun, level, target = 0.0, start, start
    for time, tension in beats:
        level = target + (level - target) * math.exp(-(time - begun) / RESPONSE_TIME)
        begun, target = time, tension
        later = times >= time
        decay = np.exp(-(times[later] - time) / RESPONSE_TIME)
        values[later] = target + (level - target) * decay
    return values
