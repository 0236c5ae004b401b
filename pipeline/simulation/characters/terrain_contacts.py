"""Terrain contacts."""

from __future__ import annotations

from pipeline.simulation.characters.body_arrays import LANDING, LOCKED, NOBODY, TERRAIN
from pipeline.simulation.characters.contact_response import (
    ABOVE,
    LEAST_BOUNCE,
    PAUSE,
    TouchLog,
    log_touch,
    rubbed,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.terrain_contacts import nearest_on_triangle
from pipeline.simulation.dynamics.terrain_grid import (
    Grid,
    cells_around,
    highest_around,
    surface_at,
    triangle,
    triangles_per_cell,
)
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
from pipeline.simulation.spatial import Array

APART = 0.08
"""Distance of the balls along a link, about [m]."""

MOST = 5
"""Of them between its ends."""

SLACK = 1e-3
"""Gap at which somebody still stands on the ground [m]."""

DEEPEST = 1.0
"""Depth of which the nearest triangle is looked for [m]."""

TINY = 1e-12


@inlined
def stand(
    nodes: Records,
    links: Records,
    owner: Record,
    grid: Grid,
    level: bool,
    h: float,
    slack: float,
    moment: float,
    log: TouchLog,
) -> None:
    """Move one character out of the ground, which is a level plane or is not."""
    first = owner.nodes[0]
    if level:
        height = grid.vertices[0, 1]
        for i in range(first, first + owner.nodes[1]):
            node = nodes[i]
            gap = node.p[1] - height - node.radius
            if gap < SLACK:
                _press(node, node, links, owner, 0.0, (gap, 0.0, 1.0, 0.0), h, slack, moment, log)
        # Links that end above a plane lie above it.
        return
    x, z = 0.5 * (owner.low[0] + owner.high[0]), 0.5 * (owner.low[2] + owner.high[2])
    half = 0.5 * max(owner.high[0] - owner.low[0], owner.high[2] - owner.low[2])
    if owner.low[1] - SLACK > highest_around(grid.frame, grid.tops, x, z, 1.5 * half):
        return
    for i in range(first, first + owner.nodes[1]):
        node = nodes[i]
        _meet(node, node, links, owner, grid, 0.0, node.radius, h, slack, moment, log)
    first = owner.links[0]
    for n in range(first, first + owner.links[1]):
        link = links[n]
        if link.radius == 0.0 or link.ends[0] == link.ends[1]:
            continue
        one, other = nodes[link.ends[0]], nodes[link.ends[1]]
        parts = min(int(link.length_limits[0] / APART) + 1, MOST)
        for k in range(1, parts):
            _meet(one, other, links, owner, grid, k / parts, link.radius, h, slack, moment, log)


@compiled
def _meet(
    one: Record,
    other: Record,
    links: Records,
    owner: Record,
    grid: Grid,
    t: float,
    radius: float,
    h: float,
    slack: float,
    moment: float,
    log: TouchLog,
) -> None:
    """Move a ball on the way from one node to another out of the ground."""
    at = _between(one.p, other.p, t)
    frame = grid.frame
    if at[1] - radius - SLACK > highest_around(frame, grid.tops, at[0], at[2], radius):
        return
    height, _ = surface_at(frame, grid.vertices, at[0], at[2])
    if at[1] <= height:
        least, normal = _way_out(grid, at, max(height - at[1], radius))
        where = (-least - radius, normal[0], normal[1], normal[2])
        _press(one, other, links, owner, t, where, h, slack, moment, log)
        return
    reach = radius + SLACK
    i, i_last, j, j_last = cells_around(frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for piece in range(triangles_per_cell(frame)):
                at = _between(one.p, other.p, t)
                away = minus(at, nearest_on_triangle(at, triangle(grid, line, column, piece)))
                far = length(away)
                if TINY < far < reach:
                    n = times(1.0 / far, away)
                    where = (far - radius, n[0], n[1], n[2])
                    _press(one, other, links, owner, t, where, h, slack, moment, log)


@compiled
def _way_out(grid: Grid, at: Vector, reach: float) -> tuple[float, Vector]:
    """Return how far a place below the ground is from the nearest triangle, and its normal."""
    least, normal = min(reach, DEEPEST), (0.0, 1.0, 0.0)
    i, i_last, j, j_last = cells_around(grid.frame, at[0], at[2], least)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for piece in range(triangles_per_cell(grid.frame)):
                corners = triangle(grid, line, column, piece)
                far = length(minus(at, nearest_on_triangle(at, corners)))
                if far < least:
                    a, b, c = corners
                    up = cross(minus(b, a), minus(c, a))
                    least, normal = far, times(1.0 / length(up), up)
    return least, normal


@inlined
def _between(a: Array, b: Array, t: float) -> Vector:
    return plus(times(1.0 - t, triple(a)), times(t, triple(b)))


@compiled
def _press(
    one: Record,
    other: Record,
    links: Records,
    owner: Record,
    t: float,
    where: tuple[float, float, float, float],
    h: float,
    slack: float,
    moment: float,
    log: TouchLog,
) -> None:
    """Move a place on a link along a normal if it is in the ground, and rub it across.

    Args:
        one: the node at the begin of the link; both are one for a node alone.
        other: the node at its end.
        links: of all characters.
        owner: whose.
        t: where on the link, from 0 to 1.
        where: gap between it and the ground [m], and the normal.
        h: the sub-step [s].
        slack: how far what was in one another may part [m].
        moment: of the step that has gone.
        log: of what touched.
    """
    depth, n = -where[0], (where[1], where[2], where[3])
    node = one if t < 0.5 else other
    node.ground_damping = owner.ground_damping
    if t == 0.0 and node.lock == LANDING:
        node.lock, node.mobility = LOCKED, 0.0
        set_triple(node.lock_place, triple(node.p))
    weight = one.mobility if t == 0.0 else (1.0 - t) ** 2 * one.mobility + t * t * other.mobility
    if depth <= 0.0 or weight == 0.0:
        return
    owner.penetration = max(owner.penetration, depth)
    went = minus(_between(one.p, other.p, t), _between(one.previous, other.previous, t))
    nearer = max(-dot(went, n), 0.0)
    _tell(node, links[node.ground_link], n, nearer / h, weight, moment, log)
    stopped = min(depth, nearer)
    parted = min(depth - stopped, slack)
    move = plus(times(stopped, n), rubbed(went, n, owner.friction * stopped))
    back = 0.0
    if owner.bounciness > 0.0 and nearer > LEAST_BOUNCE * h:
        back = owner.bounciness * nearer + nearer - stopped
    share = 1.0 if t == 0.0 else (1.0 - t) * one.mobility / weight
    for k in range(3):
        one.p[k] += share * (move[k] + parted * n[k])
        one.previous[k] += share * (parted - back) * n[k]
    if t > 0.0:
        share = t * other.mobility / weight
        for k in range(3):
            other.p[k] += share * (move[k] + parted * n[k])
            other.previous[k] += share * (parted - back) * n[k]


@inlined
def _tell(
    node: Record, link: Record, n: Vector, speed: float, weight: float, moment: float, log: TouchLog
) -> None:
    """Let a link know that it touches the ground."""
    energy = 0.5 * speed * speed / weight
    if link.age[1] > PAUSE and speed > ABOVE:
        log_touch(log, moment, (node.ground_link, TERRAIN), triple(node.p), n, (speed, energy))
    if link.age[0] > 0.0:
        link.touched, link.touched_owner = TERRAIN, NOBODY
    link.energy = max(link.energy, energy)
    link.age[1] = 0.0
