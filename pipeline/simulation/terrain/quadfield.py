"""Quadrilaterals: a height field whose cells favour neither diagonal.

Four corners do not lie in a plane in general, and the heights that Sims interpolates
between them span a curved patch, which no triangles draw. So a quadrilateral is four
triangles about its middle, as high as its corners on average: feet and picture share
them.

Source: Sims 1987, 8.1.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField, Located


class QuadField(HeightField):
    """A height field of quadrilaterals."""

    def _height(self, at: Located) -> Array:
        (h00, h10, h01, h11), u, v = at
        rise_u, rise_v = _rises(h00, h10, h01, h11, u, v)
        middle = 0.25 * ((h00 + h10) + (h01 + h11))
        result: Array = middle + rise_u * (u - 0.5) + rise_v * (v - 0.5)
        return result

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

    @property
    def facets(self) -> tuple[tuple[Array, Array], ...]:
        """Rise along x and z (n_z, n_x) of each triangle of the cells, in the grid's frame."""
        x, z = self._rises
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
