"""Floor: nodes and links that come into the terrain are moved out of it.

Each is a row of balls, met by the triangles of the terrain one after the other. What came into
the ground in this sub-step is taken out of its velocity, with Coulomb's friction across; what
was in it before is not. What touches is damped in the next sub-step.

Source: Horswill 2008, "Friction, drag and damping".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.events import Log, note
from pipeline.simulation.characters.layout import LANDING, LOCKED, TERRAIN, Crowd
from pipeline.simulation.characters.touching import LEAST_BOUNCE, PARTING
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.grid import Grid, around, highest, pieces, surface, triangle
from pipeline.simulation.dynamics.rounding import nearest
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

APART = 0.08
"""Distance of the balls along a link, about [m]."""

MOST = 5
"""Of them between its ends."""

SLACK = 1e-3
"""Gap at which somebody still stands on the ground [m]."""

DEEPEST = 1.0
"""Depth of which the nearest triangle is looked for [m]."""

TINY = 1e-12


@compiled
def stand(
    crowd: Crowd, owner: Record, grid: Grid, level: bool, h: float, moment: float, log: Log
) -> None:
    """Move one character out of the ground, which is a level plane or is not."""
    reach = SLACK
    middle = (0.5 * (owner.low[0] + owner.high[0]), 0.5 * (owner.low[2] + owner.high[2]))
    half = 0.5 * math.hypot(owner.high[0] - owner.low[0], owner.high[2] - owner.low[2])
    if owner.low[1] > highest(grid.frame, grid.tops, middle[0], middle[1], half) + reach:
        return
    first = owner.nodes[0]
    for i in range(first, first + owner.nodes[1]):
        _meet(crowd, owner, grid, (i, i), 0.0, crowd.radius[i], level, h, moment, log)
    if level:
        # On a plane links that end above it lie above it.
        return
    first = owner.links[0]
    for n in range(first, first + owner.links[1]):
        i, j = crowd.ends[n, 0], crowd.ends[n, 1]
        if crowd.girth[n] == 0.0 or i == j:
            continue
        parts = min(int(crowd.reach[n, 0] / APART), MOST)
        for k in range(1, parts):
            _meet(crowd, owner, grid, (i, j), k / parts, crowd.girth[n], level, h, moment, log)


@compiled
def _meet(
    crowd: Crowd,
    owner: Record,
    grid: Grid,
    ends: tuple[int, int],
    t: float,
    radius: float,
    level: bool,
    h: float,
    moment: float,
    log: Log,
) -> None:
    """Move a ball on the way from one node to another out of the ground."""
    at = _between(crowd.p, ends, t)
    frame = grid.frame
    if level:
        gap = at[1] - grid.vertices[0, 1] - radius
        _press(crowd, owner, ends, t, gap, (0.0, 1.0, 0.0), h, moment, log)
        return
    if at[1] - radius - SLACK > highest(frame, grid.tops, at[0], at[2], radius):
        return
    height, _ = surface(frame, grid.vertices, at[0], at[2])
    above = at[1] > height
    reach = radius + SLACK if above else min(max(height - at[1], radius), DEEPEST)
    if not above:
        _dig_out(crowd, owner, grid, ends, t, radius, reach, h, moment, log)
        return
    i, i_last, j, j_last = around(frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for piece in range(pieces(frame)):
                at = _between(crowd.p, ends, t)
                place = nearest(at, triangle(grid, line, column, piece))
                away = minus(at, place)
                far = length(away)
                if TINY < far < reach:
                    n = times(1.0 / far, away)
                    _press(crowd, owner, ends, t, far - radius, n, h, moment, log)


@compiled
def _dig_out(
    crowd: Crowd,
    owner: Record,
    grid: Grid,
    ends: tuple[int, int],
    t: float,
    radius: float,
    reach: float,
    h: float,
    moment: float,
    log: Log,
) -> None:
    """Move a ball whose middle is below the ground towards the nearest triangle."""
    at = _between(crowd.p, ends, t)
    least, normal = 1e300, (0.0, 1.0, 0.0)
    i, i_last, j, j_last = around(grid.frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for piece in range(pieces(grid.frame)):
                corners = triangle(grid, line, column, piece)
                far = length(minus(at, nearest(at, corners)))
                if far < least:
                    a, b, c = corners
                    up = cross(minus(b, a), minus(c, a))
                    least, normal = far, times(1.0 / length(up), up)
    if least < 1e299:
        _press(crowd, owner, ends, t, -least - radius, normal, h, moment, log)


@compiled
def _between(p: Crowd, ends: tuple[int, int], t: float) -> Vector:
    a = row(p, ends[0])
    return a if t == 0.0 else plus(times(1.0 - t, a), times(t, row(p, ends[1])))


@compiled
def _press(
    crowd: Crowd,
    owner: Record,
    ends: tuple[int, int],
    t: float,
    gap: float,
    n: Vector,
    h: float,
    moment: float,
    log: Log,
) -> None:
    """Move a place on a link along a normal if it is in the ground, and rub it across."""
    i, j = ends
    if gap > SLACK:
        return
    _touch(crowd, owner, i, j, t)
    depth = -gap
    w_i, w_j = crowd.give[i], crowd.give[j]
    weight = w_i if t == 0.0 else (1.0 - t) ** 2 * w_i + t * t * w_j
    if depth <= 0.0 or weight == 0.0:
        return
    went = minus(_between(crowd.p, ends, t), _between(crowd.before, ends, t))
    nearer = max(-dot(went, n), 0.0)
    _tell(crowd, i, j, n, nearer / h, weight, moment, log)
    stopped = min(depth, nearer)
    parted = min(depth - stopped, PARTING * h)
    along = minus(went, times(dot(went, n), n))
    size = length(along)
    rub = 0.0
    if size > TINY:
        rub = min(owner.friction * stopped / size, 1.0)
    move = minus(times(stopped, n), times(rub, along))
    back = 0.0
    if owner.bounciness > 0.0 and nearer > LEAST_BOUNCE * h:
        back = owner.bounciness * nearer + nearer - stopped
    for end in range(1 if t == 0.0 else 2):
        node = i if end == 0 else j
        share = 1.0 if t == 0.0 else ((1.0 - t) * w_i if end == 0 else t * w_j) / weight
        for k in range(3):
            crowd.p[node, k] += share * (move[k] + parted * n[k])
            crowd.before[node, k] += share * (parted - back) * n[k]


@compiled
def _touch(crowd: Crowd, owner: Record, i: int, j: int, t: float) -> None:
    """Let a node know that it touches the ground; lock it if it waits for that."""
    node = i if t < 0.5 else j
    crowd.grounded[node] = owner.ground
    if t == 0.0 and crowd.lock[i] == LANDING:
        crowd.lock[i] = LOCKED
        for k in range(3):
            crowd.place[i, k] = crowd.p[i, k]
        crowd.give[i] = 0.0


@compiled
def _tell(
    crowd: Crowd,
    i: int,
    j: int,
    n: Vector,
    speed: float,
    weight: float,
    moment: float,
    log: Log,
) -> None:
    """Let a link know that it touches the ground."""
    link = crowd.link_of[i]
    energy = 0.5 * speed * speed / weight
    if crowd.age[link, 1] > log.pause and speed > log.above:
        note(log, moment, link, TERRAIN, row(crowd.p, i), n, speed, energy)
    if crowd.age[link, 0] > 0.0:
        crowd.touched[link] = TERRAIN
    crowd.energy[link] = max(crowd.energy[link], energy)
    crowd.age[link, 1] = 0.0
