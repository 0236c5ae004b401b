"""Height field: a regular grid of triangles and the exact surface that it spans.

The grid has (n_z + 1, n_x + 1) vertices. Each cell is cut along the diagonal from
its low corner to its high corner, and every question about the surface is
answered on these triangles, so that feet stand on what the renderer draws. `QuadField`
cuts them otherwise.

The grid G has a pose in the world W: its middle lies at (x, z) and it is turned about
+Y. World places are taken to the grid by the inverse, two products a point.

Source: Sims 1987, 8.1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.spec.terrain.base import Polygons

Located = tuple[Array, Array, Array]
"""Heights (4, ...) at the corners of cells, and places in them along x and z (...)."""

MAX_AXES = 4
"""One more than the axes of the largest arrays of places."""


@dataclass(frozen=True, eq=False)
class HeightField:
    """Heights over a rectangle.

    Attributes:
        heights: (n_z + 1, n_x + 1) heights [m]; rows run along z, columns along x.
        size: extent along x and z [m].
        at: world place (x, z) of its middle [m].
        heading: angle by which it is turned about +Y [rad].
    """

    heights: Array
    size: tuple[float, float]
    at: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0

    @classmethod
    def of_vertices(cls, vertices: Array, cells: tuple[int, int]) -> Self:
        """Return the field of vertices (V, 3), those of the grid first."""
        n_x, n_z = cells
        grid = vertices[: (n_x + 1) * (n_z + 1)]
        low, along_x, high = grid[0], grid[n_x], grid[-1]
        run, across = along_x - low, high - along_x
        return cls(
            grid[:, 1].reshape(n_z + 1, n_x + 1),
            (math.hypot(run[0], run[2]), math.hypot(across[0], across[2])),
            (float(low[0] + high[0]) / 2.0, float(low[2] + high[2]) / 2.0),
            math.atan2(-run[2], run[0]),
        )

    def placed(self, at: tuple[float, float], heading: float) -> Self:
        """Return the field moved so that what was its origin lies at `at`, turned about it."""
        origin = replace(self, at=at, heading=heading)
        x, z = origin.to_world(*np.asarray(self.at))
        return replace(origin, at=(float(x), float(z)))

    @cached_property
    def _turn(self) -> tuple[float, float] | None:
        """Cosine and sine of the heading, None for a grid that stands along x and z."""
        return (math.cos(self.heading), math.sin(self.heading)) if self.heading else None

    def to_grid(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Take world places to the frame of the grid, whose middle is (0, 0)."""
        x, z = np.asarray(x, dtype=float) - self.at[0], np.asarray(z, dtype=float) - self.at[1]
        if self._turn is None:
            return x, z
        c, s = self._turn
        return c * x - s * z, s * x + c * z

    def to_world(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Take places in the frame of the grid to the world."""
        if self._turn is not None:
            x, z = self._turned(x, z)
        return x + self.at[0], z + self.at[1]

    def _turned(self, x: Array, z: Array) -> tuple[Array, Array]:
        c, s = self._turn or (1.0, 0.0)
        return c * x + s * z, c * z - s * x

    @cached_property
    def cells(self) -> tuple[int, int]:
        """Number of cells along x and z."""
        rows, columns = self.heights.shape
        return columns - 1, rows - 1

    @cached_property
    def cell(self) -> tuple[float, float]:
        """Length of a cell along x and z [m]."""
        return self.size[0] / self.cells[0], self.size[1] / self.cells[1]

    @cached_property
    def _flat(self) -> Array:
        return np.ascontiguousarray(self.heights).ravel()

    @cached_property
    def _scales(self) -> tuple[tuple[Array, NDArray[np.int64], NDArray[np.int64]], ...]:
        """Size, cells, and steps to the corners of a cell, shaped for places of few axes."""
        steps = np.array([0, 1, self.cells[0] + 1, self.cells[0] + 2])
        return tuple(
            (
                np.reshape(self.size, (2, *(1,) * axes)),
                np.reshape(self.cells, (2, *(1,) * axes)),
                steps.reshape(4, *(1,) * axes),
            )
            for axes in range(MAX_AXES)
        )

    def _on_grid(self, x: Array, z: Array) -> Array:
        """Return world places (2, ...) counted in cells from the low corner of the grid."""
        # One array for both: most calls are for a few points, where it is the calls that cost.
        places = np.array(self.to_grid(x, z))
        size, cells, _ = self._scales[places.ndim - 1]
        places /= size
        places += 0.5
        places *= cells
        return places

    def _locate(self, x: Array, z: Array) -> Located:
        """Return the heights (4, ...) at the corners of the cell under each point, and its place.

        The corners are the low one, the next along x, the next along z and the high one; the
        place is from 0 to 1. Points outside are taken to the nearest edge.
        """
        places = self._on_grid(x, z)
        _, cells, beside = self._scales[places.ndim - 1]
        np.minimum(np.maximum(places, 0.0, out=places), cells, out=places)
        cell = np.minimum(places.astype(np.int64), cells - 1)
        places -= cell
        corner = cell[1] * (self.cells[0] + 1) + cell[0]
        return self._flat.take(corner + beside), places[0], places[1]

    def _height(self, at: Located) -> Array:
        (h00, h10, h01, h11), u, v = at
        # Both triangles share h00 and h11; the nearer side corner decides.
        side = np.where(u >= v, h10, h01)
        near, far = np.maximum(u, v), np.minimum(u, v)
        return h00 + near * (side - h00) + far * (h11 - side)

    def _rise(self, at: Located) -> tuple[Array, Array]:
        (h00, h10, h01, h11), u, v = at
        lower = u >= v
        along_x = np.where(lower, h10 - h00, h11 - h01) / self.cell[0]
        along_z = np.where(lower, h11 - h10, h01 - h00) / self.cell[1]
        return (along_x, along_z) if self._turn is None else self._turned(along_x, along_z)

    def height(self, x: Array, z: Array) -> Array:
        """Return the height of the surface [m] at world (x, z); any equal shapes."""
        return self._height(self._locate(x, z))

    def gradient(self, x: Array, z: Array) -> Array:
        """Return (..., 2): the rise of the surface along x and z, per metre."""
        return np.stack(self._rise(self._locate(x, z)), axis=-1)

    def normal(self, x: Array, z: Array) -> Array:
        """Return the unit normals (..., 3) of the triangles at (x, z)."""
        return _normal(*self._rise(self._locate(x, z)))

    def surface(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Return heights (...) [m] and unit normals (..., 3) at world (x, z), found together."""
        at = self._locate(x, z)
        return self._height(at), _normal(*self._rise(at))

    def cell_of(self, x: Array, z: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return row and column of the cell under each point, the nearest for points outside."""
        n_x, n_z = self.cells
        u, v = self._on_grid(x, z)
        i, j = np.floor(u).astype(np.int64), np.floor(v).astype(np.int64)
        return np.minimum(np.maximum(j, 0), n_z - 1), np.minimum(np.maximum(i, 0), n_x - 1)

    def inside(self, x: Array, z: Array) -> NDArray[np.bool_]:
        """Return which points lie over the grid."""
        x, z = self.to_grid(x, z)
        return (np.abs(x) <= self.size[0] / 2) & (np.abs(z) <= self.size[1] / 2)

    @property
    def inner_bounds(self) -> tuple[Array, Array]:
        """Least and greatest x and z (2,) of a rectangle along x and z within it."""
        half = np.array(self.size) / (2.0 if self.heading == 0.0 else 2.0 * math.sqrt(2.0))
        return np.array(self.at) - half, np.array(self.at) + half

    @property
    def extent_text(self) -> str:
        """The rectangle that it covers, in an author's words."""
        width, depth = self.size
        x, z = self.at
        if self._turn is not None:
            turned = f"turned by {math.degrees(self.heading):g} degrees"
            return f"which covers {width:g} x {depth:g} m around [{x:g}, {z:g}], {turned}"
        low, high = (x - width / 2, z - depth / 2), (x + width / 2, z + depth / 2)
        return f"which reaches from [{low[0]:g}, {low[1]:g}] to [{high[0]:g}, {high[1]:g}]"

    @cached_property
    def vertices(self) -> Array:
        """Vertices (V, 3) [m], those of the grid first, row by row."""
        return self._grid.reshape(-1, 3)

    @property
    def _grid(self) -> Array:
        """Vertices of the grid (n_z + 1, n_x + 1, 3) [m]."""
        n_x, n_z = self.cells
        x = np.linspace(-self.size[0] / 2, self.size[0] / 2, n_x + 1)
        z = np.linspace(-self.size[1] / 2, self.size[1] / 2, n_z + 1)
        gx, gz = self.to_world(*np.meshgrid(x, z))
        return np.stack([gx, self.heights, gz], axis=-1)

    @cached_property
    def faces(self) -> NDArray[np.uint32]:
        """Triangles (F, 3), counter-clockwise from above, cell by cell: the surface itself."""
        a, b, c, d = self._corner_numbers
        triangles = np.stack([a, d, b, a, c, d], axis=-1).reshape(-1, 3)
        return triangles.astype(np.uint32)

    @property
    def _corner_numbers(self) -> tuple[NDArray[np.int64], ...]:
        """Numbers (n_x n_z,) of the cells' vertices at low x and z, high x, high z, both high."""
        n_x, n_z = self.cells
        a = (np.arange(n_z)[:, None] * (n_x + 1) + np.arange(n_x)).ravel()
        return a, a + 1, a + n_x + 1, a + n_x + 2

    def _rises(self, rows: slice) -> tuple[Array, Array]:
        """Return the rise per metre along x (n + 1, n_x) and z (n, n_x + 1) of edges of cells."""
        heights = self.heights[rows.start : rows.stop + 1]
        return np.diff(heights, axis=1) / self.cell[0], np.diff(heights, axis=0) / self.cell[1]

    @property
    def facets(self) -> tuple[tuple[Array, Array], ...]:
        """Rise along x and z (n_z, n_x) of each triangle of the cells, in the grid's frame."""
        return self.facets_of(slice(0, self.cells[1]))

    def facets_of(self, rows: slice) -> tuple[tuple[Array, Array], ...]:
        """Return the rise along x and z (n, n_x) of each triangle of the cells of some rows.

        Args:
            rows: with a start and a stop.

        Returns:
            In the grid's frame.
        """
        x, z = self._rises(rows)
        return (x[:-1], z[:, 1:]), (x[1:], z[:, :-1])


def _normal(along_x: Array, along_z: Array) -> Array:
    """Return the unit normals (..., 3) of surfaces that rise so along x and z."""
    length = np.sqrt(along_x * along_x + 1.0 + along_z * along_z)
    normals = np.empty((*np.shape(length), 3))
    normals[..., 0], normals[..., 1], normals[..., 2] = -along_x, 1.0, -along_z
    normals /= length[..., None]
    return normals


class QuadField(HeightField):
    """A height field whose cells favour neither diagonal.

    Four corners do not lie in a plane in general, and the heights that Sims interpolates
    between them span a curved patch, which no triangles draw. So a quadrilateral is four
    triangles about its middle, at the mean height of its corners: feet and picture share them.

    Source: Sims 1987, 8.1.
    """

    def _height(self, at: Located) -> Array:
        (h00, h10, h01, h11), u, v = at
        rise_u, rise_v = _rises(h00, h10, h01, h11, u, v)
        middle = 0.25 * ((h00 + h10) + (h01 + h11))
        return middle + rise_u * (u - 0.5) + rise_v * (v - 0.5)

    def _rise(self, at: Located) -> tuple[Array, Array]:
        (h00, h10, h01, h11), u, v = at
        rise_u, rise_v = _rises(h00, h10, h01, h11, u, v)
        return self._turned(rise_u / self.cell[0], rise_v / self.cell[1])

    @cached_property
    def vertices(self) -> Array:
        """Vertices (V, 3) [m]: those of the grid, then the middles of its cells, row by row."""
        grid = self._grid
        middles = 0.25 * ((grid[:-1, :-1] + grid[:-1, 1:]) + (grid[1:, :-1] + grid[1:, 1:]))
        return np.concatenate([grid.reshape(-1, 3), middles.reshape(-1, 3)])

    @cached_property
    def faces(self) -> NDArray[np.uint32]:
        """Triangles (F, 3), counter-clockwise from above, cell by cell: the surface itself."""
        a, b, c, d = self._corner_numbers
        m = self.heights.size + np.arange(len(a))
        triangles = np.stack([b, a, m, d, b, m, c, d, m, a, c, m], axis=-1).reshape(-1, 3)
        return triangles.astype(np.uint32)

    def facets_of(self, rows: slice) -> tuple[tuple[Array, Array], ...]:
        """See `HeightField.facets_of`."""
        x, z = self._rises(rows)
        mean_x, mean_z = 0.5 * (x[:-1] + x[1:]), 0.5 * (z[:, :-1] + z[:, 1:])
        return (x[:-1], mean_z), (mean_x, z[:, 1:]), (x[1:], mean_z), (mean_x, z[:, :-1])


def _rises(
    h00: Array, h10: Array, h01: Array, h11: Array, u: Array, v: Array
) -> tuple[Array, Array]:
    """Return the rises along u and v, a cell, of the triangle at (u, v) of each cell.

    A triangle rises along its own edge as that does, and across it as the two edges beside
    it do on average.
    """
    low_u, high_u, low_v, high_v = h10 - h00, h11 - h01, h01 - h00, h11 - h10
    along_u = np.abs(v - 0.5) >= np.abs(u - 0.5)
    rise_u = np.where(along_u, np.where(v < 0.5, low_u, high_u), 0.5 * (low_u + high_u))
    rise_v = np.where(along_u, 0.5 * (low_v + high_v), np.where(u < 0.5, low_v, high_v))
    return rise_u, rise_v


SURFACES: Mapping[Polygons, type[HeightField]] = {"triangles": HeightField, "quads": QuadField}


def surface_of(field: HeightField, polygons: Polygons) -> HeightField:
    """Return the same field with cells made of `polygons`."""
    return SURFACES[polygons](field.heights, field.size, field.at, field.heading)


def surface_of_vertices(vertices: Array, cells: tuple[int, int]) -> HeightField:
    """Return the surface of vertices (V, 3); a `QuadField` if the cells have middles."""
    n_x, n_z = cells
    has_middles = len(vertices) > (n_x + 1) * (n_z + 1)
    return SURFACES["quads" if has_middles else "triangles"].of_vertices(vertices, cells)
