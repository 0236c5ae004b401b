"""Terrain contacts: nodes and links that come into the ground are moved out of it.

Each is a row of balls. A ball meets the nearest point of the terrain, and then what lies in front
of it, with Coulomb's friction across (`dynamics.nearest_ground`). Two points that are equally near
act together, so that the order of the triangles does not decide to which side a ball is pushed.
What touches the ground is damped in the next sub-step.

Source: Horswill 2008, "Friction, drag and damping".
"""

from __future__ import annotations

from pipeline.simulation.characters.body_arrays import LANDING, LOCKED, NOBODY, TERRAIN
from pipeline.simulation.characters.contact_response import (
    MIN_BOUNCE_SPEED,
    MIN_TOUCH_SPEED,
    TOUCH_PAUSE,
    SubStep,
    TouchLog,
    ball_count,
    friction_move,
    log_touch,
    place_between,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.nearest_ground import (
    BEHIND_PLANE,
    EQUAL_DISTANCE,
    NO_PLANES,
    OPPOSITE_NORMALS,
    mean_normal,
    nearest_above,
    nearest_below,
    with_plane,
)
from pipeline.simulation.dynamics.terrain_grid import Grid, highest_around, surface_at
from pipeline.simulation.dynamics.vectors import (
    Vector,
    dot,
    minus,
    plus,
    set_triple,
    times,
    triple,
)

MAX_BALLS = 5  # along a link, between its ends
GROUND_GAP = 1e-3  # at which a node still stands on the ground [m]
MAX_DEPTH = 1.0  # in which the nearest triangle is searched [m]
MAX_CONTACTS = 3  # of a ball with the ground: a corner of three planes


@inlined
def separate_from_ground(
    nodes: Records,
    links: Records,
    owner: Record,
    grid: Grid,
    level: bool,
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Move one character out of the ground, which may be a level plane."""
    first = owner.nodes[0]
    if level:
        height = grid.vertices[0, 1]
        for i in range(first, first + owner.nodes[1]):
            node = nodes[i]
            gap = node.p[1] - height - node.radius
            if gap < GROUND_GAP:
                _separate_place(node, node, links, owner, 0.0, (gap, 0.0, 1.0, 0.0), sub_step, log)
        # Links that end above a plane lie above it.
        return
    x, z = 0.5 * (owner.low[0] + owner.high[0]), 0.5 * (owner.low[2] + owner.high[2])
    half = 0.5 * max(owner.high[0] - owner.low[0], owner.high[2] - owner.low[2])
    if owner.low[1] - GROUND_GAP > highest_around(grid.frame, grid.tops, x, z, 1.5 * half):
        return
    for i in range(first, first + owner.nodes[1]):
        node = nodes[i]
        _meet_ground(node, node, links, owner, grid, 0.0, node.radius, sub_step, log)
    first = owner.links[0]
    for n in range(first, first + owner.links[1]):
        link = links[n]
        if link.radius == 0.0 or link.ends[0] == link.ends[1]:
            continue
        one, other = nodes[link.ends[0]], nodes[link.ends[1]]
        parts = ball_count(link, MAX_BALLS)
        for k in range(1, parts):
            _meet_ground(one, other, links, owner, grid, k / parts, link.radius, sub_step, log)


@compiled
def _meet_ground(
    one: Record,
    other: Record,
    links: Records,
    owner: Record,
    grid: Grid,
    t: float,
    radius: float,
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Move a ball, at a fraction t from one node to another, out of the ground."""
    at = place_between(one.p, other.p, t)
    frame = grid.frame
    if at[1] - radius - GROUND_GAP > highest_around(frame, grid.tops, at[0], at[2], radius):
        return
    height, _ = surface_at(frame, grid.vertices, at[0], at[2])
    if at[1] <= height:
        below = min(max(height - at[1], radius), MAX_DEPTH)
        least, normal = nearest_above(grid, at, below, EQUAL_DISTANCE * radius)
        where = (-least - radius, normal[0], normal[1], normal[2])
        _separate_place(one, other, links, owner, t, where, sub_step, log)
        return
    reach, behind, planes = radius + GROUND_GAP, BEHIND_PLANE * radius, NO_PLANES
    distance, away = nearest_below(grid, at, reach, planes, behind)
    for _ in range(MAX_CONTACTS):
        if distance >= reach:
            return
        n = times(1.0 / distance, away)
        planes = with_plane(planes, distance, n)
        next_distance, away = nearest_below(grid, at, reach, planes, behind)
        gap = distance - radius + dot(n, minus(place_between(one.p, other.p, t), at))
        if next_distance < min(reach, distance + EQUAL_DISTANCE * radius):
            next_n = times(1.0 / next_distance, away)
            planes = with_plane(planes, next_distance, next_n)
            n, cosine = mean_normal(plus(n, next_n))
            gap /= max(cosine, OPPOSITE_NORMALS)
            next_distance, away = nearest_below(grid, at, reach, planes, behind)
        where = (gap, n[0], n[1], n[2])
        _separate_place(one, other, links, owner, t, where, sub_step, log)
        distance = next_distance


@compiled
def _separate_place(
    one: Record,
    other: Record,
    links: Records,
    owner: Record,
    t: float,
    where: tuple[float, float, float, float],
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Move a place on a link out of the ground along a normal, with friction across.

    Args:
        one: node at the start of the link; both are the same for a node alone.
        other: node at its end.
        links: of all characters.
        owner: its character.
        t: fraction along the link.
        where: gap to the ground [m], and the normal.
        sub_step: the sub-step.
        log: of touches.
    """
    h, slack, moment = sub_step
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
    moved = minus(place_between(one.p, other.p, t), place_between(one.previous, other.previous, t))
    approach = max(-dot(moved, n), 0.0)
    _touch_ground(node, links[node.ground_link], n, approach / h, weight, moment, log)
    stopped = min(depth, approach)
    parted = min(depth - stopped, slack)
    move = plus(times(stopped, n), friction_move(moved, n, owner.friction * stopped))
    back = 0.0
    if owner.bounciness > 0.0 and approach > MIN_BOUNCE_SPEED * h:
        back = owner.bounciness * approach + approach - stopped
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
def _touch_ground(
    node: Record, link: Record, n: Vector, speed: float, weight: float, moment: float, log: TouchLog
) -> None:
    """Let a link sense that it touches the ground."""
    energy = 0.5 * speed * speed / weight
    if link.age[1] > TOUCH_PAUSE and speed > MIN_TOUCH_SPEED:
        log_touch(log, moment, (node.ground_link, TERRAIN), (triple(node.p), n), speed, energy)
    if link.age[0] > 0.0:
        link.touched, link.touched_owner = TERRAIN, NOBODY
    link.energy = max(link.energy, energy)
    link.age[1] = 0.0
