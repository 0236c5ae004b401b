"""Standing out: the edges of a surface from which the ground falls away on both sides.

What lies on a surface touches it with its own corners, but for these edges and their ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, cross

STANDS_OUT = 1e-9
"""Height by which two triangles differ from one plane, in cells: less is rounding."""


def standing_out(
    vertices: Array, faces: NDArray[np.uint32], cell: float
) -> tuple[NDArray[np.int64], Array]:
    """Return the edges that stand out, and the border; beside that the ground drops upright.

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
    up = _normals(vertices[sides])
    ahead = vertices[sides[first + 1, 2]] - vertices[sides[first, 0]]
    falls = first[(up[first] * ahead).sum(axis=-1) < -STANDS_OUT * cell]
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


def _normals(triangles: Array) -> Array:
    """Return the normals (F, 3) of triangles (F, 3, 3)."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    up = cross(b - a, c - a)
    result: Array = up / np.sqrt((up**2).sum(axis=-1))[:, None]
    return result
