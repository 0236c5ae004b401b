"""Wall rims: the edges of steep walls in a height field, drawn as the curves that they stand for.

A grid has the round wall of a stone or of a pit as a staircase of cells, whose faces are lit and
dark by turns. In the picture its upper and lower edges are smoothed along themselves, by less than
a cell; footholds keep the grid.

Source: G. Taubin, Curve and Surface Smoothing without Shrinkage, 1995, for steps forward and back.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

STEEP = 1.6
"""Rise from one vertex to the next, relative to their distance, from which there is a wall."""

_FORWARD, _BACK, _ROUNDS = 0.6, -0.62, 6
"""Shares of the way to the mean of the neighbours, by turns, and number of pairs of steps."""

_MAX_SHIFT = 0.7
"""Longest way of a vertex, relative to the cells."""

_AROUND = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]


def rounded_walls(vertices: NDArray[np.floating], cells: tuple[int, int]) -> NDArray[np.floating]:
    """Return the vertices of a height field with smooth edges of its walls.

    Args:
        vertices: (V, 3), row by row along z; vertices in the middle of cells are left alone.
        cells: along x and z.
    """
    shape = cells[1] + 1, cells[0] + 1
    count = shape[0] * shape[1]
    if len(vertices) != count or min(cells) < 3:
        return vertices
    grid = np.asarray(vertices, float).reshape(*shape, 3)
    height, places = grid[..., 1], grid[..., [0, 2]].copy()
    cell = float(np.hypot(*(grid[0, 1] - grid[0, 0])[[0, 2]]))
    rise = STEEP * cell
    drops, climbs = (np.zeros(shape, bool) for _ in range(2))
    for axis in (0, 1):
        step = np.diff(height, axis=axis)
        low, high = (
            tuple(slice(*ends) if k == axis else slice(None) for k in (0, 1))
            for ends in ((None, -1), (1, None))
        )
        climbs[low] |= step > rise
        drops[high] |= step > rise
        drops[low] |= step < -rise
        climbs[high] |= step < -rise
    kind = drops + 2 * climbs
    kind[[0, -1]] = kind[:, [0, -1]] = 0
    rows, columns = np.nonzero(kind)
    if len(rows) == 0:
        return vertices
    own_kind, own_height = kind[rows, columns], height[rows, columns]
    near = [(rows + i, columns + j) for i, j in _AROUND]
    linked = [(kind[at] == own_kind) & (np.abs(height[at] - own_height) < rise) for at in near]
    links = np.sum(linked, axis=0)
    start = places[rows, columns].copy()
    for step_size in (_FORWARD, _BACK) * _ROUNDS:
        here = places[rows, columns]
        mean = sum(w[:, None] * (places[at] - here) for at, w in zip(near, linked, strict=True))
        # The end of an edge stays where it is.
        shift = step_size * mean / np.maximum(links, 1)[:, None] * (links >= 2)[:, None]
        places[rows, columns] = here + shift
    way = places[rows, columns] - start
    longest = np.maximum(np.hypot(*way.T) / (_MAX_SHIFT * cell), 1.0)
    grid = grid.copy()
    grid[rows, columns, 0], grid[rows, columns, 2] = (start + way / longest[:, None]).T
    return grid.reshape(-1, 3)
