"""Unwrapping: texture coordinates for a body, from six sides of the box around it at rest.

Every triangle is laid from the side that it faces, so that no pattern is stretched by
more than the square root of three. Where two sides meet, vertices are doubled; the
doubles keep the one normal of the surface, so that the seam is in the pattern alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_PLANES = np.array([[1, 2], [0, 2], [0, 1]])
"""Axes of the plane that is seen along each axis. What runs along a pattern's rows runs
along the first, which is the body's longest wherever it can be."""


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """A surface with doubled vertices.

    Attributes:
        source: (V,) the vertex of the surface that each vertex stands for.
        faces: (F, 3) in the doubled vertices.
        uv: (V, 2) texture coordinates [m].
    """

    source: NDArray[np.uint32]
    faces: NDArray[np.uint32]
    uv: NDArray[np.float32]


def unwrapped(rest: NDArray[np.float32], faces: NDArray[np.uint32]) -> Unwrapped:
    """Return a surface with texture coordinates.

    Args:
        rest: (N, 3) places of its vertices at rest, longest along the first axis [m].
        faces: (F, 3).
    """
    a, b, c = (rest[faces[:, i]].astype(float) for i in range(3))
    side = np.abs(np.cross(b - a, c - a)).argmax(axis=1)
    corners = faces.astype(np.int64) * 3 + side[:, None]
    kept, place = np.unique(corners, return_inverse=True)
    source = kept // 3
    uv = np.take_along_axis(rest[source], _PLANES[kept % 3], axis=1)
    numbered = place.reshape(faces.shape).astype(np.uint32)
    return Unwrapped(source.astype(np.uint32), numbered, uv.astype(np.float32))
