"""Nearest ground: the points of a terrain nearest to a place, from above and from below.

A ball touches the nearest point of the terrain, and then what lies in front of it: farther points
behind the contact plane of a nearer one are corners that are not there, on flat or convex ground.
Points are taken by their distance, so the order of the triangles decides nothing. Below the
ground the nearest triangle counts, and its normal.

Source: Ericson 2005, 5.1.5 (closest point on a triangle).
"""

from __future__ import annotations

from pipeline.simulation.dynamics.compiled import compiled
from pipeline.simulation.dynamics.terrain_grid import (
    Grid,
    Triangle,
    cells_around,
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
    times,
)

BEHIND_PLANE = 1e-10
"""Height above a plane that counts as zero, in radii of a ball."""

EQUAL_DISTANCE = 1e-6
"""Difference of distances that counts as zero, in radii of a ball."""

SAME_NORMAL = 1e-12
"""1 - n · n' of normals that count as one."""

OPPOSITE_NORMALS = 1e-3
"""Length of the sum of normals that counts as zero."""

COINCIDENT = 1e-12
"""Distance at which a place lies on the ground [m]."""

Plane = tuple[float, float, float, float]
Planes = tuple[Plane, Plane, Plane, Plane]
"""Normals, and distances along them from a place [m]."""

NO_PLANE = (0.0, 0.0, 0.0, -1.0)
NO_PLANES = (NO_PLANE, NO_PLANE, NO_PLANE, NO_PLANE)
"""Planes that everything lies in front of."""


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


@compiled
def triangle_normal(corners: Triangle) -> Vector:
    """Returns the upward unit normal of a triangle."""
    a, b, c = corners
    up = cross(minus(b, a), minus(c, a))
    return times(1.0 / length(up), up)


@compiled
def highest_of_cell(grid: Grid, line: int, column: int) -> float:
    """Returns the greatest height of a cell [m]."""
    vertices, k = grid.vertices, line * (grid.frame.n_x + 1) + column
    top = max(vertices[k, 1], vertices[k + 1, 1])
    k += grid.frame.n_x + 1
    return max(top, max(vertices[k, 1], vertices[k + 1, 1]))


@compiled
def nearest_below(
    grid: Grid, at: Vector, reach: float, planes: Planes, behind: float
) -> tuple[float, Vector]:
    """Returns the distance of the nearest ground in front of planes, and the way from it (3,) [m].

    Args:
        grid: the ground.
        at: a place above it [m].
        reach: largest distance, returned if there is none [m].
        planes: normals, and distances along them from `at` [m].
        behind: height above a plane that counts as zero [m].
    """
    least, away, frame = reach, (0.0, reach, 0.0), grid.frame
    i, i_last, j, j_last = cells_around(frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            if highest_of_cell(grid, line, column) < at[1] - least:
                continue
            for piece in range(triangles_per_cell(frame)):
                offset = minus(at, nearest_on_triangle(at, triangle(grid, line, column, piece)))
                distance = length(offset)
                if COINCIDENT < distance < least:
                    one = min(_height_over(planes[0], offset), _height_over(planes[1], offset))
                    two = min(_height_over(planes[2], offset), _height_over(planes[3], offset))
                    if min(one, two) > behind:
                        least, away = distance, offset
    return least, away


@compiled
def with_plane(planes: Planes, distance: float, n: Vector) -> Planes:
    """Returns the planes and that of a contact; the oldest is dropped."""
    return (n[0], n[1], n[2], -distance), planes[0], planes[1], planes[2]


@compiled
def _height_over(plane: Plane, offset: Vector) -> float:
    """Returns the height over a plane of what lies at minus `offset` [m]."""
    return -(plane[0] * offset[0] + plane[1] * offset[1] + plane[2] * offset[2]) - plane[3]


@compiled
def distance_above(grid: Grid, at: Vector, reach: float) -> float:
    """Returns the distance of the ground nearest to a place below it, at most `reach` [m]."""
    least = reach
    i, i_last, j, j_last = cells_around(grid.frame, at[0], at[2], reach)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for piece in range(triangles_per_cell(grid.frame)):
                nearest = nearest_on_triangle(at, triangle(grid, line, column, piece))
                least = min(least, length(minus(at, nearest)))
    return least


@compiled
def nearest_above(grid: Grid, at: Vector, reach: float, near: float) -> tuple[float, Vector]:
    """Returns the distance of a place below the ground from it, and the normal.

    Of planes that are equally near it is the mean normal.

    Args:
        grid: the ground.
        at: the place [m].
        reach: largest distance, returned if there is none [m].
        near: difference of distances that counts as zero [m].
    """
    least, found, planes = distance_above(grid, at, reach), 0, NO_PLANES
    total = (0.0, 0.0, 0.0)
    i, i_last, j, j_last = cells_around(grid.frame, at[0], at[2], least + near)
    for line in range(j, j_last + 1):
        for column in range(i, i_last + 1):
            for piece in range(triangles_per_cell(grid.frame)):
                corners = triangle(grid, line, column, piece)
                if length(minus(at, nearest_on_triangle(at, corners))) > least + near:
                    continue
                up = triangle_normal(corners)
                if not _is_normal_of(planes, up):
                    planes, total, found = with_plane(planes, 0.0, up), plus(total, up), found + 1
    if found < 2:
        return least, total if found == 1 else (0.0, 1.0, 0.0)
    return least, mean_normal(total)[0]


@compiled
def _is_normal_of(planes: Planes, n: Vector) -> bool:
    """Returns whether one of the planes has a normal."""
    least = 1.0 - SAME_NORMAL
    one = max(_cosine(planes[0], n), _cosine(planes[1], n))
    return max(one, max(_cosine(planes[2], n), _cosine(planes[3], n))) > least


@compiled
def _cosine(plane: Plane, n: Vector) -> float:
    return plane[0] * n[0] + plane[1] * n[1] + plane[2] * n[2]


@compiled
def mean_normal(total: Vector) -> tuple[Vector, float]:
    """Returns the unit vector along a sum of normals, and half the length of the sum.

    Of two it is midway between them, and that is the cosine of its angle with each. Opposite ones,
    of a ball stuck between two walls, have none: up and zero.
    """
    size = length(total)
    if size < OPPOSITE_NORMALS:
        return (0.0, 1.0, 0.0), 0.0
    return times(1.0 / size, total), 0.5 * size
