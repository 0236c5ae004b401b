"""Link contacts."""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import LOCKED
from pipeline.simulation.characters.contact_response import (
    ABOVE,
    LEAST_BOUNCE,
    PAUSE,
    TINY,
    TouchLog,
    borne,
    log_touch,
    rub,
    rubbed,
    sense,
)
from pipeline.simulation.characters.sleep_states import UNTANGLE_TIME, wake_touching
from pipeline.simulation.dynamics.compiled import Record, Records, inlined
from pipeline.simulation.dynamics.vectors import (
    Vector,
    cross,
    dot,
    length,
    minus,
    plus,
    times,
    triple,
)

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


KNOT = 0.003
"""How deep links of one character are in one another that tire of parting [m]."""

WEDGED = 0.003
"""How deep in somebody a link is that stands in the way of being parted by where it is held [m]."""

SPARE = 0.1
"""Part of its length that a link may be longer than it should."""

LEVER = 0.2
"""How far from an end that is held a link is pushed at least, of its length: the nearer, the
farther its other end would have to go."""

Moves = tuple[Vector, Vector, Vector]
"""What changes a place and its velocity, what the place alone, and what the velocity alone [m]."""


@inlined
def are_near(nodes: Records, one: Record, other: Record) -> bool:
    """Tell whether the middles of two links are near enough that they may touch."""
    p, q = nodes[one.ends[0]].p, nodes[one.ends[1]].p
    r, s = nodes[other.ends[0]].p, nodes[other.ends[1]].p
    squared = 0.0
    for k in range(3):
        away = 0.5 * (p[k] + q[k] - r[k] - s[k])
        squared += away * away
    reach = (
        one.radius
        + other.radius
        + 0.5 * (one.length_limits[0] + other.length_limits[0]) * (1.0 + SPARE)
    )
    near: bool = squared < reach * reach
    return near


@inlined
def meet(
    nodes: Records,
    links: Records,
    owners: Records,
    pair: tuple[int, int],
    h: float,
    slack: float,
    moment: float,
    log: TouchLog,
) -> None:
    """Move two links apart if they are in one another.

    Args:
        nodes: of all characters.
        links: of all characters.
        owners: all characters.
        pair: numbers of two links.
        h: the sub-step [s].
        slack: how far what was in one another may part [m].
        moment: of the step that has gone.
        log: of what touched.
    """
    a, b = links[pair[0]], links[pair[1]]
    p, q = triple(nodes[a.ends[0]].p), triple(nodes[b.ends[0]].p)
    u, v = minus(triple(nodes[a.ends[1]].p), p), minus(triple(nodes[b.ends[1]].p), q)
    s, t = closest(p, u, q, v)
    place = plus(q, times(t, v))
    away = minus(plus(p, times(s, u)), place)
    squared = dot(away, away)
    reach = a.radius + b.radius
    if squared >= reach * reach:
        return
    one, other = owners[a.owner], owners[b.owner]
    apart = math.sqrt(squared)
    n = times(1.0 / apart, away) if apart > TINY else _aside(one, other, u, v)
    boxes = one.edge_radius > 0.0 and other.edge_radius > 0.0
    if boxes and _points_in(one, other, n):
        # Edges that have gone through one another are moved back through.
        apart, n = -apart, times(-1.0, n)
        if -apart > 0.5 * reach:
            return
    slip = minus(_moved(nodes, a, s), _moved(nodes, b, t))
    nearer = -dot(slip, n)
    depth = reach - apart
    wake_touching(nodes, one, other, depth, nearer / h)
    turns_a, turns_b = boxes or _is_hinged(nodes, a), boxes or _is_hinged(nodes, b)
    w_a, w_b = _lightness(nodes, a, s, turns_a), _lightness(nodes, b, t, turns_b)
    light_a = borne(nodes[a.ends[0]], nodes[a.ends[1]], n[1], w_a, w_b)
    light_b = borne(nodes[b.ends[0]], nodes[b.ends[1]], -n[1], w_b, w_a)
    w_a, w_b = light_a * w_a, light_b * w_b
    if w_a + w_b == 0.0:
        return
    share = 1.0 / (w_a + w_b)
    if a.owner != b.owner:
        _feel(links, pair, (place, n), max(nearer, 0.0) / h, share, moment, log)
    one.penetration, other.penetration = max(one.penetration, depth), max(other.penetration, depth)
    stopped = min(depth, max(nearer, 0.0))
    if a.owner == b.owner:
        slack = _untangled(one, depth, slack)
    parted = min(depth - stopped, slack)
    move = plus(times(stopped, n), rubbed(slip, n, 0.5 * (one.friction + other.friction) * stopped))
    back = 0.0
    bounciness = max(one.bounciness, other.bounciness)
    if bounciness > 0.0 and nearer > LEAST_BOUNCE * h:
        back = bounciness * nearer + nearer - stopped
    moves = times(share, move), times(share * parted, n), times(share * back, n)
    _give_way(nodes, a, s, turns_a, (light_a, w_a), moves)
    _give_way(nodes, b, t, turns_b, (-light_b, -w_b), moves)
    if a.owner != b.owner:
        _press(nodes, a, depth, n)
        _press(nodes, b, -depth, n)
        _rub(nodes, a, one, nearer / h)
        _rub(nodes, b, other, nearer / h)


@inlined
def _press(nodes: Records, link: Record, depth: float, n: Vector) -> None:
    """Let an end that is locked know that the link is so deep in somebody [m], half of it its own.

    A leg that is almost straight moves nowhere beside a foot that stands but with all of its
    owner.
    """
    if abs(depth) <= WEDGED:
        return
    for end in range(2):
        node = nodes[link.ends[end]]
        if node.lock == LOCKED:
            for k in range(3):
                node.contact_push[k] = 0.5 * depth * n[k]


@inlined
def _untangled(owner: Record, depth: float, slack: float) -> float:
    """Return how far two links of one character may part that are so deep in one another [m]."""
    owner.self_penetrating = owner.self_penetrating or depth > KNOT
    left: float = slack * max(1.0 - owner.tangled_time / UNTANGLE_TIME, 0.0)
    return left


@inlined
def _feel(
    links: Records,
    pair: tuple[int, int],
    where: tuple[Vector, Vector],
    speed: float,
    mass: float,
    moment: float,
    log: TouchLog,
) -> None:
    """Let two links of two characters know of one another."""
    a, b = links[pair[0]], links[pair[1]]
    energy = 0.5 * mass * speed * speed
    # Both have been apart for a while, or it is another that is touched now.
    new = a.touched_owner != b.owner or a.age[0] > PAUSE
    if new and speed > ABOVE:
        log_touch(log, moment, pair, where[0], where[1], (speed, energy))
    sense(a, pair[1], b.owner, energy)
    sense(b, pair[0], a.owner, energy)


@inlined
def _rub(nodes: Records, link: Record, owner: Record, speed: float) -> None:
    """Let both ends of a link that touches gently be damped."""
    for k in range(2):
        rub(nodes[link.ends[k]], owner, speed)


@inlined
def _is_hinged(nodes: Records, link: Record) -> bool:
    """Tell whether one end of a link is held, and not the other."""
    hinged: bool = (nodes[link.ends[0]].mobility == 0.0) != (nodes[link.ends[1]].mobility == 0.0)
    return hinged


@inlined
def _lightness(nodes: Records, link: Record, s: float, there: bool) -> float:
    """Return the inverse mass of a link, of what of it can move.

    Args:
        nodes: of all characters.
        link: which.
        s: where on it.
        there: whether it is moved there, and not as a whole.
    """
    one: float = nodes[link.ends[0]].mobility
    other: float = nodes[link.ends[1]].mobility
    if there:
        return max((1.0 - s) ** 2 * one + s * s * other, LEVER * LEVER * max(one, other))
    if link.ends[0] == link.ends[1] or one + other == 0.0:
        return one
    return one * other / (one + other)


@inlined
def _moved(nodes: Records, link: Record, s: float) -> Vector:
    """Return how far a place on a link went in this sub-step."""
    one, other = nodes[link.ends[0]], nodes[link.ends[1]]
    a = minus(triple(one.p), triple(one.previous))
    b = minus(triple(other.p), triple(other.previous))
    return plus(times(1.0 - s, a), times(s, b))


@inlined
def _aside(one: Record, other: Record, u: Vector, v: Vector) -> Vector:
    """Return a direction from the other to one, whose links' axes cross."""
    n = cross(u, v)
    size = length(n)
    if size < TINY:
        return (0.0, 1.0, 0.0)
    n = times(1.0 / size, n)
    return times(-1.0, n) if _points_in(one, other, n) else n


@inlined
def _points_in(one: Record, other: Record, n: Vector) -> bool:
    """Tell whether a direction points from the middle of one to that of the other."""
    towards = 0.0
    for k in range(3):
        towards += n[k] * (one.low[k] + one.high[k] - other.low[k] - other.high[k])
    return towards < 0.0


@inlined
def _give_way(
    nodes: Records,
    link: Record,
    s: float,
    turns: bool,
    shares: tuple[float, float],
    moves: Moves,
) -> None:
    """Turn or shift a link, by the first or the second share."""
    if turns:
        _turn(nodes, link, s, shares[0], moves)
    else:
        _shift(nodes, link, shares[1], moves)


@inlined
def _shift(nodes: Records, link: Record, share: float, moves: Moves) -> None:
    """Move a link as a whole, by a share of what is told: of none if it is held."""
    for end in range(1 if link.ends[0] == link.ends[1] else 2):
        node = nodes[link.ends[end]]
        for k in range(3):
            node.p[k] += share * (moves[0][k] + moves[1][k])
            node.previous[k] += share * (moves[1][k] - moves[2][k])


@inlined
def _turn(nodes: Records, link: Record, s: float, share: float, moves: Moves) -> None:
    """Move a link at a place s on it, by a share of what `_shift` is told.

    Edges that were moved as wholes would turn two boxes about one another out of nothing, for
    ever if one leans on the other. What is held at one end and pushed beside it would lose most
    of a push that went by its other end.
    """
    for end in range(2):
        node = nodes[link.ends[end]]
        some = share * node.mobility * (s if end == 1 else 1.0 - s)
        for k in range(3):
            node.p[k] += some * (moves[0][k] + moves[1][k])
            node.previous[k] += some * (moves[1][k] - moves[2][k])
