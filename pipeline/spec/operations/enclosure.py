"""Enclosure: whether a point lies inside a closed outline."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from pipeline.spec.operations.sheet import At


def encloses(outline: Sequence[At], point: At) -> bool:
    """Tell whether an outline winds around a point; points on the outline belong to it.

    The angles under which the point sees the outline's corners add up to a whole number of
    turns: none outside. The outline may be concave and may run either way. Where it winds
    around a point twice, as inside a pentagram, the point is inside.

    Args:
        outline: corners [m]; the last is joined to the first.
        point: the point [m].

    Source: Sims 1987, eq. A.1, where each difference of angles must be wrapped into (-π, π]:
    as printed, the sum of differences around a closed outline is always 0.
    """
    x, y = point
    seen = [(a - x, b - y) for a, b in outline]
    total = 0.0
    for (ax, ay), (bx, by) in pairwise([*seen, seen[0]]):
        cross, dot = ax * by - ay * bx, ax * bx + ay * by
        if cross == 0.0 and dot <= 0.0:
            return True
        # The wrapped difference of the two angles, without taking either.
        total += math.atan2(cross, dot)
    return abs(total) > math.pi
