"""Vertex normals: the directions with which a smooth mesh is shaded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def vertex_normals(vertices: NDArray[np.float32], faces: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Return the unit normals of the vertices, weighted by the area of the faces.

    Mitsuba would sum them in parallel in any order.

    Args:
        vertices: (V, 3) [m].
        faces: (F, 3).
    """
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    n = np.cross(b - a, c - a)
    corners = faces.T.ravel()
    sums = [np.bincount(corners, np.tile(n[:, i], 3), len(vertices)) for i in range(3)]
    total = np.stack(sums, axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    # A vertex of collapsed triangles only is invisible; any direction will do.
    up = np.array([0.0, 1.0, 0.0])
    return np.where(length > 1e-20, total / np.maximum(length, 1e-20), up).astype(np.float32)
