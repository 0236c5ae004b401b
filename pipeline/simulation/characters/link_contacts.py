"""Link contacts: links that overlap are moved apart, and sense one another.

Both nodes of a link move by the same: torques are left to the links beside it. Edges of boxes are
pushed where they touch, for a box is one piece that leans on another, and so are links with one
end held, such as a shin on a standing foot: they turn about that end.

Source: Horswill 2008, "Collision handling" and "Tactile sensing". Printed there the second
    pair of nodes moved is k, k; it is k, l. The normal printed there, the cross product of the
    two axes, holds only where the closest points lie inside both links, and for parallel links
    nowhere: the normal is the direction between the closest points (Ericson 2005, 5.1.9).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pipeline.simulation.characters.body_arrays import LOCKED
from pipeline.simulation.characters.contact_response import (
    MIN_BOUNCE_SPEED,
    TINY,
    SubStep,
    TouchLog,
    damp_resting,
    friction_move,
    move_between,
    move_node,
    support_factor,
    touch_links,
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

POINT = 1e-12  # squared length below which a segment is a point [m²]
PARALLEL = 1e-9  # squared sine of the angle between parallel segments
TANGLE_DEPTH = 0.003  # of links of one character that tire of parting [m]
WEDGE_DEPTH = 0.003  # of a link in another one beyond which it pushes its locked end [m]
STRETCH_MARGIN = 0.1  # by which a link may be too long, in its length
BACK_SLOPE = 2.0  # of the share of a back in a direction, by the cosine of its turn off the back
MIN_LEVER = 0.2  # from a held end, in the link's length: nearer the other end would go too far


class Overlap(NamedTuple):
    """An overlap of two links.

    Attributes:
        s: fraction along the first link.
        t: fraction along the second link.
        place: on the axis of the second link [m].
        n: normal towards the first link.
        depth: [m].
    """

    s: float
    t: float
    place: Vector
    n: Vector
    depth: float


Moves = tuple[Vector, Vector, Vector]
"""Moves of position and velocity, of position alone, of velocity alone; see `move_node` [m]."""


@inlined
def closest_points(p: Vector, u: Vector, q: Vector, v: Vector) -> tuple[float, float]:
    """Return (s, t) so that p + s u and q + t v are nearest, for s and t from 0 to 1.

    For parallel segments that run beside one another it is the middle of the shared stretch.
    """
    r = minus(p, q)
    a, e, f = dot(u, u), dot(v, v), dot(v, r)
    if a <= POINT:
        return 0.0, 0.0 if e <= POINT else _clamped(f / e)
    c = dot(u, r)
    if e <= POINT:
        return _clamped(-c / a), 0.0
    b = dot(u, v)
    denominator = a * e - b * b
    if denominator <= PARALLEL * a * e:
        # Both ends of v along u: the middle of the shared stretch.
        one, other = -c / a, (b - c) / a
        low, high = min(one, other), max(one, other)
        s = _clamped(0.5 * (max(low, 0.0) + min(high, 1.0)))
    else:
        s = _clamped((b * f - c * e) / denominator)
    t = (b * s + f) / e
    if t < 0.0:
        return _clamped(-c / a), 0.0
    if t > 1.0:
        return _clamped((b - c) / a), 1.0
    return s, t


@inlined
def _clamped(s: float) -> float:
    return min(max(s, 0.0), 1.0)


@inlined
def may_touch(nodes: Records, one: Record, other: Record) -> bool:
    """Tell whether the middles of two links are near enough for a contact."""
    p, q = nodes[one.ends[0]].p, nodes[one.ends[1]].p
    r, s = nodes[other.ends[0]].p, nodes[other.ends[1]].p
    squared = 0.0
    for k in range(3):
        offset = 0.5 * (p[k] + q[k] - r[k] - s[k])
        squared += offset * offset
    lengths = one.length_limits[0] + other.length_limits[0]
    reach = one.radius + other.radius + 0.5 * lengths * (1.0 + STRETCH_MARGIN)
    return squared < reach * reach


@inlined
def separate_links(
    nodes: Records,
    links: Records,
    owners: Records,
    pair: tuple[int, int],
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Move a pair of links apart if they overlap."""
    a, b = links[pair[0]], links[pair[1]]
    p, q = triple(nodes[a.ends[0]].p), triple(nodes[b.ends[0]].p)
    u, v = minus(triple(nodes[a.ends[1]].p), p), minus(triple(nodes[b.ends[1]].p), q)
    s, t = closest_points(p, u, q, v)
    place = plus(q, times(t, v))
    offset = minus(plus(p, times(s, u)), place)
    squared = dot(offset, offset)
    reach = a.radius + b.radius
    if squared >= reach * reach:
        return
    one, other = owners[a.owner], owners[b.owner]
    distance = math.sqrt(squared)
    n = times(1.0 / distance, offset) if distance > TINY else _crossing_normal(one, other, u, v)
    if _lies_around(one, a, b):
        reach -= (b.radius - b.embraced_radius) * _behind(nodes, one, other, n)
    elif _lies_around(other, b, a):
        reach -= (a.radius - a.embraced_radius) * _behind(nodes, other, one, times(-1.0, n))
    if distance >= reach:
        return
    boxes = one.edge_radius > 0.0 and other.edge_radius > 0.0
    if boxes and _points_inward(one, other, n):
        # Edges that have gone through one another are moved back through.
        distance, n = -distance, times(-1.0, n)
        if -distance > 0.5 * reach:
            return
    overlap = Overlap(s, t, place, n, reach - distance)
    _separate(nodes, links, owners, pair, overlap, sub_step, log)


@inlined
def _lies_around(owner: Record, link: Record, other: Record) -> bool:
    """Tell whether a link is an arm of an owner that embraces the owner of another link."""
    return bool(link.is_arm) and owner.embraces == other.owner


@inlined
def _behind(nodes: Records, one: Record, other: Record, n: Vector) -> float:
    """Return how far a direction points to the back of the second of two owners, 0 to 1."""
    here, there = nodes[one.nodes[0]].p, nodes[other.nodes[0]].p
    x, z = there[0] - here[0], there[2] - here[2]
    return min(max(BACK_SLOPE * (n[0] * x + n[2] * z) / max(math.hypot(x, z), TINY), 0.0), 1.0)


@inlined
def _separate(
    nodes: Records,
    links: Records,
    owners: Records,
    pair: tuple[int, int],
    overlap: Overlap,
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Move two overlapping links apart, with friction, and let them sense one another."""
    a, b = links[pair[0]], links[pair[1]]
    one, other = owners[a.owner], owners[b.owner]
    h, slack, moment = sub_step
    s, t, place, n, depth = overlap
    boxes = one.edge_radius > 0.0 and other.edge_radius > 0.0
    slip = minus(
        move_between(nodes[a.ends[0]], nodes[a.ends[1]], s),
        move_between(nodes[b.ends[0]], nodes[b.ends[1]], t),
    )
    approach = -dot(slip, n)
    wake_touching(nodes, one, other, depth, approach / h)
    turns_a, turns_b = boxes or _is_hinged(nodes, a), boxes or _is_hinged(nodes, b)
    w_a, w_b = _mobility(nodes, a, s, turns_a), _mobility(nodes, b, t, turns_b)
    kept_a = support_factor(nodes[a.ends[0]], nodes[a.ends[1]], n[1], w_a, w_b)
    kept_b = support_factor(nodes[b.ends[0]], nodes[b.ends[1]], -n[1], w_b, w_a)
    w_a, w_b = kept_a * w_a, kept_b * w_b
    if w_a + w_b == 0.0:
        return
    share = 1.0 / (w_a + w_b)
    if a.owner != b.owner:
        speed = max(approach, 0.0) / h
        touch_links(links, pair, (place, n), speed, 0.5 * share * speed * speed, moment, log)
    one.penetration, other.penetration = max(one.penetration, depth), max(other.penetration, depth)
    stopped = min(depth, max(approach, 0.0))
    if a.owner == b.owner:
        one.self_penetrating = one.self_penetrating or depth > TANGLE_DEPTH
        slack = slack * max(1.0 - one.tangled_time / UNTANGLE_TIME, 0.0)
    parted = min(depth - stopped, slack)
    friction = friction_move(slip, n, 0.5 * (one.friction + other.friction) * stopped)
    move = plus(times(stopped, n), friction)
    back = 0.0
    bounciness = max(one.bounciness, other.bounciness)
    if bounciness > 0.0 and approach > MIN_BOUNCE_SPEED * h:
        back = bounciness * approach + approach - stopped
    moves = times(share, move), times(share * parted, n), times(share * back, n)
    _move_link(nodes, a, s, turns_a, (kept_a, w_a), moves)
    _move_link(nodes, b, t, turns_b, (-kept_b, -w_b), moves)
    if a.owner != b.owner:
        _damp_and_push(nodes, a, one, depth, n, approach / h)
        _damp_and_push(nodes, b, other, -depth, n, approach / h)


@inlined
def _damp_and_push(
    nodes: Records, link: Record, owner: Record, depth: float, n: Vector, speed: float
) -> None:
    """Damp both ends of a touching link, and push a locked one by half of the overlap [m].

    An almost straight leg moves nowhere beside a standing foot but with its whole owner.
    """
    for end in range(2):
        node = nodes[link.ends[end]]
        damp_resting(node, owner, speed)
        if node.lock == LOCKED and abs(depth) > WEDGE_DEPTH:
            for k in range(3):
                node.contact_push[k] = 0.5 * depth * n[k]


@inlined
def _is_hinged(nodes: Records, link: Record) -> bool:
    return (nodes[link.ends[0]].mobility == 0.0) != (nodes[link.ends[1]].mobility == 0.0)


@inlined
def _mobility(nodes: Records, link: Record, s: float, turns: bool) -> float:
    """Return the inverse mass of a link, at the place s on it if it turns [1/kg]."""
    one: float = nodes[link.ends[0]].mobility
    other: float = nodes[link.ends[1]].mobility
    if turns:
        return max((1.0 - s) ** 2 * one + s * s * other, MIN_LEVER * MIN_LEVER * max(one, other))
    if link.ends[0] == link.ends[1] or one + other == 0.0:
        return one
    return one * other / (one + other)


@inlined
def _crossing_normal(one: Record, other: Record, u: Vector, v: Vector) -> Vector:
    """Return the direction towards one character for links whose axes u and v cross."""
    n = cross(u, v)
    size = length(n)
    if size < TINY:
        return (0.0, 1.0, 0.0)
    n = times(1.0 / size, n)
    return times(-1.0, n) if _points_inward(one, other, n) else n


@inlined
def _points_inward(one: Record, other: Record, n: Vector) -> bool:
    """Tell whether a direction points from the middle of one character to that of the other."""
    towards = 0.0
    for k in range(3):
        towards += n[k] * (one.low[k] + one.high[k] - other.low[k] - other.high[k])
    return towards < 0.0


@inlined
def _move_link(
    nodes: Records,
    link: Record,
    s: float,
    turns: bool,
    shares: tuple[float, float],
    moves: Moves,
) -> None:
    """Turn a link at the place s on it by the first share, or shift it by the second.

    Edges moved as wholes would turn two leaning boxes about one another for ever, out of nothing.
    A link held at one end would lose most of a push that went by its other end.
    """
    if turns:
        for end in range(2):
            node = nodes[link.ends[end]]
            share = shares[0] * node.mobility * (s if end == 1 else 1.0 - s)
            move_node(node, share, moves[0], moves[1], moves[2])
    else:
        for end in range(1 if link.ends[0] == link.ends[1] else 2):
            move_node(nodes[link.ends[end]], shares[1], moves[0], moves[1], moves[2])
