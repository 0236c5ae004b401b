"""Touching: links that come into one another are moved apart, and know what they touch.

Both nodes of a link are moved by the same: torques are left to the links beside it. What two
came nearer to one another in this sub-step is taken out of their positions alone, and so out
of their velocities; what they were in one another before is taken out of both positions, so
that nobody is shot off for having begun inside somebody. All shares go by mass, so momentum
is kept.

Source: Horswill 2008, "Collision handling" and "Tactile sensing". Printed there the second
    pair of nodes moved is k, k; it is k, l. The closest points are those of the segments.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.events import Log, note
from pipeline.simulation.characters.layout import NOBODY, Crowd
from pipeline.simulation.characters.segments import closest
from pipeline.simulation.dynamics.compiled import compiled
from pipeline.simulation.dynamics.vectors import (
    Vector,
    cross,
    dot,
    length,
    minus,
    plus,
    row,
    times,
)

PARTING = 0.6
"""Speed at which what was in one another parts [m/s]."""

LEAST_BOUNCE = 0.25
"""Speed of approach below which nothing bounces [m/s]."""

SKIN = 2e-4
"""How deep what touches may lie: it is still felt as a touch [m]."""

TINY = 1e-9

Sides = tuple[float, float, float]
"""Parts of a move that both nodes of one link make, and both of another; their weight."""


@compiled
def meet(crowd: Crowd, a: int, b: int, h: float, moment: float, log: Log) -> None:
    """Move two links apart if they are in one another.

    Args:
        crowd: the characters.
        a: number of a link.
        b: number of another.
        h: the sub-step [s].
        moment: of the step that has gone.
        log: of what touched.
    """
    p = crowd.p
    i, j, k, m = crowd.ends[a, 0], crowd.ends[a, 1], crowd.ends[b, 0], crowd.ends[b, 1]
    reach = crowd.girth[a] + crowd.girth[b]
    p_i, p_k = row(p, i), row(p, k)
    u, v = minus(row(p, j), p_i), minus(row(p, m), p_k)
    s, t = closest(p_i, u, p_k, v)
    away = minus(plus(p_i, times(s, u)), plus(p_k, times(t, v)))
    squared = dot(away, away)
    if squared >= reach * reach:
        return
    w_a, w_b = _lightness(crowd, a), _lightness(crowd, b)
    if w_a + w_b == 0.0:
        return
    apart = math.sqrt(squared)
    n = times(1.0 / apart, away) if apart > TINY else _aside(crowd, a, b, u, v)
    depth = reach - apart
    moved_a = _moved(crowd, i, j, s)
    moved_b = _moved(crowd, k, m, t)
    slip = minus(moved_a, moved_b)
    nearer = -dot(slip, n)
    share = 1.0 / (w_a + w_b)
    _sense(crowd, a, b, nearer / h, share, moment, log, plus(p_k, times(t, v)), n)
    stopped = min(depth, max(nearer, 0.0))
    parted = min(depth - stopped, PARTING * h)
    along = minus(slip, times(dot(slip, n), n))
    size = length(along)
    friction = 0.5 * (_friction(crowd, a) + _friction(crowd, b)) * stopped
    rub = times(-min(friction / size, 1.0), along) if size > TINY else (0.0, 0.0, 0.0)
    move = plus(times(stopped, n), rub)
    back = 0.0
    if nearer > LEAST_BOUNCE * h:
        back = _bounciness(crowd, a, b) * nearer + nearer - stopped
    _shift(crowd, a, times(share * w_a, move), times(share * w_a * parted, n), share * w_a * back, n)
    _shift(
        crowd, b, times(-share * w_b, move), times(-share * w_b * parted, n), -share * w_b * back, n
    )


@compiled
def _lightness(crowd: Crowd, a: int) -> float:
    """Return the inverse mass of a link that is moved as a whole, of what of it can move."""
    i, j = crowd.ends[a, 0], crowd.ends[a, 1]
    g_i, g_j = crowd.give[i], crowd.give[j]
    if i == j or g_j == 0.0:
        return g_i
    return g_j if g_i == 0.0 else g_i * g_j / (g_i + g_j)


@compiled
def _moved(crowd: Crowd, i: int, j: int, s: float) -> Vector:
    """Return how far a place on a link went in this sub-step."""
    one = minus(row(crowd.p, i), row(crowd.before, i))
    other = minus(row(crowd.p, j), row(crowd.before, j))
    return plus(times(1.0 - s, one), times(s, other))


@compiled
def _aside(crowd: Crowd, a: int, b: int, u: Vector, v: Vector) -> Vector:
    """Return a direction from link b to link a, whose axes cross."""
    n = cross(u, v)
    size = length(n)
    if size < TINY:
        return (0.0, 1.0, 0.0)
    n = times(1.0 / size, n)
    one, other = crowd.owners[crowd.link_owner[a]], crowd.owners[crowd.link_owner[b]]
    towards = 0.0
    for k in range(3):
        towards += n[k] * (one.low[k] + one.high[k] - other.low[k] - other.high[k])
    return n if towards >= 0.0 else times(-1.0, n)


@compiled
def _friction(crowd: Crowd, a: int) -> float:
    mu: float = crowd.owners[crowd.link_owner[a]].friction
    return mu


@compiled
def _bounciness(crowd: Crowd, a: int, b: int) -> float:
    one: float = crowd.owners[crowd.link_owner[a]].bounciness
    other: float = crowd.owners[crowd.link_owner[b]].bounciness
    return max(one, other)


@compiled
def _shift(crowd: Crowd, a: int, move: Vector, part: Vector, back: float, n: Vector) -> None:
    """Move a link as a whole.

    Args:
        crowd: the characters.
        a: number of the link.
        move: what changes its velocity.
        part: what does not.
        back: how far it is to go along n in a sub-step, beyond what `move` makes of it.
        n: a direction.
    """
    i, j = crowd.ends[a, 0], crowd.ends[a, 1]
    for end in range(1 if i == j else 2):
        node = i if end == 0 else j
        if crowd.give[node] == 0.0:
            continue
        for k in range(3):
            crowd.p[node, k] += move[k] + part[k]
            crowd.before[node, k] += part[k] - back * n[k]


@compiled
def _sense(
    crowd: Crowd,
    a: int,
    b: int,
    speed: float,
    mass: float,
    moment: float,
    log: Log,
    place: Vector,
    n: Vector,
) -> None:
    """Let two links know of one another."""
    energy = 0.5 * mass * max(speed, 0.0) ** 2
    other = crowd.link_owner[b]
    if crowd.link_owner[a] == other:
        return
    # Both have been apart for a while, or it is another that is touched now.
    new = crowd.touched_owner[a] != other or crowd.age[a, 0] > log.pause
    if new and speed > log.above:
        note(log, moment, a, b, place, n, speed, energy)
    for one, two in ((a, b), (b, a)):
        if crowd.age[one, 0] > 0.0 or energy > crowd.energy[one]:
            crowd.touched[one], crowd.touched_owner[one] = two, crowd.link_owner[two]
        crowd.energy[one] = max(crowd.energy[one], energy)
        crowd.age[one, 0] = 0.0


@compiled
def grow_old(crowd: Crowd, log: Log, h: float) -> None:
    """Forget touches that have ended, a sub-step later."""
    for a in range(len(crowd.age)):
        crowd.age[a, 0] += h
        crowd.age[a, 1] += h
        if crowd.age[a, 0] > log.pause:
            crowd.touched[a], crowd.touched_owner[a] = NOBODY, NOBODY
