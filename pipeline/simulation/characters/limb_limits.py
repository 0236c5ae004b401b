"""Limb limits: knees and elbows bend one way.

A limb of two links with known root and tip leaves its joint a circle. The direction in which the
joint points is known for a limb in the middle of its cone of reach; it goes along with the limb
by the shortest turn. So it is undefined only opposite to the middle, out of reach.

Limits are solved like contacts. What a limb went beyond its limit in the sub-step is taken out of
the positions alone, and so out of the velocities; what it was beyond it before is taken out of
both the present and the previous positions, at a limited speed. The trunk takes the reaction, so
both momenta are kept: limits without one would feed a swinging body with energy.

At the end of a sub-step the joint is put where both links have their lengths.

Source: Horswill 2008, "Gait control" and "Failure modes" (knees that bend neither back nor
    sideways; that elbows need their own limits).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pipeline.simulation.characters.contact_response import SUPPORTED_MOBILITY
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
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
MIN_TURN_COSINE = 0.05  # below which a turn has no shortest way
MAX_TURN = 0.2  # of a limb towards its cone in one projection [rad]
RECOVERY_SPEED = 2.5  # at which a limb comes back from beyond a limit [m/s]
COSINE_ROUNDING = 1e-9  # beyond which cosines tell which of two angles is larger
LEAST_BEND = 1e-3  # of a limb, across over along, from which they tell where its joint points


class Trunk(NamedTuple):
    """The trunk that a limb hangs on.

    Attributes:
        x: unit vector forward.
        y: unit vector up.
        z: unit vector to the right.
        height: length of its axis [m].
        width: distance of its sides [m].
    """

    x: Vector
    y: Vector
    z: Vector
    height: float
    width: float


class Posture(NamedTuple):
    """A limb on its trunk.

    Attributes:
        trunk: that it hangs on.
        d: unit vector from root to tip.
        distance: from root to tip [m].
        e: unit vector across d towards the joint, zero for a straight limb.
        size: distance of the joint from the line between root and tip [m].
        along: distance of the joint from the root along this line [m].
    """

    trunk: Trunk
    d: Vector
    distance: float
    e: Vector
    size: float
    along: float


class Pulls(NamedTuple):
    """Impulses on the nodes of a limb and its trunk, or the moves by these."""

    tip: Vector
    joint: Vector
    left: Vector
    right: Vector
    low: Vector
    high: Vector


@inlined
def begin_recovery(limbs: Records, h: float) -> None:
    """Let limbs come back from beyond their limits in a sub-step of `h` [s].

    No faster where they move: links turn some of the way back into speed, which would grow.
    """
    for n in range(len(limbs)):
        limbs[n].slack = RECOVERY_SPEED * h


@inlined
def _move_of(node: Record) -> Vector:
    """Return the motion of a node in this sub-step [m]."""
    return minus(triple(node.p), triple(node.previous))


@inlined
def limit_limbs(nodes: Records, limbs: Records, first: int, count: int) -> bool:
    """Turn limbs back into their cones, or their joints back to where they may point.

    Returns:
        Whether any may have moved.
    """
    trunk, is_known, any_moved = trunk_of(nodes, limbs[first]), True, False
    for n in range(first, first + count):
        limb = limbs[n]
        if not (is_known and hang_together(limb, limbs[max(n - 1, first)])):
            trunk = trunk_of(nodes, limb)
        is_known = _is_within_limits(nodes, limb, trunk) or not _limit_limb(nodes, limb, trunk)
        any_moved = any_moved or not is_known
    return any_moved


@inlined
def place_joints(nodes: Records, limbs: Records, first: int, count: int) -> None:
    """Put joints where both links have their lengths and they point where they may."""
    trunk = trunk_of(nodes, limbs[first])
    for n in range(first, first + count):
        limb = limbs[n]
        # No joint is a node of a trunk.
        if not hang_together(limb, limbs[max(n - 1, first)]):
            trunk = trunk_of(nodes, limb)
        _place_joint(nodes, limb, trunk)


@inlined
def hang_together(limb: Record, other: Record) -> bool:
    """Tell whether two limbs hang on one trunk."""
    sides: bool = limb.left == other.left and limb.right == other.right
    return sides and limb.low == other.low and limb.high == other.high


@inlined
def _is_within_limits(nodes: Records, limb: Record, trunk: Trunk) -> bool:
    """Tell whether a limb is certainly in its cone, and its joint where it may point.

    Most limbs are.
    """
    root = triple(nodes[limb.root].p)
    way, offset = minus(triple(nodes[limb.tip].p), root), minus(triple(nodes[limb.joint].p), root)
    squared = max(dot(way, way), TINY * TINY)
    distance = math.sqrt(squared)
    radial = minus(offset, times(dot(offset, way) / squared, way))
    across = length(radial)
    is_in_cone = dot(_in_world(limb.middle, trunk), way) > (limb.cone + COSINE_ROUNDING) * distance
    is_bent = across > LEAST_BEND * distance
    return is_in_cone and is_bent and _points_freely(limb, trunk, way, distance, radial, across)


@inlined
def _points_freely(
    limb: Record, trunk: Trunk, way: Vector, distance: float, radial: Vector, across: float
) -> bool:
    """Tell whether a joint certainly points where it may.

    With w from root to tip, r from the line between them to the joint, and m, c and R as of
    `_turned_with`, r · R c (|w| + m · w) = r · c (|w| + m · w) - (w · c) (r · m).

    Args:
        limb: the limb.
        trunk: that it hangs on.
        way: w, of any length.
        distance: length of w.
        radial: r, of any length.
        across: length of r.
    """
    m, c = _in_world(limb.middle, trunk), _in_world(limb.bend, trunk)
    opening = distance + dot(m, way)
    pointed = dot(radial, c) * opening - dot(way, c) * dot(radial, m)
    is_allowed = pointed > (limb.spread[0] + COSINE_ROUNDING) * across * opening
    return is_allowed and opening > 2.0 * MIN_TURN_COSINE * distance


@compiled
def _limit_limb(nodes: Records, limb: Record, trunk: Trunk) -> bool:
    """Turn a limb back into its cone, or its joint back to where it may point.

    A limb out of its cone does both if its joint lies on something, which it would else be pressed
    into at the end of the sub-step; in the air both at once would add energy.

    Returns:
        Whether it may have moved, with its trunk.
    """
    now, may_move = _posture(nodes, limb, trunk), False
    if now.distance < TINY:
        return False
    excess = _cone_excess(limb, now)
    if excess > 0.0:
        _close_limb(nodes, limb, now, excess)
        joint = nodes[limb.joint]
        if joint.ground_damping == 0.0 and joint.contact_damping == 0.0:
            return True
        now, may_move = _posture(nodes, limb, trunk_of(nodes, limb)), True
    chord = _joint_chord(limb, now)
    if dot(chord, chord) > TINY * TINY:
        _swing_joint(nodes, limb, now, chord)
        return True
    return may_move


@compiled
def _place_joint(nodes: Records, limb: Record, trunk: Trunk) -> None:
    """Put a joint where both links have their lengths and it points where it may."""
    joint = nodes[limb.joint]
    if joint.mobility == 0.0:
        return
    now = _posture(nodes, limb, trunk)
    if now.distance < TINY:
        return
    root, upper, lower = triple(nodes[limb.root].p), limb.upper, limb.lower
    if now.distance >= upper + lower:
        # It is stretched: both links have their share of it.
        share = upper / (upper + lower) * now.distance
        _move_to(joint, plus(root, times(share, now.d)))
        return
    e = now.e
    is_bent = now.size > LEAST_BEND * now.distance
    if not (is_bent and _points_freely(limb, trunk, now.d, 1.0, now.e, 1.0)):
        e = _recovered_direction(limb, now)
    a = (upper * upper - lower * lower + now.distance**2) / (2.0 * now.distance)
    height = math.sqrt(max(upper * upper - a * a, 0.0))
    # What presses on a joint may press it nearer to straight, and so root and tip apart.
    lowest = math.sqrt(max((MIN_LINK_FRACTION * upper) ** 2 - a * a, 0.0))
    height = min(max(dot(minus(triple(joint.p), root), e), lowest), height)
    _move_to(joint, plus(root, plus(times(a, now.d), times(height, e))))


@inlined
def joint_excess(nodes: Records, limb: Record) -> float:
    """Return the distance of a joint from where it may point, in lengths of the upper link."""
    return length(_joint_chord(limb, _posture(nodes, limb, trunk_of(nodes, limb)))) / limb.upper


@inlined
def trunk_of(nodes: Records, limb: Record) -> Trunk:
    """Return the trunk that a limb hangs on."""
    right = minus(triple(nodes[limb.right].p), triple(nodes[limb.left].p))
    up = minus(triple(nodes[limb.high].p), triple(nodes[limb.low].p))
    forward = cross(up, right)
    size, height, width = length(forward), max(length(up), TINY), max(length(right), TINY)
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    if size >= TINY:
        x, y = times(1.0 / size, forward), times(1.0 / height, up)
        z = cross(x, y)
    return Trunk(x, y, z, height, width)


@inlined
def _posture(nodes: Records, limb: Record, trunk: Trunk) -> Posture:
    """Return a limb on its trunk."""
    root = triple(nodes[limb.root].p)
    way = minus(triple(nodes[limb.tip].p), root)
    distance = length(way)
    d = times(1.0 / max(distance, TINY), way)
    offset = minus(triple(nodes[limb.joint].p), root)
    along = dot(offset, d)
    radial = minus(offset, times(along, d))
    across = length(radial)
    if across < TINY:
        return Posture(trunk, d, distance, (0.0, 0.0, 0.0), 0.0, along)
    e = times(1.0 / across, radial)
    return Posture(trunk, d, distance, e, across, along)


@inlined
def _in_world(a: Vector, trunk: Trunk) -> Vector:
    return plus(plus(times(a[0], trunk.x), times(a[1], trunk.y)), times(a[2], trunk.z))


@inlined
def _cone_excess(limb: Record, now: Posture) -> float:
    """Return the angle by which a limb is out of its cone, 0 or less within it [rad]."""
    cosine = dot(now.d, _in_world(limb.middle, now.trunk))
    if cosine > limb.cone + COSINE_ROUNDING:
        return 0.0
    return math.acos(min(max(cosine, -1.0), 1.0)) - math.acos(limb.cone)


@inlined
def _allowed_direction(limb: Record, now: Posture) -> Vector:
    """Return the direction nearest to e, across d, in which the joint may point."""
    c = _turned_with(_in_world(limb.bend, now.trunk), _in_world(limb.middle, now.trunk), now.d)
    if now.size == 0.0:
        return c
    if dot(now.e, c) >= limb.spread[0]:
        return now.e
    side = cross(now.d, c)
    sine = limb.spread[1] if dot(now.e, side) >= 0.0 else -limb.spread[1]
    return plus(times(limb.spread[0], c), times(sine, side))


@inlined
def _joint_chord(limb: Record, now: Posture) -> Vector:
    """Return the way of a joint across d to where it may point [m]."""
    return times(now.size, minus(_allowed_direction(limb, now), now.e))


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
def _recovered_direction(limb: Record, now: Posture) -> Vector:
    """Return the unit vector across d in which a joint is put."""
    chord = _joint_chord(limb, now)
    size = length(chord)
    if size <= TINY:
        return _allowed_direction(limb, now)
    parted = _recovered(limb, size)
    e = plus(times(now.size, now.e), times(parted / size, chord))
    across = length(e)
    return times(1.0 / across, e) if across > TINY else _allowed_direction(limb, now)


@inlined
def _recovered(limb: Record, way: float) -> float:
    """Return the part of a way back to a limit that a limb may go in this sub-step [m]."""
    parted: float = min(way, limb.slack)
    limb.slack -= parted
    return parted


@compiled
def _close_limb(nodes: Records, limb: Record, now: Posture, excess: float) -> None:
    """Turn tip and joint about the root towards the cone."""
    axis = cross(now.d, _in_world(limb.middle, now.trunk))
    size = length(axis)
    if size < TINY:
        return
    axis = times(1.0 / size, axis)
    towards = cross(axis, now.d)
    arm = plus(times(now.along, now.d), times(now.size, now.e))
    joint = times(1.0 / now.distance, cross(axis, arm))
    torque = plus(times(now.distance, axis), cross(arm, joint))
    root = times(-1.0, plus(towards, joint))
    pulls = _pulls(limb, now, (towards, joint, root), torque)
    moves = _moves(nodes, limb, pulls, 1.0)
    turned = dot(minus(moves.tip, _root_move(limb, moves)), towards)
    turned -= now.distance * dot(axis, _trunk_turn(now, moves))
    _displace(nodes, limb, pulls, moves, now.distance * min(excess, MAX_TURN), turned)


@compiled
def _swing_joint(nodes: Records, limb: Record, now: Posture, chord: Vector) -> None:
    """Move the joint against root and tip to where it may point."""
    size = length(chord)
    w = times(1.0 / size, chord)
    share = min(max(now.along / now.distance, 0.0), 1.0)
    tip, root = times(-share, w), times(share - 1.0, w)
    torque = times(now.size, cross(now.e, w))
    # What lies on the ground is borne by it: root and tip rise instead.
    is_supported = w[1] < 0.0 and nodes[limb.joint].ground_damping > 0.0
    kept = SUPPORTED_MOBILITY if is_supported else 1.0
    pulls = _pulls(limb, now, (tip, w, root), torque)
    moves = _moves(nodes, limb, pulls, kept)
    base = plus(times(share, moves.tip), times(1.0 - share, _root_move(limb, moves)))
    swung = dot(minus(moves.joint, base), w)
    goal = plus(times(now.size, now.e), chord)
    swung -= dot(_trunk_turn(now, moves), now.d) * dot(cross(now.d, goal), w)
    _displace(nodes, limb, pulls, moves, size, swung)


@inlined
def _pulls(
    limb: Record, now: Posture, limb_pulls: tuple[Vector, Vector, Vector], torque: Vector
) -> Pulls:
    """Return pulls without force and torque in all.

    Args:
        limb: whose root is the left or the right of its trunk.
        now: its posture.
        limb_pulls: on tip, joint and root, without force in all.
        torque: of these about the root.
    """
    tip, joint, root = limb_pulls
    trunk = now.trunk
    high = times(-1.0 / trunk.height, cross(torque, trunk.y))
    right = times(-dot(torque, trunk.y) / trunk.width, trunk.x)
    left, low = times(-1.0, right), times(-1.0, high)
    if limb.root == limb.left:
        left = plus(left, root)
    else:
        right = plus(right, root)
    return Pulls(tip, joint, left, right, low, high)


@inlined
def _moves(nodes: Records, limb: Record, pulls: Pulls, kept: float) -> Pulls:
    """Return the moves by pulls, of a joint that keeps a part of its mobility."""
    return Pulls(
        times(nodes[limb.tip].mobility, pulls.tip),
        times(kept * nodes[limb.joint].mobility, pulls.joint),
        times(nodes[limb.left].mobility, pulls.left),
        times(nodes[limb.right].mobility, pulls.right),
        times(nodes[limb.low].mobility, pulls.low),
        times(nodes[limb.high].mobility, pulls.high),
    )


@inlined
def _root_move(limb: Record, moves: Pulls) -> Vector:
    return moves.left if limb.root == limb.left else moves.right


@inlined
def _trunk_turn(now: Posture, moves: Pulls) -> Vector:
    """Return the turn of the trunk by moves of its nodes [rad]."""
    x, y = now.trunk.x, now.trunk.y
    bowed = times(1.0 / now.trunk.height, cross(y, minus(moves.high, moves.low)))
    twisted = dot(minus(moves.right, moves.left), x) / now.trunk.width
    return plus(minus(bowed, times(dot(bowed, y), y)), times(twisted, y))


@compiled
def _displace(
    nodes: Records, limb: Record, pulls: Pulls, moves: Pulls, way: float, gain: float
) -> None:
    """Move a limb and its trunk back to a limit.

    Args:
        nodes: of all characters; changed.
        limb: changed.
        pulls: on the nodes.
        moves: by these pulls.
        way: to the limit [m].
        gain: part of the way by these moves.
    """
    if gain <= 0.0:
        return
    ends = (limb.tip, limb.joint, limb.left, limb.right, limb.low, limb.high)
    against, weight = 0.0, 0.0
    for k in range(len(ends)):
        against -= dot(pulls[k], _move_of(nodes[ends[k]]))
        weight += dot(pulls[k], moves[k])
    # As far as the impulses take up motion: any farther they would add to it.
    stopped = min(max(against / weight, 0.0), way / gain)
    parted = _recovered(limb, way - stopped * gain) / gain
    for k in range(len(ends)):
        node = nodes[ends[k]]
        set_triple(node.p, plus(triple(node.p), times(stopped + parted, moves[k])))
        set_triple(node.previous, plus(triple(node.previous), times(parted, moves[k])))


@inlined
def _move_to(node: Record, place: Vector) -> None:
    """Move a node so that the move stops its motion against it and gives it no speed."""
    move = minus(place, triple(node.p))
    moved = minus(triple(node.p), triple(node.previous))
    against, squared = -dot(moved, move), dot(move, move)
    if squared == 0.0:
        return
    stopped = min(max(against / squared, 0.0), 1.0)
    set_triple(node.p, place)
    set_triple(node.previous, plus(triple(node.previous), times(1.0 - stopped, move)))
