"""Height field: a regular grid of triangles and the exact surface that it spans.

The grid has (n_z + 1, n_x + 1) vertices. Each cell is cut along the diagonal from
its low corner to its high corner, and every question about the surface is
answered on these triangles, so that feet stand on what the renderer draws.

Source: Sims 1987, 8.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, normalized


@dataclass(frozen=True, eq=False)
class HeightField:
    """Heights over a rectangle centred on the origin.

    Attributes:
        heights: (n_z + 1, n_x + 1) heights [m]; rows run along z, columns along x.
        size: extent along x and z [m].
    """

    heights: Array
    size: tuple[float, float]

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

    def _locate(self, x: Array, z: Array) -> tuple[NDArray[np.int64], Array, Array]:
        """Return the low corner of the cell under each point and the place within it.

        Points outside are taken to the nearest edge.
        """
        n_x, n_z = self.cells
        u = (np.asarray(x, dtype=float) / self.size[0] + 0.5) * n_x
        v = (np.asarray(z, dtype=float) / self.size[1] + 0.5) * n_z
        u, v = np.clip(u, 0.0, n_x), np.clip(v, 0.0, n_z)
        i = np.minimum(u.astype(np.int64), n_x - 1)
        j = np.minimum(v.astype(np.int64), n_z - 1)
        return j * (n_x + 1) + i, u - i, v - j

    def _corners(self, corner: NDArray[np.int64]) -> tuple[Array, Array, Array, Array]:
        flat, row = self._flat, self.cells[0] + 1
        return flat[corner], flat[corner + 1], flat[corner + row], flat[corner + row + 1]

    def height(self, x: Array, z: Array) -> Array:
        """Return the height of the surface [m] at world (x, z); any equal shapes."""
        corner, u, v = self._locate(x, z)
        h00, h10, h01, h11 = self._corners(corner)
        # Both triangles share h00 and h11; the nearer side corner decides.
        lower = u >= v
        side = np.where(lower, h10, h01)
        near, far = np.where(lower, u, v), np.where(lower, v, u)
        result: Array = h00 + near * (side - h00) + far * (h11 - side)
        return result

    def gradient(self, x: Array, z: Array) -> Array:
        """Return (..., 2): the rise of the surface along x and z, per metre."""
        corner, u, v = self._locate(x, z)
        h00, h10, h01, h11 = self._corners(corner)
        lower = u >= v
        along_x = np.where(lower, h10 - h00, h11 - h01) / self.cell[0]
        along_z = np.where(lower, h11 - h10, h01 - h00) / self.cell[1]
        return np.stack([along_x, along_z], axis=-1)

    def normal(self, x: Array, z: Array) -> Array:
        """Return the unit normals (..., 3) of the triangles at (x, z)."""
        g = self.gradient(x, z)
        return normalized(np.stack([-g[..., 0], np.ones_like(g[..., 0]), -g[..., 1]], axis=-1))

    def inside(self, x: Array, z: Array) -> NDArray[np.bool_]:
        """Say which points lie over the grid."""
        result: NDArray[np.bool_] = (np.abs(x) <= self.size[0] / 2) & (
            np.abs(z) <= self.size[1] / 2
        )
        return result

    @cached_property
    def vertices(self) -> Array:
        """Grid vertices (V, 3) [m], row by row."""
        n_x, n_z = self.cells
        x = np.linspace(-self.size[0] / 2, self.size[0] / 2, n_x + 1)
        z = np.linspace(-self.size[1] / 2, self.size[1] / 2, n_z + 1)
        gx, gz = np.meshgrid(x, z)
        return np.stack([gx, self.heights, gz], axis=-1).reshape(-1, 3)

    @cached_property
    def faces(self) -> NDArray[np.uint32]:
        """Triangles (2 n_x n_z, 3), counter-clockwise from above: the surface itself."""
        n_x, n_z = self.cells
        a = (np.arange(n_z)[:, None] * (n_x + 1) + np.arange(n_x)).ravel()
        b, c, d = a + 1, a + n_x + 1, a + n_x + 2
        triangles = np.stack([a, d, b, a, c, d], axis=-1).reshape(-1, 3)
        return triangles.astype(np.uint32)

    @cached_property
    def gradients(self) -> Array:
        """(2, n_z, n_x, 2): rise along x and z of both triangles of each cell, per metre."""
        h = self.heights
        (dx, dz) = self.cell
        h00, h10, h01, h11 = h[:-1, :-1], h[:-1, 1:], h[1:, :-1], h[1:, 1:]
        first = np.stack([(h10 - h00) / dx, (h11 - h10) / dz], axis=-1)
        second = np.stack([(h11 - h01) / dx, (h01 - h00) / dz], axis=-1)
        return np.stack([first, second])
