"""Box contacts."""

from __future__ import annotations

from pipeline.simulation.characters.contact_response import (
    ABOVE,
    PAUSE,
    TouchLog,
    borne,
    log_touch,
    move_node,
    rub,
    rubbed,
    sense,
)
from pipeline.simulation.characters.sleep_states import WAKE_SPEED, wake_touching
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.vectors import Vector, dot, length, minus, plus, times, triple

APART = 0.08
"""Distance of the balls along a link, about [m]."""

MOST = 8
"""Of them along a link."""

GOLDEN, HALVINGS = 0.6180339887498949, 10
"""The golden section, and how often a link is cut by it: to one part in 120."""

DEEP = 0.02
"""How deep two boxes are in one another that are moved apart as wholes [m]."""

TINY = 1e-9

Box = tuple[Vector, Vector, Vector, Vector, Vector]
"""Its middle, its axes of length one, and half its extents between the corners [m]."""

Corners = tuple[float, float, float, float, float, float, float, float]


@compiled
def meet_box(
    nodes: Records,
    links: Records,
    one: Record,
    other: Record,
    h: float,
    slack: float,
    moment: float,
    log: TouchLog,
) -> None:
    """Move the links of one character out of a box, the other."""
    box, whose = box_of(nodes, other), nodes[other.nodes[0]].owner
    for n in range(one.links[0], one.links[0] + one.links[1]):
        link = links[n]
        if link.radius == 0.0 or not _may_touch(nodes, link, other):
            continue
        # A hand that holds it does not push it off.
        if nodes[link.ends[0]].grip_partner == whose or nodes[link.ends[1]].grip_partner == whose:
            continue
        # Of another box its corners: edges meet edges as links do.
        parts = 1 if one.edge_radius > 0.0 else min(int(link.length_limits[0] / APART) + 1, MOST)
        if link.ends[0] == link.ends[1]:
            _meet(nodes, links, one, other, box, (n, 0.0), h, slack, moment, log)
            continue
        for k in range(parts + 1):
            _meet(nodes, links, one, other, box, (n, k / parts), h, slack, moment, log)
        if one.edge_radius == 0.0:
            # An edge between two balls is met where the link is nearest to it.
            t = _nearest(nodes, link, box)
            _meet(nodes, links, one, other, box, (n, t), h, slack, moment, log)


@compiled
def _nearest(nodes: Records, link: Record, box: Box) -> float:
    """Return where on a link, from 0 to 1, it is nearest to a box, or deepest in it.

    The gap to what is convex is convex along a line: its least is between any two places of
    which that between them is nearer.

    Source: Kiefer 1953 (search by the golden section).
    """
    p, q = triple(nodes[link.ends[0]].p), triple(nodes[link.ends[1]].p)
    low, high = 0.0, 1.0
    a, b = 1.0 - GOLDEN, GOLDEN
    gap_a, gap_b = _gap(box, p, q, a), _gap(box, p, q, b)
    for _ in range(HALVINGS):
        if gap_a < gap_b:
            high, b, gap_b = b, a, gap_a
            a = high - GOLDEN * (high - low)
            gap_a = _gap(box, p, q, a)
        else:
            low, a, gap_a = a, b, gap_b
            b = low + GOLDEN * (high - low)
            gap_b = _gap(box, p, q, b)
    return 0.5 * (low + high)


@inlined
def _gap(box: Box, p: Vector, q: Vector, t: float) -> float:
    """Return how far a place between p and q is from a box [m]."""
    _, _, gap = nearest_of_box(box, plus(times(1.0 - t, p), times(t, q)))
    return gap


@compiled
def part(nodes: Records, one: Record, other: Record, slack: float) -> None:
    """Move two boxes apart that are deep in one another, as wholes, the shortest way.

    Balls on their edges would be pushed out through different faces, and hold one another.

    Source: Ericson 2005, 4.4.1 (separating axes; here those of the faces).
    """
    a, b = box_of(nodes, one), box_of(nodes, other)
    off = minus(a[0], b[0])
    least, way = 1e300, (0.0, 1.0, 0.0)
    for k in range(6):
        axis = a[1] if k == 0 else a[2] if k == 1 else a[3]
        if k >= 3:
            axis = b[1] if k == 3 else b[2] if k == 4 else b[3]
        along = dot(off, axis)
        overlap = _half(a, axis) + _half(b, axis) + one.edge_radius + other.edge_radius - abs(along)
        if overlap < least:
            least, way = overlap, axis if along >= 0.0 else times(-1.0, axis)
    if least < DEEP:
        return
    w_a = 0.0 if one.asleep else 1.0 / one.mass
    w_b = 0.0 if other.asleep else 1.0 / other.mass
    if w_a + w_b == 0.0:
        return
    share = min(least - 0.5 * DEEP, slack) / (w_a + w_b)
    still = (0.0, 0.0, 0.0)
    for k in range(8):
        move_node(nodes[one.nodes[0] + k], share * w_a, still, way, still)
        move_node(nodes[other.nodes[0] + k], -share * w_b, still, way, still)


@inlined
def _half(box: Box, axis: Vector) -> float:
    """Return half of the extent of a box along an axis [m]."""
    half = box[4]
    return (
        half[0] * abs(dot(box[1], axis))
        + half[1] * abs(dot(box[2], axis))
        + half[2] * abs(dot(box[3], axis))
    )


@inlined
def box_of(nodes: Records, owner: Record) -> Box:
    """Return where a box is, see `things.CORNERS`."""
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
def _may_touch(nodes: Records, link: Record, owner: Record) -> bool:
    p, q = nodes[link.ends[0]].p, nodes[link.ends[1]].p
    for k in range(3):
        if min(p[k], q[k]) - link.radius > owner.high[k]:
            return False
        if max(p[k], q[k]) + link.radius < owner.low[k]:
            return False
    return True


@inlined
def nearest_of_box(box: Box, at: Vector) -> tuple[Vector, Vector, float]:
    """Return a place on a box between its corners, along its axes from -1 to 1, that is nearest.

    Returns:
        The place, the outward normal there in the world, and the gap, negative inside [m].
    """
    middle, x, y, z, half = box
    off = minus(at, middle)
    u, v, w = dot(off, x), dot(off, y), dot(off, z)
    a, b, c = (
        min(max(u, -half[0]), half[0]),
        min(max(v, -half[1]), half[1]),
        min(max(w, -half[2]), half[2]),
    )
    away = plus(plus(times(u - a, x), times(v - b, y)), times(w - c, z))
    gap = length(away)
    if gap > TINY:
        return (a / half[0], b / half[1], c / half[2]), times(1.0 / gap, away), gap
    deep = (half[0] - abs(u), half[1] - abs(v), half[2] - abs(w))
    if deep[0] <= deep[1] and deep[0] <= deep[2]:
        s = 1.0 if u >= 0.0 else -1.0
        return (s, b / half[1], c / half[2]), times(s, x), -deep[0]
    if deep[1] <= deep[2]:
        s = 1.0 if v >= 0.0 else -1.0
        return (a / half[0], s, c / half[2]), times(s, y), -deep[1]
    s = 1.0 if w >= 0.0 else -1.0
    return (a / half[0], b / half[1], s), times(s, z), -deep[2]


@inlined
def weights_of(at: Vector) -> Corners:
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
def heaviest(weights: Corners) -> int:
    """Return the nearest corner."""
    best = 0
    for k in range(1, 8):
        if weights[k] > weights[best]:
            best = k
    return best


@compiled
def _meet(
    nodes: Records,
    links: Records,
    one: Record,
    other: Record,
    box: Box,
    ball: tuple[int, float],
    h: float,
    slack: float,
    moment: float,
    log: TouchLog,
) -> None:
    """Move a ball, at a place from 0 to 1 on a link, out of a box.

    The box that is asked is where it was when the link was first looked at: what other balls
    have moved it by since is less than what a round leaves anyway.
    """
    n, t = ball
    link = links[n]
    i, j = nodes[link.ends[0]], nodes[link.ends[1]]
    at = plus(times(1.0 - t, triple(i.p)), times(t, triple(j.p)))
    place, normal, gap = nearest_of_box(box, at)
    depth = link.radius + other.edge_radius - gap
    if depth <= 0.0 or (
        one.edge_radius > 0.0 and depth > DEEP + one.edge_radius + other.edge_radius
    ):
        return
    one.penetration, other.penetration = max(one.penetration, depth), max(other.penetration, depth)
    weights = weights_of(place)
    first = other.nodes[0]
    went = plus(
        times(1.0 - t, minus(triple(i.p), triple(i.previous))),
        times(t, minus(triple(j.p), triple(j.previous))),
    )
    for k in range(8):
        corner = nodes[first + k]
        went = minus(went, times(weights[k], minus(triple(corner.p), triple(corner.previous))))
    nearer = -dot(went, normal)
    wake_touching(nodes, one, other, depth, nearer / h)
    rub(i, one, nearer / h)
    rub(j, one, nearer / h)
    near, far = (i, i) if t == 0.0 else (i, j)
    own = (1.0 - t) ** 2 * i.mobility + t * t * j.mobility if t > 0.0 else i.mobility
    others = 0.0
    for k in range(8):
        others += weights[k] ** 2 * nodes[first + k].mobility
        if weights[k] > 0.1:
            rub(nodes[first + k], other, nearer / h)
    most = nodes[first + heaviest(weights)]
    light = borne(near, far, normal[1], own, others)
    firm = borne(most, most, -normal[1], others, own)
    weight = light * own + firm * others
    if weight == 0.0:
        return
    _feel(links, n, other, max(nearer, 0.0) / h, weight, (at, normal), moment, log)
    stopped = min(depth, max(nearer, 0.0))
    parted = min(depth - stopped, slack)
    friction = 0.5 * (one.friction + other.friction)
    move = times(
        1.0 / weight, plus(times(stopped, normal), rubbed(went, normal, friction * stopped))
    )
    part = times(parted / weight, normal)
    back = (0.0, 0.0, 0.0)
    if one.bounciness > 0.0 and nearer > 2.0 * WAKE_SPEED * h:
        back = times((one.bounciness * nearer + nearer - stopped) / weight, normal)
    move_node(i, light * i.mobility * (1.0 - t if t > 0.0 else 1.0), move, part, back)
    if t > 0.0:
        move_node(j, light * j.mobility * t, move, part, back)
    for k in range(8):
        corner = nodes[first + k]
        move_node(corner, -firm * corner.mobility * weights[k], move, part, back)


@inlined
def _feel(
    links: Records,
    n: int,
    box: Record,
    speed: float,
    weight: float,
    where: tuple[Vector, Vector],
    moment: float,
    log: TouchLog,
) -> None:
    """Let a link and the box's first edge know of one another."""
    link, edge = links[n], links[box.links[0]]
    energy = 0.5 * speed * speed / weight
    if (link.touched_owner != edge.owner or link.age[0] > PAUSE) and speed > ABOVE:
        log_touch(log, moment, (n, box.links[0]), where[0], where[1], (speed, energy))
    sense(link, box.links[0], edge.owner, energy)
    sense(edge, n, link.owner, energy)
