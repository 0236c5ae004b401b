"""Corners: the vertices of polyhedra that are over a terrain, or have come into it.

Above the ground a vertex is as far from it as from the plane under it. In it, it is as deep
as the nearest triangle is near: beside a wall the ground right above may be the wall, and yet
the vertex be below the floor at its foot, or be the floor of a ledge, and yet the wall be
nearer.
"""

from __future__ import annotations

from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.contacts import insert, insert_new
from pipeline.simulation.dynamics.grid import Grid, around, inside, pieces, surface, triangle
from pipeline.simulation.dynamics.rounding import nearest
from pipeline.simulation.dynamics.vectors import Vector, cross, dot, length, minus, row, times
from pipeline.simulation.spatial import Array

SHALLOW = 1e-6
"""Depth of a vertex that is told by the plane over it alone, in sizes of the body."""

BESIDE = 2e-4
"""How much farther than the nearest triangle one may be that a vertex lies at as well, in a
hollow, in sizes of the body."""

ALIKE = 1e-6
"""Part by which distances to one edge may differ."""


@compiled
def meet_corners(grid: Grid, body: Record, p: Vector, world: Array, slack: float) -> None:
    """Add the vertices of a body that are over the ground.

    Args:
        grid: the ground.
        body: the one that meets it.
        p: its place [m].
        world: (V, 3) its vertices [m].
        slack: gaps that are larger count for nothing [m].
    """
    for k in range(body.corners[1]):
        at = row(world, k)
        if inside(grid.frame, at[0], at[2]):
            height, normal = surface(grid.frame, grid.vertices, at[0], at[2])
            above = at[1] - height
            if -2.0 * body.reach <= above < -SHALLOW * body.size:
                _meet_sunk(grid, body, p, at, -above)
            elif above * normal[1] <= slack:
                insert(body, above * normal[1], normal, minus(at, p))


@compiled
def _meet_sunk(grid: Grid, body: Record, p: Vector, at: Vector, depth: float) -> None:
    """Add a vertex that is so far below the ground right above it."""
    least = depth
    # What is nearest is not farther than the ground above.
    i, i_last, j, j_last = around(grid.frame, at[0], at[2], depth)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for k in range(pieces(grid.frame)):
                least = min(least, length(minus(at, nearest(at, triangle(grid, line, column, k)))))
    reach = least + BESIDE * body.size
    i, i_last, j, j_last = around(grid.frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for k in range(pieces(grid.frame)):
                a, b, c = triangle(grid, line, column, k)
                away = length(minus(at, nearest(at, (a, b, c))))
                if away > reach:
                    continue
                up = cross(minus(b, a), minus(c, a))
                normal = times(1.0 / length(up), up)
                gap = dot(normal, minus(at, a))
                # In front of one plane and yet below another it lies in a hollow.
                if gap >= 0.0 or away <= least * (1.0 + ALIKE):
                    insert_new(body, gap, normal, minus(at, p))
