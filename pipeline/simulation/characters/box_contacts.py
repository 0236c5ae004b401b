"""Box contacts: links that come into a box are moved out of it, through the nearest face.

A box is its eight corners; between them it is solid, its edges rounded. A place in it is a mean of
the corners with the weights of trilinear interpolation, and so are the moves of the corners.
"""

from __future__ import annotations

from pipeline.simulation.characters.contact_response import (
    TINY,
    SubStep,
    TouchLog,
    ball_count,
    damp_resting,
    friction_move,
    link_overlaps,
    move_between,
    move_node,
    place_between,
    support_factor,
    touch_links,
)
from pipeline.simulation.characters.sleep_states import WAKE_SPEED, wake_touching
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.vectors import Vector, dot, length, minus, plus, times, triple

MAX_BALLS = 8  # along a link
GOLDEN_RATIO, SEARCH_STEPS = 0.6180339887498949, 10  # of a search to one part in 120
MAX_OVERLAP = 0.02  # of two boxes, beyond which they are moved apart as wholes [m]
MIN_DAMPED_WEIGHT = 0.1  # of a corner that is damped by a touch

Box = tuple[Vector, Vector, Vector, Vector, Vector]
"""Middle, three unit axes, and half the extents between the corners [m]."""

CornerWeights = tuple[float, float, float, float, float, float, float, float]


@compiled
def meet_box(
    nodes: Records, links: Records, one: Record, other: Record, sub_step: SubStep, log: TouchLog
) -> None:
    """Move the links of one character out of a box, the other."""
    box, box_owner = box_of(nodes, other), nodes[other.nodes[0]].owner
    for n in range(one.links[0], one.links[0] + one.links[1]):
        link = links[n]
        if link.radius == 0.0 or not link_overlaps(nodes, link, link.radius, other):
            continue
        first, last = nodes[link.ends[0]], nodes[link.ends[1]]
        # A hand that holds the box does not push it off.
        if first.grip_partner == box_owner or last.grip_partner == box_owner:
            continue
        if link.ends[0] == link.ends[1]:
            _meet_ball(nodes, links, one, other, box, (n, 0.0), sub_step, log)
            continue
        # Of another box only the corners: edges meet edges as links do.
        parts = 1 if one.edge_radius > 0.0 else ball_count(link, MAX_BALLS)
        for k in range(parts + 1):
            _meet_ball(nodes, links, one, other, box, (n, k / parts), sub_step, log)
        if one.edge_radius == 0.0:
            # An edge between two balls is met where the link is nearest to it.
            t = _nearest_on_link(nodes, link, box)
            _meet_ball(nodes, links, one, other, box, (n, t), sub_step, log)


@compiled
def _nearest_on_link(nodes: Records, link: Record, box: Box) -> float:
    """Return the fraction along a link at which it is nearest to a box, or deepest in it.

    The gap to a convex solid is convex along a line, so it has one minimum.

    Source: Kiefer 1953 (search by the golden section).
    """
    p, q = triple(nodes[link.ends[0]].p), triple(nodes[link.ends[1]].p)
    low, high = 0.0, 1.0
    a, b = 1.0 - GOLDEN_RATIO, GOLDEN_RATIO
    gap_a, gap_b = _gap(box, p, q, a), _gap(box, p, q, b)
    for _ in range(SEARCH_STEPS):
        if gap_a < gap_b:
            high, b, gap_b = b, a, gap_a
            a = high - GOLDEN_RATIO * (high - low)
            gap_a = _gap(box, p, q, a)
        else:
            low, a, gap_a = a, b, gap_b
            b = low + GOLDEN_RATIO * (high - low)
            gap_b = _gap(box, p, q, b)
    return 0.5 * (low + high)


@inlined
def _gap(box: Box, p: Vector, q: Vector, t: float) -> float:
    _, _, gap = nearest_on_box(box, plus(times(1.0 - t, p), times(t, q)))
    return gap


@compiled
def separate_boxes(nodes: Records, one: Record, other: Record, slack: float) -> None:
    """Move two deeply overlapping boxes apart as wholes, the shortest way.

    Balls on their edges would be pushed out through different faces, and hold one another.

    Source: Ericson 2005, 4.4.1 (separating axes; here those of the faces).
    """
    a, b = box_of(nodes, one), box_of(nodes, other)
    offset = minus(a[0], b[0])
    least, normal = 1e300, (0.0, 1.0, 0.0)
    for k in range(6):
        axis = a[1] if k == 0 else a[2] if k == 1 else a[3]
        if k >= 3:
            axis = b[1] if k == 3 else b[2] if k == 4 else b[3]
        along = dot(offset, axis)
        reach = _half_extent(a, axis) + _half_extent(b, axis) + one.edge_radius + other.edge_radius
        overlap = reach - abs(along)
        if overlap < least:
            least, normal = overlap, axis if along >= 0.0 else times(-1.0, axis)
    if least < MAX_OVERLAP:
        return
    w_a = 0.0 if one.asleep else 1.0 / one.mass
    w_b = 0.0 if other.asleep else 1.0 / other.mass
    if w_a + w_b == 0.0:
        return
    share = min(least - 0.5 * MAX_OVERLAP, slack) / (w_a + w_b)
    zero = (0.0, 0.0, 0.0)
    for k in range(8):
        move_node(nodes[one.nodes[0] + k], share * w_a, zero, normal, zero)
        move_node(nodes[other.nodes[0] + k], -share * w_b, zero, normal, zero)


@inlined
def _half_extent(box: Box, axis: Vector) -> float:
    half = box[4]
    return (
        half[0] * abs(dot(box[1], axis))
        + half[1] * abs(dot(box[2], axis))
        + half[2] * abs(dot(box[3], axis))
    )


@inlined
def box_of(nodes: Records, owner: Record) -> Box:
    """Return the pose and the extents of a box; see `playthings.CORNERS`."""
    first = owner.nodes[0]
    middle = x = y = z = (0.0, 0.0, 0.0)
    for k in range(8):
        p = triple(nodes[first + k].p)
        middle = plus(middle, times(0.125, p))
        y = plus(y, times(0.25 if k & 4 else -0.25, p))
        x = plus(x, times(0.25 if k & 2 else -0.25, p))
        z = plus(z, times(0.25 if k & 1 else -0.25, p))
    a, b, c = length(x), length(y), length(z)
    half = (0.5 * a, 0.5 * b, 0.5 * c)
    return middle, times(1.0 / a, x), times(1.0 / b, y), times(1.0 / c, z), half


@inlined
def nearest_on_box(box: Box, at: Vector) -> tuple[Vector, Vector, float]:
    """Return the nearest place on a box between its corners.

    Returns:
        The place along its axes, from -1 to 1; the outward normal there in the world; the gap,
        negative inside [m].
    """
    middle, x, y, z, half = box
    offset = minus(at, middle)
    u, v, w = dot(offset, x), dot(offset, y), dot(offset, z)
    a, b, c = (
        min(max(u, -half[0]), half[0]),
        min(max(v, -half[1]), half[1]),
        min(max(w, -half[2]), half[2]),
    )
    outside = plus(plus(times(u - a, x), times(v - b, y)), times(w - c, z))
    gap = length(outside)
    if gap > TINY:
        return (a / half[0], b / half[1], c / half[2]), times(1.0 / gap, outside), gap
    depth = (half[0] - abs(u), half[1] - abs(v), half[2] - abs(w))
    if depth[0] <= depth[1] and depth[0] <= depth[2]:
        s = 1.0 if u >= 0.0 else -1.0
        return (s, b / half[1], c / half[2]), times(s, x), -depth[0]
    if depth[1] <= depth[2]:
        s = 1.0 if v >= 0.0 else -1.0
        return (a / half[0], s, c / half[2]), times(s, y), -depth[1]
    s = 1.0 if w >= 0.0 else -1.0
    return (a / half[0], b / half[1], s), times(s, z), -depth[2]


@inlined
def corner_weights(at: Vector) -> CornerWeights:
    """Return the weights of the corners at a place along the axes from -1 to 1."""
    a, b, c = 0.5 * (1.0 + at[0]), 0.5 * (1.0 + at[1]), 0.5 * (1.0 + at[2])
    return (
        (1.0 - b) * (1.0 - a) * (1.0 - c),
        (1.0 - b) * (1.0 - a) * c,
        (1.0 - b) * a * (1.0 - c),
        (1.0 - b) * a * c,
        b * (1.0 - a) * (1.0 - c),
        b * (1.0 - a) * c,
        b * a * (1.0 - c),
        b * a * c,
    )


@inlined
def nearest_corner(weights: CornerWeights) -> int:
    """Return the corner of the greatest weight."""
    best = 0
    for k in range(1, 8):
        if weights[k] > weights[best]:
            best = k
    return best


@inlined
def corner_mobility(nodes: Records, first: int, weights: CornerWeights) -> float:
    """Return the inverse mass of a place in a box whose first corner is a node [1/kg]."""
    mobility = 0.0
    for k in range(8):
        mobility += weights[k] ** 2 * nodes[first + k].mobility
    return mobility


@inlined
def damp_corners(nodes: Records, box: Record, weights: CornerWeights, speed: float) -> None:
    """Damp the corners of a box near a place that touches at a speed [m/s]."""
    for k in range(8):
        if weights[k] > MIN_DAMPED_WEIGHT:
            damp_resting(nodes[box.nodes[0] + k], box, speed)


@inlined
def move_corners(
    nodes: Records,
    first: int,
    weights: CornerWeights,
    share: float,
    moves: tuple[Vector, Vector, Vector],
) -> None:
    """Move the corners of a box by a share of the moves of a place, see `move_node`."""
    for k in range(8):
        corner = nodes[first + k]
        move_node(corner, share * corner.mobility * weights[k], moves[0], moves[1], moves[2])


@compiled
def _meet_ball(
    nodes: Records,
    links: Records,
    one: Record,
    other: Record,
    box: Box,
    ball: tuple[int, float],
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Move a ball, of a link at a fraction along it, out of a box.

    The box is where it was at the first look: other balls move it by less than a round leaves.
    """
    n, t = ball
    h, moment = sub_step.h, sub_step.moment
    link = links[n]
    i, j = nodes[link.ends[0]], nodes[link.ends[1]]
    at = place_between(i.p, j.p, t)
    place, normal, gap = nearest_on_box(box, at)
    depth = link.radius + other.edge_radius - gap
    if depth <= 0.0 or (
        one.edge_radius > 0.0 and depth > MAX_OVERLAP + one.edge_radius + other.edge_radius
    ):
        return
    one.penetration, other.penetration = max(one.penetration, depth), max(other.penetration, depth)
    weights, first = corner_weights(place), other.nodes[0]
    moved = move_between(i, j, t)
    for k in range(8):
        corner = nodes[first + k]
        moved = minus(moved, times(weights[k], minus(triple(corner.p), triple(corner.previous))))
    approach = -dot(moved, normal)
    wake_touching(nodes, one, other, depth, approach / h)
    damp_resting(i, one, approach / h)
    damp_resting(j, one, approach / h)
    near, far = (i, i) if t == 0.0 else (i, j)
    own = (1.0 - t) ** 2 * i.mobility + t * t * j.mobility if t > 0.0 else i.mobility
    others = corner_mobility(nodes, first, weights)
    damp_corners(nodes, other, weights, approach / h)
    corner = nodes[first + nearest_corner(weights)]
    kept = support_factor(near, far, normal[1], own, others)
    box_kept = support_factor(corner, corner, -normal[1], others, own)
    weight = kept * own + box_kept * others
    if weight == 0.0:
        return
    speed = max(approach, 0.0) / h
    energy = 0.5 * speed * speed / weight
    touch_links(links, (n, other.links[0]), (at, normal), speed, energy, moment, log)
    friction = 0.5 * (one.friction + other.friction)
    contact = depth, approach, weight
    move, part, back = _moves(contact, moved, normal, friction, one.bounciness, sub_step)
    move_node(i, kept * i.mobility * (1.0 - t if t > 0.0 else 1.0), move, part, back)
    if t > 0.0:
        move_node(j, kept * j.mobility * t, move, part, back)
    move_corners(nodes, first, weights, -box_kept, (move, part, back))


@inlined
def _moves(
    contact: tuple[float, float, float],
    moved: Vector,
    normal: Vector,
    friction: float,
    bounciness: float,
    sub_step: SubStep,
) -> tuple[Vector, Vector, Vector]:
    """Return the moves of a contact for `move_node`, per inverse mass [kg m].

    Args:
        contact: depth and approach [m], and inverse mass of both sides [1/kg].
        moved: motion past the box in this sub-step [m].
        normal: of the contact.
        friction: Coulomb's coefficient.
        bounciness: speed after / before an impact.
        sub_step: the sub-step.
    """
    depth, approach, weight = contact
    stopped = min(depth, max(approach, 0.0))
    parted = min(depth - stopped, sub_step.slack)
    sliding = friction_move(moved, normal, friction * stopped)
    move = times(1.0 / weight, plus(times(stopped, normal), sliding))
    back = (0.0, 0.0, 0.0)
    if bounciness > 0.0 and approach > 2.0 * WAKE_SPEED * sub_step.h:
        back = times((bounciness * approach + approach - stopped) / weight, normal)
    return move, times(parted / weight, normal), back
