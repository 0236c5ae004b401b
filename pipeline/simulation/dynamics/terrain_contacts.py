"""Terrain contacts: where a body touches a terrain, or is about to.

Polyhedra touch with their vertices, and with facets and edges where the terrain is convex
(`terrain_edge_contacts`); balls with the nearest points of triangles. A body whose centre of mass
has left the terrain, or that came under it from the side, has no contacts.

Above the ground the gap of a vertex is its distance from the plane below. Inside, its depth is the
distance to the nearest triangle: beside a wall the ground straight above may be the wall while the
vertex is below the floor at its foot, or the floor of a ledge while the wall is nearer.

A ball ignores the nearest point of a farther triangle that lies behind the contact plane of a
nearer one: on flat or convex ground it is a corner that is not there.

Source: Ericson 2005, 5.1.5 (closest point on a triangle).
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.body_record import (
    Shapes,
    Workspace,
    insert_contact,
    insert_new_contact,
    remove_contact,
)
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.terrain_edge_contacts import Box, add_edge_contacts
from pipeline.simulation.dynamics.terrain_grid import (
    Grid,
    Spans,
    Triangle,
    cell_span,
    cells_around,
    highest_around,
    is_near_crease,
    is_over_grid,
    surface_at,
    to_grid_frame,
    triangle,
    triangles_per_cell,
)
from pipeline.simulation.dynamics.vectors import (
    Quaternion,
    Rows,
    Vector,
    cross,
    dot,
    length,
    minus,
    plus,
    put,
    rotation,
    row,
    times,
    turned,
)
from pipeline.simulation.spatial import Array

BEHIND_PLANE = 1e-10
"""Height above a plane that counts as zero, in radii."""


@compiled
def add_ball_contacts(grid: Grid, body: Record, p: Vector, slack: float) -> None:
    """Adds the contacts of a ball.

    Args:
        grid: the ground.
        body: the ball.
        p: its centre [m].
        slack: largest gap of a contact [m].
    """
    frame, vertices = grid.frame, grid.vertices
    reach = body.radius + slack
    i, i_last, j, j_last = cells_around(frame, p[0], p[2], reach)
    # The side of a triangle's plane tells nothing beyond the edges of the triangle.
    above = p[1] > surface_at(frame, vertices, p[0], p[2])[0]
    low = p[1] - reach
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            k = line * (frame.n_x + 1) + column
            one = max(vertices[k, 1], vertices[k + 1, 1])
            k += frame.n_x + 1
            if max(one, max(vertices[k, 1], vertices[k + 1, 1])) < low:
                continue
            for piece in range(triangles_per_cell(frame)):
                _add_ball_triangle(body, p, triangle(grid, line, column, piece), above, slack)


@compiled
def _add_ball_triangle(
    body: Record, p: Vector, corners: Triangle, above: bool, slack: float
) -> None:
    """Adds the contact of a ball with a triangle, if it is near."""
    away = minus(p, nearest_on_triangle(p, corners))
    distance = length(away)
    if above and distance > 0.0:
        gap, normal = distance - body.radius, times(1.0 / distance, away)
    else:
        a, b, c = corners
        up = cross(minus(b, a), minus(c, a))
        gap, normal = -distance - body.radius, times(1.0 / length(up), up)
    if gap <= slack:
        _insert_unhidden(body, gap, normal, times(-1.0, away))


@compiled
def _insert_unhidden(body: Record, gap: float, normal: Vector, lever: Vector) -> None:
    """Inserts a contact unless a nearer one hides it; removes those that it hides."""
    k, none = 0, BEHIND_PLANE * body.radius
    while k < body.count:
        apart = minus(lever, row(body.lever, k))
        if body.gap[k] <= gap:
            if dot(apart, row(body.normal, k)) <= none:
                return
            k += 1
        elif -dot(apart, normal) <= none:
            remove_contact(body, k)
        else:
            k += 1
    insert_contact(body, gap, normal, lever)


@compiled
def nearest_on_triangle(point: Vector, corners: Triangle) -> Vector:
    """Returns the point of a triangle nearest to a point."""
    a, b, c = corners
    up = cross(minus(b, a), minus(c, a))
    best = 1e300
    result = a
    is_over_grid = True
    for start, end in ((a, b), (b, c), (c, a)):
        side, way = minus(end, start), minus(point, start)
        t = min(max(dot(way, side) / dot(side, side), 0.0), 1.0)
        place = plus(start, times(t, side))
        away = minus(point, place)
        if dot(away, away) < best:
            best, result = dot(away, away), place
        is_over_grid = is_over_grid and dot(cross(side, way), up) >= 0.0
    if is_over_grid:
        result = minus(point, times(dot(minus(point, a), up) / dot(up, up), up))
    return result


SHALLOW_DEPTH = 1e-6
"""Depth of a vertex up to which the plane above it alone counts, in sizes of the body."""

HOLLOW_TOLERANCE = 2e-4
"""Excess distance of further triangles that touch the same vertex in a hollow, in sizes
of the body."""

CREASE_DISTANCE = 1e-6
"""Distance from a crease at which a vertex is over both of its sides, in cells."""

SAME_DISTANCE = 1e-6
"""Difference of distances to two triangles that count as equally near, in sizes of the body."""


@compiled
def add_vertex_contacts(grid: Grid, body: Record, p: Vector, world: Array, slack: float) -> None:
    """Adds the vertices of a body that are over the ground.

    Args:
        grid: the ground.
        body: the body.
        p: its position [m].
        world: (V, 3) its vertices in the world [m].
        slack: largest gap of a contact [m].
    """
    for k in range(body.corners[1]):
        at = row(world, k)
        if is_over_grid(grid.frame, at[0], at[2]):
            height, normal = surface_at(grid.frame, grid.vertices, at[0], at[2])
            above = at[1] - height
            if -2.0 * body.reach <= above < -SHALLOW_DEPTH * body.size:
                _add_sunk_vertex(grid, body, p, at, -above)
            elif above * normal[1] <= slack:
                insert_contact(body, above * normal[1], normal, minus(at, p))
                if is_near_crease(grid.frame, at[0], at[2], CREASE_DISTANCE):
                    _add_planes_beside(grid, body, p, at)


@compiled
def _add_planes_beside(grid: Grid, body: Record, p: Vector, at: Vector) -> None:
    """Adds the planes of all triangles that a vertex is over, to within `CREASE_DISTANCE`.

    At a crease rounding must not decide to which side the vertex is pushed.
    """
    frame = grid.frame
    reach = CREASE_DISTANCE * max(frame.size_x / frame.n_x, frame.size_z / frame.n_z)
    i, i_last, j, j_last = cells_around(frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for k in range(triangles_per_cell(frame)):
                a, b, c = triangle(grid, line, column, k)
                if _is_over_triangle(at, (a, b, c), reach):
                    up = cross(minus(b, a), minus(c, a))
                    normal = times(1.0 / length(up), up)
                    insert_new_contact(body, dot(normal, minus(at, a)), normal, minus(at, p))


@compiled
def _is_over_triangle(at: Vector, corners: Triangle, reach: float) -> bool:
    """Returns whether a place is straight above or below a triangle, or `reach` [m] beside it."""
    a, b, c = corners
    for start, end in ((a, b), (b, c), (c, a)):
        x, z = end[0] - start[0], end[2] - start[2]
        # Counter-clockwise from above is from Z to X.
        inside = z * (at[0] - start[0]) - x * (at[2] - start[2])
        if inside < -reach * math.sqrt(x * x + z * z):
            return False
    return True


@compiled
def _add_sunk_vertex(grid: Grid, body: Record, p: Vector, at: Vector, depth: float) -> None:
    """Adds a vertex at `depth` below the ground straight above it."""
    least = depth
    # The nearest triangle is no farther than the ground straight above.
    i, i_last, j, j_last = cells_around(grid.frame, at[0], at[2], depth)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for k in range(triangles_per_cell(grid.frame)):
                least = min(
                    least,
                    length(minus(at, nearest_on_triangle(at, triangle(grid, line, column, k)))),
                )
    reach = least + HOLLOW_TOLERANCE * body.size
    i, i_last, j, j_last = cells_around(grid.frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for k in range(triangles_per_cell(grid.frame)):
                a, b, c = triangle(grid, line, column, k)
                away = length(minus(at, nearest_on_triangle(at, (a, b, c))))
                if away > reach:
                    continue
                up = cross(minus(b, a), minus(c, a))
                normal = times(1.0 / length(up), up)
                gap = dot(normal, minus(at, a))
                # In a hollow a vertex is in front of one plane and below another.
                if gap >= 0.0 or away <= least + SAME_DISTANCE * body.size:
                    insert_new_contact(body, gap, normal, minus(at, p))


@compiled
def find_body_contacts(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    p: Vector,
    q: Quaternion,
    slack: float,
    room: Workspace,
) -> None:
    """Finds the contacts of a body.

    Args:
        grid: the ground.
        shapes: of all bodies.
        body: its contacts are replaced.
        p: position to test [m].
        q: attitude to test.
        slack: gaps up to this are reported [m].
        room: workspace.
    """
    body.count = 0
    if not is_over_grid(grid.frame, p[0], p[2]):
        return
    top = highest_around(grid.frame, grid.tops, p[0], p[2], body.reach + slack) + slack
    if p[1] - body.reach > top:
        return
    if body.radius > 0.0:
        add_ball_contacts(grid, body, p, slack)
        return
    R = rotation(q)
    box, over = _vertices_in_world(grid.frame, shapes.corners, body, p, R, slack, room.world)
    if box[0][1] <= top:
        add_vertex_contacts(grid, body, p, room.world, slack)
        add_edge_contacts(grid, shapes, body, p, R, room, box, over, slack)


@compiled
def _vertices_in_world(
    frame: Record, corners: Array, body: Record, p: Vector, R: Rows, slack: float, world: Array
) -> tuple[Box, Spans]:
    """Writes the vertices of a body in the world; returns their bounding box and its cells."""
    low, high = (np.inf, np.inf, np.inf), (-np.inf, -np.inf, -np.inf)
    u_low, u_high, v_low, v_high = np.inf, -np.inf, np.inf, -np.inf
    first, count = body.corners
    for k in range(count):
        at = plus(p, turned(R, row(corners, first + k)))
        put(world, k, at)
        low = (min(low[0], at[0]), min(low[1], at[1]), min(low[2], at[2]))
        high = (max(high[0], at[0]), max(high[1], at[1]), max(high[2], at[2]))
        u, v = to_grid_frame(frame, at[0], at[2])
        u_low, u_high, v_low, v_high = min(u_low, u), max(u_high, u), min(v_low, v), max(v_high, v)
    i, i_last = cell_span(u_low - slack, u_high + slack, frame.size_x, frame.n_x)
    j, j_last = cell_span(v_low - slack, v_high + slack, frame.size_z, frame.n_z)
    return (low, high), (i, i_last, j, j_last)


@compiled
def is_under_ground(grid: Grid, body: Record, p: Vector) -> bool:
    """Returns whether a body at p is wholly below the ground, entered from the side."""
    if not is_over_grid(grid.frame, p[0], p[2]):
        return False
    return p[1] < surface_at(grid.frame, grid.vertices, p[0], p[2])[0] - 2.0 * body.reach
