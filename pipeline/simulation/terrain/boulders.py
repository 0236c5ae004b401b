"""Boulders: ellipsoids of seeded sizes, half buried in gentle ground."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.simulation.terrain.wild import swells
from pipeline.spec.terrain import BouldersTerrain

NARROWEST, FLATTEST, TALLEST = 0.7, 0.55, 0.9
"""Bounds of a boulder's other axes, in its longest."""

AT_ONCE = 1 << 20
"""Vertices that are looked at together."""


@dataclass(frozen=True, eq=False)
class Heap:
    """N boulders: upright ellipsoids.

    Attributes:
        xz: (N, 2) places of their middles [m].
        axes: (N, 3) half their length, width and height [m].
        turn: (N, 2) cosine and sine of the length's direction from x towards z.
    """

    xz: Array
    axes: Array
    turn: Array

    def some(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> Heap:
        """Return some of them."""
        return Heap(self.xz[which], self.axes[which], self.turn[which])


def boulders(words: BouldersTerrain, chance: np.random.Generator) -> HeightField:
    """Return ground with boulders; their steep sides take one cell."""
    ground_chance, heap_chance = chance.spawn(2)
    ground = HeightField(swells(words, words.height, words.spacing, ground_chance), words.size)
    heap = heaped(words, heap_chance)
    foot = ground.height(heap.xz[:, 0], heap.xz[:, 1])
    # From top to bottom a boulder measures twice its third axis.
    middle = foot + heap.axes[:, 2] * (1.0 - 2.0 * words.buried)
    heights = ground.heights.copy().ravel()
    for part, reach in _alike(heap, ground.cell):
        places, tops = _tops(heap.some(part), middle[part], reach, ground)
        np.maximum.at(heights, places, tops)
    return HeightField(heights.reshape(ground.heights.shape), words.size)


def heaped(words: BouldersTerrain, chance: np.random.Generator) -> Heap:
    """Return boulders that cover the asked share of the ground, where they may overlap.

    Diameters d have the density 1/d between the smallest and the largest, so there are as
    many from 0.2 m to 0.4 m as from 0.4 m to 0.8 m. N boulders strewn anywhere leave
    exp(-N a/A) of the area A free, where a is the mean area of one.
    """
    small, large = words.diameters
    ratio = math.log(large / small)
    square = (large**2 - small**2) / (2.0 * ratio) if ratio > 1e-6 else small**2
    area = math.pi / 4.0 * square * (NARROWEST + 1.0) / 2.0
    n = round(-math.log(1.0 - words.cover) * words.size[0] * words.size[1] / area)
    draw = chance.random((6, n))
    long = 0.5 * small * np.exp(ratio * draw[0])
    wide = long * (NARROWEST + (1.0 - NARROWEST) * draw[1])
    tall = long * (FLATTEST + (TALLEST - FLATTEST) * draw[2])
    angle = math.pi * draw[3]
    xz = (draw[4:].T - 0.5) * np.array(words.size)
    free = np.hypot(*xz.T) - long >= words.clearing
    turn = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return Heap(xz, np.stack([long, wide, tall], axis=-1), turn).some(free)


def _alike(
    heap: Heap, cell: tuple[float, float]
) -> Iterator[tuple[NDArray[np.int64], tuple[int, int]]]:
    """Yield boulders of like size together, with the cells that they reach along x and z."""
    reach = np.ceil(heap.axes[:, 0] / min(cell))
    for k in np.unique(reach):
        (members,) = np.nonzero(reach == k)
        longest = float(heap.axes[members, 0].max())
        r_x, r_z = (math.ceil(longest / side) for side in cell)
        few = max(1, AT_ONCE // ((2 * r_x + 2) * (2 * r_z + 2)))
        for start in range(0, len(members), few):
            yield members[start : start + few], (r_x, r_z)


def _tops(
    heap: Heap, middle: Array, reach: tuple[int, int], ground: HeightField
) -> tuple[NDArray[np.int64], Array]:
    """Return vertices under boulders, as places in the ravelled grid, and the surfaces there."""
    n_x, n_z = ground.cells
    dx, dz = ground.cell
    low = np.floor((heap.xz / np.array(ground.size) + 0.5) * np.array([n_x, n_z]))
    i = low[:, 0, None, None] + np.arange(-reach[0], reach[0] + 2)
    j = low[:, 1, None, None] + np.arange(-reach[1], reach[1] + 2)[:, None]
    x = i * dx - ground.size[0] / 2.0 - heap.xz[:, 0, None, None]
    z = j * dz - ground.size[1] / 2.0 - heap.xz[:, 1, None, None]
    c, s = heap.turn.T[..., None, None]
    a, b, tall = heap.axes.T[..., None, None]
    left = 1.0 - ((c * x + s * z) / a) ** 2 - ((c * z - s * x) / b) ** 2
    under = (left >= 0.0) & (i >= 0) & (i <= n_x) & (j >= 0) & (j <= n_z)
    tops = middle[:, None, None] + tall * np.sqrt(np.maximum(left, 0.0))
    places = (j * (n_x + 1) + i).astype(np.int64)
    return places[under], tops[under]
