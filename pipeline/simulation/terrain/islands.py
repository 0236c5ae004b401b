"""Islands: connected pieces of ground with footholds, and the islands that steps reach.

Cells that a foot may be put on and that share a side make an island; between islands lies
forbidden ground. A step leads from one to the other where the gap between two of their
cells is no wider, and the rise no greater, than legs can do.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.ground import Ground

SPOKES = 16
"""Directions of the search for the other side of a gap."""


class Islands:
    """The islands of a ground.

    Attributes:
        ground: what they lie on.
    """

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
        self._reached: dict[tuple[int, float, float], NDArray[np.bool_]] = {}

    @cached_property
    def of_cells(self) -> NDArray[np.int64]:
        """(n_z, n_x) number of each cell's island, -1 for forbidden cells."""
        return labelled(~self.ground.forbidden)

    @cached_property
    def _heights(self) -> Array:
        return cell_heights(self.ground)

    @cached_property
    def _shore(self) -> NDArray[np.int64]:
        """(n, 2) rows and columns of cells beside forbidden ones."""
        free = np.pad(~self.ground.forbidden, 1, constant_values=True)
        inner = free[:-2, 1:-1] & free[2:, 1:-1] & free[1:-1, :-2] & free[1:-1, 2:]
        return np.argwhere(~self.ground.forbidden & ~inner)

    def reached(self, start: Array, around: float, gap: float, rise: float) -> NDArray[np.bool_]:
        """Return the cells (n_z, n_x) that steps reach.

        Args:
            start: place x, z from which they lead [m].
            around: how far from it they may begin [m].
            gap: widest [m].
            rise: greatest, up or down [m].
        """
        free = ~self.ground.forbidden
        if free.all() or not free.any():
            return free
        key = self._begin(start, around), gap, rise
        if key not in self._reached:
            joined = self._joined(gap, rise)
            found = joined == joined[key[0]]
            self._reached[key] = free & found[np.maximum(self.of_cells, 0)]
        return self._reached[key]

    def _begin(self, start: Array, around: float) -> int:
        """Return the island that most of the ground around `start` belongs to."""
        field, labels = self.ground.field, self.of_cells
        angle, radius = np.arange(SPOKES) * (2.0 * np.pi / SPOKES), np.linspace(0.0, around, 9)
        x = start[0] + np.multiply.outer(radius, np.cos(angle)).ravel()
        z = start[1] + np.multiply.outer(radius, np.sin(angle)).ravel()
        here = labels[field.cell_of(x, z)]
        here = here[here >= 0]
        # On forbidden ground all round, any: nobody can stand there, and the feet will say so.
        return int(np.bincount(here if len(here) else labels[labels >= 0]).argmax())

    def _joined(self, gap: float, rise: float) -> NDArray[np.int32]:
        """Return a number (n,) for each island, equal for those that steps connect."""
        labels, heights, shore = self.of_cells, self._heights, self._shore
        largest = np.bincount(labels[labels >= 0]).argmax()
        # Every pair is looked at from both sides: one of them is enough, and the largest
        # island has the longest shore.
        shore = shore[labels[shore[:, 0], shore[:, 1]] != largest]
        side = min(self.ground.field.cell)
        offsets = _offsets(self.ground.field.cell, gap + 2.0 * side)
        many = int(labels.max()) + 1
        joined = np.arange(many, dtype=np.int32)
        # With a wide edge that is no island, one number says where a cell is.
        edge = int(np.abs(offsets).max(initial=0))
        wide = np.pad(labels.astype(np.int32), edge, constant_values=-1).ravel()
        tall = np.pad(heights, edge).ravel()
        width = labels.shape[1] + 2 * edge
        here = (shore[:, 0] + edge) * width + shore[:, 1] + edge
        own = wide[here]
        for j, i in offsets:
            there = here + (j * width + i)
            other = wide.take(there)
            leads = np.flatnonzero((other >= 0) & (other != own))
            # Those that are connected already need no second step.
            a, b = joined[own[leads]], joined[other[leads]]
            leads = leads[a != b]
            leads = leads[np.abs(tall[there[leads]] - tall[here[leads]]) <= rise]
            if len(leads):
                joined = _merged(joined, joined[own[leads]], joined[other[leads]])
        return joined


def _merged(
    joined: NDArray[np.int32], a: NDArray[np.int32], b: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Return numbers of groups of which `a` and `b` (n,) are the same, pair by pair."""
    many = int(joined.max()) + 1
    steps = coo_array((np.ones(len(a), dtype=bool), (a, b)), shape=(many, many))
    _, group = connected_components(steps, directed=False)
    return group.astype(np.int32)[joined]


def cell_heights(ground: Ground) -> Array:
    """Return the heights (n_z, n_x) of the middles of cells [m]."""
    h = ground.field.heights
    return 0.5 * (h[:-1, :-1] + h[1:, 1:])


def labelled(free: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Number the pieces (n_z, n_x) that cells which share a side make; -1 where not `free`.

    They are numbered in the order of their first cells.
    """
    numbers = np.empty(free.shape, dtype=np.int64)
    label(free, output=numbers)
    numbers -= 1
    return numbers


def _offsets(cell: tuple[float, float], gap: float) -> list[tuple[int, int]]:
    """Return offsets (rows, columns) of cells up to `gap` [m] away along the spokes."""
    angle = np.arange(SPOKES) * (2.0 * math.pi / SPOKES)
    radius = np.arange(1, math.ceil(gap / min(cell)) + 1) * min(cell)
    j = np.rint(np.multiply.outer(radius, np.sin(angle)) / cell[1]).astype(int)
    i = np.rint(np.multiply.outer(radius, np.cos(angle)) / cell[0]).astype(int)
    return list(dict.fromkeys(zip(j.ravel().tolist(), i.ravel().tolist(), strict=True)))
