"""Segments: where two of them are nearest.

Source: Ericson 2005, 5.1.9. The normal printed by Horswill 2008, the cross product of the two
    axes, holds only where the closest points lie inside both links, and for parallel links
    nowhere: the normal is the direction from one closest point to the other.
"""

from __future__ import annotations

from pipeline.simulation.dynamics.compiled import inlined
from pipeline.simulation.dynamics.vectors import Vector, dot, minus

POINT = 1e-12
"""Squared length below which a segment is a point [m²]."""

PARALLEL = 1e-9
"""Squared sine of the angle between segments that are parallel."""


@inlined
def closest(p: Vector, u: Vector, q: Vector, v: Vector) -> tuple[float, float]:
    """Return (s, t) so that p + s u and q + t v are nearest, for s and t from 0 to 1.

    Of parallel segments that run beside one another it is the middle of where they do.
    """
    r = minus(p, q)
    a, e, f = dot(u, u), dot(v, v), dot(v, r)
    if a <= POINT:
        return 0.0, 0.0 if e <= POINT else _within(f / e)
    c = dot(u, r)
    if e <= POINT:
        return _within(-c / a), 0.0
    b = dot(u, v)
    denominator = a * e - b * b
    if denominator <= PARALLEL * a * e:
        # Both ends of v, seen along u: the middle of what they share with it.
        one, other = -c / a, (b - c) / a
        low, high = min(one, other), max(one, other)
        s = _within(0.5 * (max(low, 0.0) + min(high, 1.0)))
    else:
        s = _within((b * f - c * e) / denominator)
    t = (b * s + f) / e
    if t < 0.0:
        return _within(-c / a), 0.0
    if t > 1.0:
        return _within((b - c) / a), 1.0
    return s, t


@inlined
def _within(s: float) -> float:
    """Return the nearest from 0 to 1."""
    return min(max(s, 0.0), 1.0)
