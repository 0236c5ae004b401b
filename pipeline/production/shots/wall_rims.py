"""Wall rims: the edges of steep walls in a height field, drawn as the curves that they stand for.

A grid has the round wall of a stone or of a pit as a staircase of cells, whose faces are lit and
dark by turns. In the picture the vertices at its head and foot are moved by less than a cell, onto
the contour between what is high and what is low, smoothed over about a cell; so all faces of the
wall face as the contour does. Footholds keep the grid.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

STEEP = 1.6
"""Rise from one vertex to the next, relative to their distance, from which there is a wall."""

_REACH, _WIDTH = 3, 1.05
"""Reach and deviation of the smoothing [cells]."""

_SPAN = np.arange(-_REACH, _REACH + 1)

_BATTER = 0.5 / float(np.exp(-0.5 * (_SPAN / _WIDTH) ** 2).sum())
"""How far the smoothed height is above its middle at the head of a straight wall of one cell, and
below it at its foot: such walls stay."""

_STEPS = 5
"""Newton steps onto the contour."""

_LONGEST_STEP, _MAX_SHIFT = 0.35, 1.1
"""Longest step and longest way of a vertex [cells]."""

_LEAST_CORNER = 0.04
"""Area below which the corner of a moved cell counts as folded [cells²]."""

_DROPS, _CLIMBS = 1, 2

_AROUND = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]


def rounded_walls(vertices: NDArray[np.floating], cells: tuple[int, int]) -> NDArray[np.floating]:
    """Return the vertices of a height field with smooth walls.

    Args:
        vertices: (V, 3), row by row along z; vertices in the middle of cells are left alone.
        cells: along x and z.
    """
    shape = cells[1] + 1, cells[0] + 1
    if len(vertices) != shape[0] * shape[1] or min(cells) < 3:
        return vertices
    grid = np.asarray(vertices, float).reshape(*shape, 3)
    height = grid[..., 1]
    cell = float(np.hypot(*(grid[0, 1] - grid[0, 0])[[0, 2]]))
    kind = _kinds(height, STEEP * cell)
    rows, columns = np.nonzero((kind == _DROPS) | (kind == _CLIMBS))
    if len(rows) == 0:
        return vertices
    is_high = kind[rows, columns] == _DROPS
    across = _beyond_wall(height, rows, columns, is_high, STEEP * cell)
    shift = _onto_contour(height, rows, columns, is_high, across)
    spread = np.zeros((*shape, 2))
    spread[rows, columns] = shift
    spread = np.asarray(_unfolded(spread), float)
    along_x, along_z = (grid[0, 1] - grid[0, 0])[[0, 2]], (grid[1, 0] - grid[0, 0])[[0, 2]]
    grid = grid.copy()
    grid[..., [0, 2]] += spread[..., :1] * along_x + spread[..., 1:] * along_z
    return grid.reshape(-1, 3)


def _unfolded(shift: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return shifts (rows, columns, 2) [cells], shortened where a cell would turn over."""
    z, x = np.mgrid[0 : shift.shape[0], 0 : shift.shape[1]]
    places = np.stack([x, z], axis=-1)
    # The last round leaves what still folds where the grid has it.
    for factor in (0.7, 0.7, 0.5, 0.5, 0.0, 0.0):
        at = places + shift
        a, b, d, c = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
        least = np.full(a.shape[:2], np.inf)
        for before, corner, after in ((c, a, b), (a, b, d), (b, d, c), (d, c, a)):
            p, q = after - corner, before - corner
            least = np.minimum(least, p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0])
        folds = least < _LEAST_CORNER
        if not folds.any():
            break
        touched = np.zeros(shift.shape[:2], bool)
        for rows in (np.s_[:-1], np.s_[1:]):
            for columns in (np.s_[:-1], np.s_[1:]):
                touched[rows, columns] |= folds
        shift = np.where(touched[..., None], factor * shift, shift)
    return shift


def wall_faces(
    vertices: NDArray[np.floating], faces: NDArray[np.uint32], cells: tuple[int, int]
) -> NDArray[np.uint32]:
    """Return the faces of a height field, of which those of walls join what is equally high.

    The other diagonal of a cell would run from the head of a wall to its foot, and fold it.

    Args:
        vertices: (V, 3), row by row along z; cells of four triangles are left alone.
        faces: (F, 3), two to a cell.
        cells: along x and z.
    """
    shape = cells[1] + 1, cells[0] + 1
    if len(vertices) != shape[0] * shape[1]:
        return faces
    height = np.asarray(vertices[:, 1], float).reshape(shape)
    number = np.arange(height.size).reshape(shape)
    corners = [np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1], np.s_[1:, 1:]]
    (a, b, c, d), (at_a, at_b, at_c, at_d) = (
        [table[corner].ravel() for corner in corners] for table in (height, number)
    )
    cell = float(np.hypot(*(vertices[1] - vertices[0])[[0, 2]]))
    folded = (np.abs(a - d) > STEEP * cell) & (np.abs(b - c) < 0.5 * np.abs(a - d))
    other = np.stack([at_a, at_c, at_b, at_b, at_c, at_d], axis=-1)
    cut = np.where(folded[:, None], other, np.asarray(faces).reshape(-1, 6))
    return cut.reshape(-1, 3).astype(np.uint32)


def _kinds(height: NDArray[np.floating], rise: float) -> NDArray[np.int64]:
    """Return which vertices (rows, columns) are at the head or foot of a wall, or both."""
    drops, climbs = (np.zeros(height.shape, bool) for _ in range(2))
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
    kind = _DROPS * drops + _CLIMBS * climbs
    kind[[0, -1]] = kind[:, [0, -1]] = 0
    return kind


def _beyond_wall(
    height: NDArray[np.floating],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    is_high: NDArray[np.bool_],
    rise: float,
) -> NDArray[np.floating]:
    """Return the mean height (N,) of the neighbours on the other side of the wall [m]."""
    own = height[rows, columns]
    near = np.stack([height[rows + i, columns + j] for i, j in _AROUND])
    other = np.where(is_high, near < own - rise, near > own + rise)
    return np.asarray((near * other).sum(axis=0) / np.maximum(other.sum(axis=0), 1))


def _onto_contour(
    height: NDArray[np.floating],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    is_high: NDArray[np.bool_],
    across: NDArray[np.floating],
) -> NDArray[np.floating]:
    """Return shifts (N, 2), along columns and rows [cells], onto the smoothed contour."""
    own = height[rows, columns]
    padded = np.pad(height, _REACH, mode="edge")
    window = padded[
        rows[:, None, None] + _REACH + _SPAN[:, None], columns[:, None, None] + _REACH + _SPAN
    ]
    # 0 at the height of the foot, 1 at that of the head, whatever lies beyond.
    low, high = np.where(is_high, across, own), np.where(is_high, own, across)
    part = (window - low[:, None, None]) / np.maximum(high - low, 1e-6)[:, None, None]
    part = np.clip(part, 0.0, 1.0)
    wanted = np.where(is_high, 0.5 + _BATTER, 0.5 - _BATTER)
    shift = np.zeros((len(rows), 2))
    for _ in range(_STEPS):
        x, z = _SPAN - shift[:, :1], _SPAN - shift[:, 1:]
        wx, wz = (np.exp(-0.5 * (d / _WIDTH) ** 2) for d in (x, z))
        wx, wz = wx / wx.sum(axis=1)[:, None], wz / wz.sum(axis=1)[:, None]
        value = np.einsum("nij,ni,nj->n", part, wz, wx)
        # The weights' slopes are exact but for the cut at the reach.
        mx, mz = (wx * x).sum(axis=1), (wz * z).sum(axis=1)
        slope_x = np.einsum("nij,ni,nj->n", part, wz, wx * x) - value * mx
        slope_z = np.einsum("nij,ni,nj->n", part, wz * z, wx) - value * mz
        slope = np.stack([slope_x, slope_z], axis=-1) / _WIDTH**2
        steep = np.maximum((slope**2).sum(axis=-1), 1e-3)
        step = ((wanted - value) / steep)[:, None] * slope
        length = np.maximum(np.hypot(*step.T) / _LONGEST_STEP, 1.0)
        shift = shift + step / length[:, None]
    longest = np.maximum(np.hypot(*shift.T) / _MAX_SHIFT, 1.0)
    return np.asarray(shift / longest[:, None])
