"""Terrain grid: the surface of a terrain for compiled code, and its convex edges.

The triangles are those of the height field. Positions are taken to the frame of the grid, which
may be turned about the vertical.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.record_array import records_of_array
from pipeline.simulation.dynamics.vectors import Vector, row
from pipeline.simulation.spatial import Array, cross
from pipeline.simulation.terrain.heightfield import HeightField, QuadField

CONVEX_EDGE_HEIGHT = 1e-9
"""Height by which adjacent triangles differ from a plane, in cells: less is rounding."""


def convex_edges(
    vertices: Array, faces: NDArray[np.uint32], cell: float
) -> tuple[NDArray[np.int64], Array]:
    """Returns the edges at which the ground falls away on both sides, and its border.

    Bodies on the surface touch it with their own vertices, except at these edges and their ends.
    Beside the border the ground counts as a vertical drop.

    Args:
        vertices: (V, 3) [m].
        faces: (F, 3) triangles, counter-clockwise from above.
        cell: length of a cell [m].

    Returns:
        Edges (E, 2), and the normals of the ground on both sides of each (E, 2, 3).
    """
    whole = faces.astype(np.int64)
    sides = np.concatenate([whole[:, [0, 1, 2]], whole[:, [1, 2, 0]], whole[:, [2, 0, 1]]])
    ends = np.sort(sides[:, :2], axis=1)
    order = np.argsort(ends[:, 0] * len(vertices) + ends[:, 1], kind="stable")
    ends, sides = ends[order], sides[order]
    twin = np.zeros(len(ends), dtype=bool)
    twin[:-1] = (ends[1:] == ends[:-1]).all(axis=1)
    first = np.flatnonzero(twin)
    a, b, c = np.moveaxis(vertices[sides], 1, 0)
    up = cross(b - a, c - a)
    up = up / np.sqrt((up**2).sum(axis=-1))[:, None]
    ahead = vertices[sides[first + 1, 2]] - vertices[sides[first, 0]]
    falls = first[(up[first] * ahead).sum(axis=-1) < -CONVEX_EDGE_HEIGHT * cell]
    alone = ~twin
    alone[first + 1] = False
    way = vertices[sides[alone, 1]] - vertices[sides[alone, 0]]
    out = cross(way, np.array([0.0, 1.0, 0.0]))
    out /= np.sqrt((out**2).sum(axis=-1))[:, None]
    return (
        np.concatenate([ends[falls], ends[alone]]),
        np.concatenate(
            [np.stack([up[falls], up[falls + 1]], axis=1), np.stack([up[alone], out], axis=1)]
        ),
    )


TILE_CELLS = 8
"""Cells along a tile, whose greatest height is precomputed."""

POSITION_ROUNDING = 1e-9
"""Rounding error of positions of vertices, in sizes of the terrain."""

FRAME = np.dtype(
    [
        # Cells along x and z; whether one is four triangles about its centre, not two.
        ("n_x", "i8"),
        ("n_z", "i8"),
        ("quads", "?"),
        # Centre and extent along x and z [m]; cosine and sine of the heading.
        *((name, "f8") for name in ("at_x", "at_z", "size_x", "size_z", "cos", "sin")),
        # Whether it is level, and at which height [m].
        ("level", "?"),
        ("height", "f8"),
    ],
    align=True,
)
"""Placement of a grid."""

Numbers = NDArray[np.int64]
Spans = tuple[int, int, int, int]
Triangle = tuple[Vector, Vector, Vector]


class Grid(NamedTuple):
    """A triangulated surface.

    Attributes:
        frame: a `FRAME`.
        vertices: (V, 3) in the world, those of the grid first, then centres of cells [m].
        tops: (m_z, m_x) greatest heights of tiles [m].
        ridges: (n, 2) ends of convex edges, and these ends as edges from a vertex to itself;
            sorted by cell.
        starts: (n_cells + 1,) first ridge of each cell.
        sides: (n, 2, 3) normals of the ground on both sides of ridges, zero for single ends.
    """

    frame: Record
    vertices: Array
    tops: Array
    ridges: Numbers
    starts: Numbers
    sides: Array


def grid_of(field: HeightField) -> Grid:
    """Returns the grid of a height field."""
    edges, sides = convex_edges(field.vertices, field.faces, min(field.cell))
    ridges = np.concatenate([edges, np.repeat(np.unique(edges)[:, None], 2, axis=1)])
    sides = np.concatenate([sides, np.zeros((len(ridges) - len(edges), 2, 3))])
    order, starts = _sort_by_cell(ridges, field)
    return Grid(
        frame_of(field),
        np.ascontiguousarray(field.vertices),
        _tile_tops(field.heights),
        np.ascontiguousarray(ridges[order]),
        starts,
        np.ascontiguousarray(sides[order]),
    )


def frame_of(field: HeightField) -> Record:
    """Returns the placement of the grid of a height field."""
    turn = (math.cos(field.heading), math.sin(field.heading)) if field.heading else (1.0, 0.0)
    level = bool(np.ptp(field.heights) == 0.0), float(field.heights[0, 0])
    frame = (*field.cells, isinstance(field, QuadField), *field.at, *field.size, *turn, *level)
    return records_of_array(np.array([frame], dtype=FRAME))[0]


def _sort_by_cell(ridges: Numbers, field: HeightField) -> tuple[Numbers, Numbers]:
    """Assigns ridges to cells, by a cell centre that they end in, else by their lower corner.

    Returns:
        Their order, and the first of each cell.
    """
    n_x, n_z = field.cells
    low, high = ridges.min(axis=1), ridges.max(axis=1)
    row, column = np.divmod(low, n_x + 1)
    cell = np.minimum(row, n_z - 1) * n_x + np.minimum(column, n_x - 1)
    middle = high >= field.heights.size
    cell[middle] = high[middle] - field.heights.size
    starts = np.zeros(n_x * n_z + 1, dtype=np.int64)
    np.cumsum(np.bincount(cell, minlength=n_x * n_z), out=starts[1:])
    return np.argsort(cell, kind="stable"), starts


def _tile_tops(heights: Array) -> Array:
    cells = np.maximum(
        np.maximum(heights[:-1, :-1], heights[1:, :-1]),
        np.maximum(heights[:-1, 1:], heights[1:, 1:]),
    )
    n_z, n_x = cells.shape
    room = np.full(
        (-(-n_z // TILE_CELLS) * TILE_CELLS, -(-n_x // TILE_CELLS) * TILE_CELLS), -np.inf
    )
    room[:n_z, :n_x] = cells
    tiles: Array = room.reshape(len(room) // TILE_CELLS, TILE_CELLS, -1, TILE_CELLS).max(
        axis=(1, 3)
    )
    return np.ascontiguousarray(tiles)


@compiled
def to_grid_frame(frame: Record, x: float, z: float) -> tuple[float, float]:
    """Transforms a position to the frame of the grid."""
    x, z = x - frame.at_x, z - frame.at_z
    return frame.cos * x - frame.sin * z, frame.sin * x + frame.cos * z


@compiled
def is_over_grid(frame: Record, x: float, z: float) -> bool:
    """Returns whether a position lies over the grid."""
    u, v = to_grid_frame(frame, x, z)
    return abs(u) <= 0.5 * frame.size_x and abs(v) <= 0.5 * frame.size_z


@compiled
def surface_at(frame: Record, vertices: Array, x: float, z: float) -> tuple[float, Vector]:
    """Returns height and normal of the surface at a position, see `HeightField`."""
    if frame.level:
        return frame.height, _slope_normal(frame, 0.0, 0.0)
    x, z = to_grid_frame(frame, x, z)
    u = min(max((x / frame.size_x + 0.5) * frame.n_x, 0.0), float(frame.n_x))
    v = min(max((z / frame.size_z + 0.5) * frame.n_z, 0.0), float(frame.n_z))
    i, j = min(int(u), frame.n_x - 1), min(int(v), frame.n_z - 1)
    u, v = u - i, v - j
    low = j * (frame.n_x + 1) + i
    high = low + frame.n_x + 1
    h00, h10, h01, h11 = (
        vertices[low, 1],
        vertices[low + 1, 1],
        vertices[high, 1],
        vertices[high + 1, 1],
    )
    if frame.quads:
        rise_u, rise_v = 0.5 * (h10 - h00 + (h11 - h01)), 0.5 * (h01 - h00 + (h11 - h10))
        if abs(v - 0.5) >= abs(u - 0.5):
            rise_u = h10 - h00 if v < 0.5 else h11 - h01
        else:
            rise_v = h01 - h00 if u < 0.5 else h11 - h10
        height = 0.25 * ((h00 + h10) + (h01 + h11)) + rise_u * (u - 0.5) + rise_v * (v - 0.5)
    elif u >= v:
        rise_u, rise_v = h10 - h00, h11 - h10
        height = h00 + u * rise_u + v * rise_v
    else:
        rise_u, rise_v = h11 - h01, h01 - h00
        height = h00 + v * rise_v + u * rise_u
    return height, _slope_normal(frame, rise_u, rise_v)


@compiled
def is_near_crease(frame: Record, x: float, z: float, near: float) -> bool:
    """Returns whether a position is within `near` of an edge between triangles, in cells."""
    x, z = to_grid_frame(frame, x, z)
    u, v = (x / frame.size_x + 0.5) * frame.n_x, (z / frame.size_z + 0.5) * frame.n_z
    u, v = u - math.floor(u), v - math.floor(v)
    if min(min(u, 1.0 - u), min(v, 1.0 - v)) <= near or abs(u - v) <= near:
        return True
    return bool(frame.quads and abs(u + v - 1.0) <= near)


@compiled
def _slope_normal(frame: Record, rise_u: float, rise_v: float) -> Vector:
    """Returns the normal of a plane with the given rise along the sides of a cell."""
    along_x, along_z = rise_u * frame.n_x / frame.size_x, rise_v * frame.n_z / frame.size_z
    along_x, along_z = (
        frame.cos * along_x + frame.sin * along_z,
        frame.cos * along_z - frame.sin * along_x,
    )
    up = 1.0 / math.sqrt(along_x * along_x + 1.0 + along_z * along_z)
    return (-along_x * up, up, -along_z * up)


@compiled
def triangles_per_cell(frame: Record) -> int:
    """Returns the number of triangles of a cell."""
    return 4 if frame.quads else 2


@compiled
def triangle(grid: Grid, line: int, column: int, k: int) -> Triangle:
    """Returns triangle k of a cell, counter-clockwise from above."""
    frame, vertices = grid.frame, grid.vertices
    low = line * (frame.n_x + 1) + column
    a, b = row(vertices, low), row(vertices, low + 1)
    c, d = row(vertices, low + frame.n_x + 1), row(vertices, low + frame.n_x + 2)
    if not frame.quads:
        return (a, d, b) if k == 0 else (a, c, d)
    m = row(vertices, (frame.n_x + 1) * (frame.n_z + 1) + line * frame.n_x + column)
    if k < 2:
        return (b, a, m) if k == 0 else (d, b, m)
    return (c, d, m) if k == 2 else (a, c, m)


@compiled
def cell_span(low: float, high: float, size: float, n: int) -> tuple[int, int]:
    """Returns the first and last of n cells, of total length `size`, between two positions."""
    first = math.floor((low / size + 0.5 - POSITION_ROUNDING) * n)
    last = math.floor((high / size + 0.5 + POSITION_ROUNDING) * n)
    return min(max(int(first), 0), n - 1), min(max(int(last), 0), n - 1)


@compiled
def cells_around(frame: Record, x: float, z: float, reach: float) -> Spans:
    """Returns first and last column, first and last row of the cells around a position."""
    u, v = to_grid_frame(frame, x, z)
    i, i_last = cell_span(u - reach, u + reach, frame.size_x, frame.n_x)
    j, j_last = cell_span(v - reach, v + reach, frame.size_z, frame.n_z)
    return i, i_last, j, j_last


@compiled
def highest_around(frame: Record, tops: Array, x: float, z: float, reach: float) -> float:
    """Returns an upper bound of the ground's height around a position [m]."""
    i, i_last, j, j_last = cells_around(frame, x, z, reach)
    top = -np.inf
    for tile_z in range(j // TILE_CELLS, j_last // TILE_CELLS + 1):
        for tile_x in range(i // TILE_CELLS, i_last // TILE_CELLS + 1):
            top = max(top, tops[tile_z, tile_x])
    return top
