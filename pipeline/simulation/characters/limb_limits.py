"""Limb limits."""

from __future__ import annotations

import math

from pipeline.simulation.characters.contact_response import BORNE
from pipeline.simulation.dynamics.compiled import Record, Records, inlined
from pipeline.simulation.dynamics.vectors import (
    Vector,
    cross,
    dot,
    length,
    minus,
    plus,
    set_triple,
    times,
    triple,
)

TINY = 1e-9
"""A length that is none [m]."""

SHORT = 0.996
"""Part of its length that a link may be pressed to."""

LIFTS = 1.5e-3
"""How far a joint that would be pressed into the ground lifts its limb instead, each time [m]."""

BACK = 0.05
"""Cosine below which a turn has no shortest way."""


@inlined
def straighten(nodes: Records, limb: Record) -> None:
    """Turn a limb back into its cone, and its joint back towards where it may point."""
    x, y, z = trunk(nodes, limb)
    root, tip = triple(nodes[limb.root].p), triple(nodes[limb.tip].p)
    along = minus(tip, root)
    far = length(along)
    if far < TINY:
        return
    d = times(1.0 / far, along)
    m = _world(limb.middle, x, y, z)
    if dot(d, m) < limb.cone:
        # The nearest direction in the cone; tip and joint go there, root and trunk push back.
        aside = minus(m, times(dot(m, d), d))
        size = length(aside)
        if size > TINY:
            angle = math.acos(max(dot(d, m), -1.0)) - math.acos(limb.cone)
            _push(nodes, limb, times(far * min(angle, 0.2) / size, aside))
            return
    e, size, _ = _elbow(nodes, limb, d)
    wanted = _allowed(limb, e, d, m, x, y, z)
    if dot(wanted, e) < 1.0 - 1e-12:
        _swing(nodes, limb, times(size, minus(wanted, e)))


@inlined
def settle(nodes: Records, limb: Record) -> None:
    """Put a joint where both links have their lengths and it points where it may."""
    if nodes[limb.joint].give == 0.0:
        return
    x, y, z = trunk(nodes, limb)
    root, along = (
        triple(nodes[limb.root].p),
        minus(triple(nodes[limb.tip].p), triple(nodes[limb.root].p)),
    )
    far = length(along)
    if far < TINY:
        return
    d = times(1.0 / far, along)
    e, _, _ = _elbow(nodes, limb, d)
    wanted = _allowed(limb, e, d, _world(limb.middle, x, y, z), x, y, z)
    upper, lower = limb.upper, limb.lower
    if far >= upper + lower:
        # It is stretched: both links have their share of it.
        _put(nodes[limb.joint], plus(root, times(upper / (upper + lower), along)))
        return
    a = (upper * upper - lower * lower + far * far) / (2.0 * far)
    out = math.sqrt(max(upper * upper - a * a, 0.0))
    # What presses on a joint may press it nearer to straight, and so root and tip apart.
    least = math.sqrt(max((SHORT * upper) ** 2 - a * a, 0.0))
    out = min(max(dot(minus(triple(nodes[limb.joint].p), root), wanted), least), out)
    _put(nodes[limb.joint], plus(root, plus(times(a, d), times(out, wanted))))


@inlined
def bend(nodes: Records, limb: Record) -> float:
    """Return how far a joint is bent [rad], negative if it points where it may not."""
    x, y, z = trunk(nodes, limb)
    root, joint, tip = (
        triple(nodes[limb.root].p),
        triple(nodes[limb.joint].p),
        triple(nodes[limb.tip].p),
    )
    upper, lower = minus(joint, root), minus(tip, joint)
    angle = math.atan2(length(cross(upper, lower)), dot(upper, lower))
    along = minus(tip, root)
    d = times(1.0 / max(length(along), TINY), along)
    e, _, _ = _elbow(nodes, limb, d)
    wanted = _allowed(limb, e, d, _world(limb.middle, x, y, z), x, y, z)
    return angle if dot(wanted, e) > 1.0 - 1e-6 else -angle


@inlined
def trunk(nodes: Records, limb: Record) -> tuple[Vector, Vector, Vector]:
    """Return the axes of the trunk that a limb hangs on: forward, up, and to the right."""
    right = minus(triple(nodes[limb.right].p), triple(nodes[limb.left].p))
    up = minus(triple(nodes[limb.high].p), triple(nodes[limb.low].p))
    forward = cross(up, right)
    size = length(forward)
    if size < TINY:
        return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    x = times(1.0 / size, forward)
    y = times(1.0 / max(length(up), TINY), up)
    return x, y, cross(x, y)


@inlined
def _world(a: Vector, x: Vector, y: Vector, z: Vector) -> Vector:
    """Return a vector of the trunk's frame in the world."""
    return plus(plus(times(a[0], x), times(a[1], y)), times(a[2], z))


@inlined
def _elbow(nodes: Records, limb: Record, d: Vector) -> tuple[Vector, float, float]:
    """Return where the joint points across a unit vector d from root to tip.

    Returns:
        The direction, zero for a straight limb; how far it is from the line [m]; and how far
        along [m].
    """
    off = minus(triple(nodes[limb.joint].p), triple(nodes[limb.root].p))
    along = dot(off, d)
    aside = minus(off, times(along, d))
    size = length(aside)
    if size < TINY:
        return (0.0, 0.0, 0.0), 0.0, along
    return times(1.0 / size, aside), size, along


@inlined
def _allowed(
    limb: Record, e: Vector, d: Vector, m: Vector, x: Vector, y: Vector, z: Vector
) -> Vector:
    """Return the direction nearest to e, across d, in which the joint may point."""
    c = _turned(_world(limb.bend, x, y, z), m, d)
    if dot(e, e) == 0.0:
        return c
    ahead = dot(e, c)
    if ahead >= limb.spread[0]:
        return e
    side = cross(d, c)
    aside = limb.spread[1] if dot(e, side) >= 0.0 else -limb.spread[1]
    return plus(times(limb.spread[0], c), times(aside, side))


@inlined
def _turned(c: Vector, m: Vector, d: Vector) -> Vector:
    """Return c, across m, turned by the shortest turn from m to d.

    R c = c - (d · c) (m + d) / (1 + m · d) for unit m and d, and c across m.
    """
    share = dot(d, c) / max(1.0 + dot(m, d), BACK)
    turned = minus(c, times(share, plus(m, d)))
    # Nearly opposite to the middle the turn is no longer one: across d all the same.
    turned = minus(turned, times(dot(turned, d), d))
    return times(1.0 / max(length(turned), TINY), turned)


@inlined
def _put(node: Record, place: Vector) -> None:
    _move(node, minus(place, triple(node.p)))


@inlined
def _push(nodes: Records, limb: Record, way: Vector) -> None:
    """Move tip and joint against the root so that they come so much nearer to one another."""
    root, joint, tip = nodes[limb.root], nodes[limb.joint], nodes[limb.tip]
    # Half of the way for the joint, which lies about half as far out; the root takes on what
    # the two are given.
    weight = tip.give + 0.25 * joint.give + 2.25 * root.give
    if weight == 0.0:
        return
    share = 1.0 / weight
    _move(tip, times(share * tip.give, way))
    _move(joint, times(0.5 * share * joint.give, way))
    _move(root, times(-1.5 * share * root.give, way))


@inlined
def _swing(nodes: Records, limb: Record, way: Vector) -> None:
    """Move the joint by `way` against root and tip, which take on half each."""
    root, joint, tip = nodes[limb.root], nodes[limb.joint], nodes[limb.tip]
    size = length(way)
    lifted = min(LIFTS / size, 1.0) if way[1] < 0.0 and joint.grounded > 0.0 else 0.0
    for k in range(2):
        # What lies on the ground is borne by it: root and tip rise instead, but not at a jerk.
        a = joint.give * (BORNE if k == 1 else 1.0)
        weight = a + 0.25 * (root.give + tip.give)
        share = (lifted if k == 1 else 1.0 - lifted) / weight if weight > 0.0 else 0.0
        if share > 0.0:
            _move(joint, times(share * a, way))
            _move(root, times(-0.5 * share * root.give, way))
            _move(tip, times(-0.5 * share * tip.give, way))


@inlined
def _move(node: Record, way: Vector) -> None:
    """Move a node so that this stops what it does against it, and gives it no speed."""
    went = minus(triple(node.p), triple(node.before))
    against, squared = -dot(went, way), dot(way, way)
    if squared == 0.0:
        return
    stopped = min(max(against / squared, 0.0), 1.0)
    set_triple(node.p, plus(triple(node.p), way))
    set_triple(node.before, plus(triple(node.before), times(1.0 - stopped, way)))
