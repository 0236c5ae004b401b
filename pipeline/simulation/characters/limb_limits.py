"""Limb limits: knees and elbows bend one way.

A limb of two links with known root and tip leaves its joint a circle. The direction in which the
joint points is known for a limb in the middle of its cone of reach; it goes along with the limb
by the shortest turn. So it is undefined only opposite to the middle, out of reach.

While links are projected the limb is turned back with moves that leave its momentum alone; at
the end of a sub-step the joint is put where it belongs.

Source: Horswill 2008, "Gait control" and "Failure modes" (knees that bend neither back nor
    sideways; that elbows need their own limits).
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.contact_response import SUPPORTED_MOBILITY
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

TINY = 1e-9  # [m]
MIN_LINK_FRACTION = 0.996  # of its length that a link may be pressed to
MAX_LIFT = 1.5e-3  # by which a joint pressed into the ground lifts its limb, each time [m]
MIN_TURN_COSINE = 0.05  # below which a turn has no shortest way


@inlined
def limit_limb(nodes: Records, limb: Record) -> None:
    """Turn a limb back into its cone, and its joint back to where it may point."""
    x, y, z = trunk_axes(nodes, limb)
    root, tip = triple(nodes[limb.root].p), triple(nodes[limb.tip].p)
    along = minus(tip, root)
    distance = length(along)
    if distance < TINY:
        return
    d = times(1.0 / distance, along)
    m = _in_world(limb.middle, x, y, z)
    if dot(d, m) < limb.cone:
        # The nearest direction in the cone; tip and joint go there, root and trunk push back.
        aside = minus(m, times(dot(m, d), d))
        size = length(aside)
        if size > TINY:
            angle = math.acos(max(dot(d, m), -1.0)) - math.acos(limb.cone)
            _close_limb(nodes, limb, times(distance * min(angle, 0.2) / size, aside))
            return
    e, size, _ = _joint_direction(nodes, limb, d)
    allowed = _allowed_direction(limb, e, d, m, x, y, z)
    if dot(allowed, e) < 1.0 - 1e-12:
        _swing_joint(nodes, limb, times(size, minus(allowed, e)))


@inlined
def place_joint(nodes: Records, limb: Record) -> None:
    """Put a joint where both links have their lengths and it points where it may."""
    if nodes[limb.joint].mobility == 0.0:
        return
    x, y, z = trunk_axes(nodes, limb)
    root, along = (
        triple(nodes[limb.root].p),
        minus(triple(nodes[limb.tip].p), triple(nodes[limb.root].p)),
    )
    distance = length(along)
    if distance < TINY:
        return
    d = times(1.0 / distance, along)
    e, _, _ = _joint_direction(nodes, limb, d)
    allowed = _allowed_direction(limb, e, d, _in_world(limb.middle, x, y, z), x, y, z)
    upper, lower = limb.upper, limb.lower
    if distance >= upper + lower:
        # It is stretched: both links have their share of it.
        _move_to(nodes[limb.joint], plus(root, times(upper / (upper + lower), along)))
        return
    a = (upper * upper - lower * lower + distance * distance) / (2.0 * distance)
    height = math.sqrt(max(upper * upper - a * a, 0.0))
    # What presses on a joint may press it nearer to straight, and so root and tip apart.
    lowest = math.sqrt(max((MIN_LINK_FRACTION * upper) ** 2 - a * a, 0.0))
    height = min(max(dot(minus(triple(nodes[limb.joint].p), root), allowed), lowest), height)
    _move_to(nodes[limb.joint], plus(root, plus(times(a, d), times(height, allowed))))


@inlined
def joint_angle(nodes: Records, limb: Record) -> float:
    """Return the bend of a joint [rad], negative if it points where it may not."""
    x, y, z = trunk_axes(nodes, limb)
    root, joint, tip = (
        triple(nodes[limb.root].p),
        triple(nodes[limb.joint].p),
        triple(nodes[limb.tip].p),
    )
    upper, lower = minus(joint, root), minus(tip, joint)
    angle = math.atan2(length(cross(upper, lower)), dot(upper, lower))
    along = minus(tip, root)
    d = times(1.0 / max(length(along), TINY), along)
    e, _, _ = _joint_direction(nodes, limb, d)
    allowed = _allowed_direction(limb, e, d, _in_world(limb.middle, x, y, z), x, y, z)
    return angle if dot(allowed, e) > 1.0 - 1e-6 else -angle


@inlined
def trunk_axes(nodes: Records, limb: Record) -> tuple[Vector, Vector, Vector]:
    """Return the axes of the trunk that a limb hangs on: forward, up, right."""
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
def _in_world(a: Vector, x: Vector, y: Vector, z: Vector) -> Vector:
    return plus(plus(times(a[0], x), times(a[1], y)), times(a[2], z))


@inlined
def _joint_direction(nodes: Records, limb: Record, d: Vector) -> tuple[Vector, float, float]:
    """Return the direction of the joint across a unit vector d from root to tip.

    Returns:
        The direction, zero for a straight limb; the distance from the line [m]; the distance along
        the line [m].
    """
    offset = minus(triple(nodes[limb.joint].p), triple(nodes[limb.root].p))
    along = dot(offset, d)
    radial = minus(offset, times(along, d))
    size = length(radial)
    if size < TINY:
        return (0.0, 0.0, 0.0), 0.0, along
    return times(1.0 / size, radial), size, along


@inlined
def _allowed_direction(
    limb: Record, e: Vector, d: Vector, m: Vector, x: Vector, y: Vector, z: Vector
) -> Vector:
    """Return the direction nearest to e, across d, in which the joint may point."""
    c = _turned_with(_in_world(limb.bend, x, y, z), m, d)
    if dot(e, e) == 0.0:
        return c
    if dot(e, c) >= limb.spread[0]:
        return e
    side = cross(d, c)
    sine = limb.spread[1] if dot(e, side) >= 0.0 else -limb.spread[1]
    return plus(times(limb.spread[0], c), times(sine, side))


@inlined
def _turned_with(c: Vector, m: Vector, d: Vector) -> Vector:
    """Return c, across m, turned by the shortest turn from m to d.

    R c = c - (d · c) (m + d) / (1 + m · d) for unit m and d, and c across m.
    """
    share = dot(d, c) / max(1.0 + dot(m, d), MIN_TURN_COSINE)
    turned = minus(c, times(share, plus(m, d)))
    # Nearly opposite to the middle the turn is no longer one: across d all the same.
    turned = minus(turned, times(dot(turned, d), d))
    return times(1.0 / max(length(turned), TINY), turned)


@inlined
def _move_to(node: Record, place: Vector) -> None:
    _displace(node, minus(place, triple(node.p)))


@inlined
def _close_limb(nodes: Records, limb: Record, move: Vector) -> None:
    """Move tip and joint against the root, so that they come nearer to one another."""
    root, joint, tip = nodes[limb.root], nodes[limb.joint], nodes[limb.tip]
    # Half of the move for the joint, about half as far out; the root takes the reaction.
    mobility = tip.mobility + 0.25 * joint.mobility + 2.25 * root.mobility
    if mobility == 0.0:
        return
    share = 1.0 / mobility
    _displace(tip, times(share * tip.mobility, move))
    _displace(joint, times(0.5 * share * joint.mobility, move))
    _displace(root, times(-1.5 * share * root.mobility, move))


@inlined
def _swing_joint(nodes: Records, limb: Record, move: Vector) -> None:
    """Move the joint against root and tip, which take half each."""
    root, joint, tip = nodes[limb.root], nodes[limb.joint], nodes[limb.tip]
    size = length(move)
    lift_share = min(MAX_LIFT / size, 1.0) if move[1] < 0.0 and joint.ground_damping > 0.0 else 0.0
    for k in range(2):
        # What lies on the ground is borne by it: root and tip rise instead, but not at a jerk.
        joint_mobility = joint.mobility * (SUPPORTED_MOBILITY if k == 1 else 1.0)
        mobility = joint_mobility + 0.25 * (root.mobility + tip.mobility)
        share = (lift_share if k == 1 else 1.0 - lift_share) / mobility if mobility > 0.0 else 0.0
        if share > 0.0:
            _displace(joint, times(share * joint_mobility, move))
            _displace(root, times(-0.5 * share * root.mobility, move))
            _displace(tip, times(-0.5 * share * tip.mobility, move))


@inlined
def _displace(node: Record, move: Vector) -> None:
    """Move a node so that the move stops its motion against it and gives it no speed."""
    moved = minus(triple(node.p), triple(node.previous))
    against, squared = -dot(moved, move), dot(move, move)
    if squared == 0.0:
        return
    stopped = min(max(against / squared, 0.0), 1.0)
    set_triple(node.p, plus(triple(node.p), move))
    set_triple(node.previous, plus(triple(node.previous), times(1.0 - stopped, move)))
