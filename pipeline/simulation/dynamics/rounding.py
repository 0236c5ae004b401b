"""Balls on the triangles of a terrain: the nearest point of each, but for what is no corner.

Where two triangles lie in one plane, or fall away from an edge, the nearest point of the
one that is farther lies behind the plane in which the ball touches the nearer one, and says
nothing that this does not. Such points would be corners that are felt and not there.

Source: Ericson 2005, 5.1.5 (closest point on a triangle).
"""

from __future__ import annotations

from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.contacts import insert, remove
from pipeline.simulation.dynamics.grid import Grid, Triangle, around, pieces, surface, triangle
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

BEHIND = 1e-7
"""Height above a plane that is none, in radii."""


@compiled
def meet_ball(grid: Grid, body: Record, p: Vector, slack: float) -> None:
    """Add the contacts of a ball.

    Args:
        grid: the ground.
        body: the ball.
        p: its middle [m].
        slack: gaps that are larger count for nothing [m].
    """
    frame, vertices = grid.frame, grid.vertices
    reach = body.radius + slack
    i, i_last, j, j_last = around(frame, p[0], p[2], reach)
    # On which side of a triangle's plane a middle lies says nothing beyond its sides.
    above = p[1] > surface(frame, vertices, p[0], p[2])[0]
    low = p[1] - reach
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            k = line * (frame.n_x + 1) + column
            one = max(vertices[k, 1], vertices[k + 1, 1])
            k += frame.n_x + 1
            if max(one, max(vertices[k, 1], vertices[k + 1, 1])) < low:
                continue
            for piece in range(pieces(frame)):
                _meet(body, p, triangle(grid, line, column, piece), above, slack)


@compiled
def _meet(body: Record, p: Vector, corners: Triangle, above: bool, slack: float) -> None:
    """Add the contact of a ball with a triangle, if it is near."""
    place = nearest(p, corners)
    away = minus(p, place)
    distance = length(away)
    if above and distance > 0.0:
        gap, normal = distance - body.radius, times(1.0 / distance, away)
    else:
        a, b, c = corners
        up = cross(minus(b, a), minus(c, a))
        gap, normal = -distance - body.radius, times(1.0 / length(up), up)
    if gap <= slack:
        _insert(body, gap, normal, times(-1.0, away))


@compiled
def _insert(body: Record, gap: float, normal: Vector, lever: Vector) -> None:
    """Add a contact unless a nearer one hides it, and take away those that it hides."""
    k, none = 0, BEHIND * body.radius
    while k < body.count:
        apart = minus(lever, row(body.lever, k))
        if body.gap[k] <= gap:
            if dot(apart, row(body.normal, k)) <= none:
                return
            k += 1
        elif -dot(apart, normal) <= none:
            remove(body, k)
        else:
            k += 1
    insert(body, gap, normal, lever)


@compiled
def nearest(point: Vector, corners: Triangle) -> Vector:
    """Return the nearest point of a triangle to a point."""
    a, b, c = corners
    up = cross(minus(b, a), minus(c, a))
    best = 1e300
    result = a
    inside = True
    for start, end in ((a, b), (b, c), (c, a)):
        side, way = minus(end, start), minus(point, start)
        t = min(max(dot(way, side) / dot(side, side), 0.0), 1.0)
        place = plus(start, times(t, side))
        away = minus(point, place)
        if dot(away, away) < best:
            best, result = dot(away, away), place
        inside = inside and dot(cross(side, way), up) >= 0.0
    if inside:
        result = minus(point, times(dot(minus(point, a), up) / dot(up, up), up))
    return result
