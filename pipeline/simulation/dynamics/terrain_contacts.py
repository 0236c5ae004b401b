"""Terrain contacts: where a body touches a terrain, or is about to.

Polyhedra touch with their vertices, and with facets and edges where the terrain is convex
(`terrain_edge_contacts`); balls with the nearest points of the ground. A body whose centre of mass
has left the terrain, or that came under it from the side, has no contacts.

Above the ground the gap of a vertex is its distance from the plane below. Inside, its depth is the
distance to the nearest triangle: beside a wall the ground straight above may be the wall while the
vertex is below the floor at its foot, or the floor of a ledge while the wall is nearer.

A ball ignores what lies behind the contact plane of a nearer contact, see `nearest_ground`.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.body_record import (
    Shapes,
    Workspace,
    clear_contacts,
    drop_equal_contacts,
    insert_contact,
    insert_new_contact,
    remove_contact,
)
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.nearest_ground import (
    BEHIND_PLANE,
    COINCIDENT,
    EQUAL_DISTANCE,
    NO_PLANES,
    distance_above,
    highest_of_cell,
    nearest_above,
    nearest_below,
    nearest_on_triangle,
    triangle_normal,
)
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


@compiled
def add_ball_contacts(grid: Grid, body: Record, p: Vector, slack: float) -> None:
    """Adds the contacts of a ball.

    Args:
        grid: the ground.
        body: the ball.
        p: its centre [m].
        slack: largest gap of a contact [m].
    """
    height, reach = surface_at(grid.frame, grid.vertices, p[0], p[2])[0], body.radius + slack
    if p[1] <= height:
        near = EQUAL_DISTANCE * body.radius
        least, normal = nearest_above(grid, p, height - p[1], near)
        insert_contact(body, -least - body.radius, normal, times(least, normal))
        return
    least, away = nearest_below(grid, p, reach, NO_PLANES, 0.0)
    if least < reach:
        normal = times(1.0 / least, away)
        insert_contact(body, least - body.radius, normal, times(-1.0, away))
        # What a contact hid that a nearer one has removed is found in the next pass.
        while _add_near_triangles(grid, body, p, reach):
            pass


@compiled
def _add_near_triangles(grid: Grid, body: Record, p: Vector, reach: float) -> bool:
    """Adds what a ball touches of the ground; returns whether contacts were removed."""
    i, i_last, j, j_last = cells_around(grid.frame, p[0], p[2], reach)
    removed = False
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            if highest_of_cell(grid, line, column) < p[1] - reach:
                continue
            for piece in range(triangles_per_cell(grid.frame)):
                away = minus(p, nearest_on_triangle(p, triangle(grid, line, column, piece)))
                distance = length(away)
                if COINCIDENT < distance < reach:
                    gap, normal = distance - body.radius, times(1.0 / distance, away)
                    removed = _insert_unhidden(body, gap, normal, times(-1.0, away)) or removed
    return removed


@compiled
def _insert_unhidden(body: Record, gap: float, normal: Vector, lever: Vector) -> bool:
    """Inserts a contact unless a nearer one hides it; returns whether it hid and removed others."""
    k, none, before = 0, BEHIND_PLANE * body.radius, body.count
    while k < body.count:
        apart = minus(lever, row(body.lever, k))
        if body.gap[k] <= gap:
            if dot(apart, row(body.normal, k)) <= none:
                return False
            k += 1
        elif -dot(apart, normal) <= none:
            remove_contact(body, k)
        else:
            k += 1
    removed = body.count < before
    insert_contact(body, gap, normal, lever)
    return removed


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
                    normal = triangle_normal((a, b, c))
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
    # The nearest triangle is no farther than the ground straight above.
    least = distance_above(grid, at, depth)
    reach = least + HOLLOW_TOLERANCE * body.size
    i, i_last, j, j_last = cells_around(grid.frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for k in range(triangles_per_cell(grid.frame)):
                a, b, c = triangle(grid, line, column, k)
                away = length(minus(at, nearest_on_triangle(at, (a, b, c))))
                if away > reach:
                    continue
                normal = triangle_normal((a, b, c))
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
    clear_contacts(body)
    if not is_over_grid(grid.frame, p[0], p[2]):
        return
    top = highest_around(grid.frame, grid.tops, p[0], p[2], body.reach + slack) + slack
    if p[1] - body.reach > top:
        return
    if body.radius > 0.0:
        add_ball_contacts(grid, body, p, slack)
    else:
        R = rotation(q)
        box, over = _vertices_in_world(grid.frame, shapes.corners, body, p, R, slack, room.world)
        if box[0][1] <= top:
            add_vertex_contacts(grid, body, p, room.world, slack)
            add_edge_contacts(grid, shapes, body, p, R, room, box, over, slack)
    drop_equal_contacts(body)


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
