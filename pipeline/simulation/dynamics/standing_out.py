"""Standing out: the edges of a surface from which the ground falls away on both sides.

What lies on a surface touches it with its own corners, but for these edges and their ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, cross

STANDS_OUT = 1e-9
"""Height by which two triangles differ from one plane, in cells: less is rounding."""


def standing_out(vertices: Array, faces: NDArray[np.uint32], cell: float) -> NDArray[np.int64]:
    """Return the edges (E, 2) that stand out, and the border.

    Args:
        vertices: (V, 3) [m].
        faces: (F, 3) triangles, counter-clockwise from above.
        cell: length of a cell [m].
    """
    whole = faces.astype(np.int64)
    sides = np.concatenate([whole[:, [0, 1, 2]], whole[:, [1, 2, 0]], whole[:, [2, 0, 1]]])
    ends = np.sort(sides[:, :2], axis=1)
    order = np.argsort(ends[:, 0] * len(vertices) + ends[:, 1], kind="stable")
    ends, sides = ends[order], sides[order]
    twin = np.zeros(len(ends), dtype=bool)
    twin[:-1] = (ends[1:] == ends[:-1]).all(axis=1)
    first = np.flatnonzero(twin)
    a, b, c = np.moveaxis(vertices[sides[first]], 1, 0)
    other = vertices[sides[first + 1, 2]]
    up = cross(b - a, c - a)
    up /= np.sqrt((up**2).sum(axis=-1))[:, None]
    falls = (up * (other - a)).sum(axis=-1) < -STANDS_OUT * cell
    alone = ~twin
    alone[first + 1] = False
    return np.concatenate([ends[first[falls]], ends[alone]])
