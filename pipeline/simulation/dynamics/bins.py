"""Bins: which pieces of a terrain lie near a body, by the cells of its grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField

Numbers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Bins:
    """Pieces sorted by the cell that each lies in.

    Attributes:
        field: the grid.
        pieces: numbers of the pieces, cell by cell, row by row.
        starts: (n_cells + 1,) first piece of each cell.
    """

    field: HeightField
    pieces: Numbers
    starts: Numbers

    @staticmethod
    def of(field: HeightField, places: Array) -> Bins:
        """Sort pieces by their places (n, 3)."""
        row, column = field.cell_of(places[:, 0], places[:, 2])
        n_x, n_z = field.cells
        cell = row * n_x + column
        counts = np.bincount(cell, minlength=n_x * n_z)
        starts = np.concatenate([[0], np.cumsum(counts)])
        return Bins(field, np.argsort(cell, kind="stable"), starts)

    def near(self, places: Array, reach: Array) -> tuple[Numbers, Numbers]:
        """Return pairs (M,) of places and pieces that may lie within their reach.

        Args:
            places: (B, 3) [m].
            reach: (B,) along the ground [m].
        """
        n_x, n_z = self.field.cells
        x, z = self.field.to_grid(places[:, 0], places[:, 2])
        low, high = [], []
        field = self.field
        for u, size, cell, n in zip((x, z), field.size, field.cell, (n_x, n_z), strict=True):
            # A piece lies in the cell of its middle and may stand out by one cell.
            first = np.floor((u - reach + 0.5 * size) / cell).astype(np.int64) - 1
            last = np.floor((u + reach + 0.5 * size) / cell).astype(np.int64) + 1
            low.append(np.clip(first, 0, n - 1))
            high.append(np.clip(last, 0, n - 1))
        which, row = _spans(low[1], high[1] + 1)
        first, last = row * n_x + low[0][which], row * n_x + high[0][which] + 1
        span, place = _spans(self.starts[first], self.starts[last])
        return which[span], self.pieces[place]


def _spans(first: Numbers, after: Numbers) -> tuple[Numbers, Numbers]:
    """Return all numbers of the spans from `first` to before `after`, and whose each is."""
    counts = np.maximum(after - first, 0)
    whose = np.repeat(np.arange(len(first)), counts)
    begin = np.cumsum(counts) - counts
    return whose, np.arange(len(whose)) - begin[whose] + first[whose]
