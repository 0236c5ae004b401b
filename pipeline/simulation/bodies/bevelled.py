"""Bevelled: what is seen of a polyhedron, its edges cut off so that light catches on them.

Every facet shrinks a little in its plane; the hull of the smaller ones has a strip for each
edge and a small polygon for each corner, and stands on the same planes.
"""

from __future__ import annotations

import numpy as np

from pipeline.errors import MassError
from pipeline.simulation.dynamics.hull import Hull, hull_of
from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.spatial import Array, cross, normalized

BEVEL = 0.02
"""Width that facets lose, as a part of the extent of the body."""

NARROW = 0.3
"""Most of it, as a part of the distance of a facet's middle from its sides."""

MOST_FACETS = 64
"""Bodies of more are round enough."""


def bevelled(hull: Hull) -> Solid:
    """Return the surface that is seen, each facet with vertices of its own."""
    if len(hull.facets) <= MOST_FACETS:
        width = BEVEL * float(np.ptp(hull.vertices, axis=0).max())
        shrunk = [
            _shrunk(hull.vertices[list(facet)], normal, width)
            for facet, normal in zip(hull.facets, hull.normals, strict=True)
        ]
        try:
            hull = hull_of(np.concatenate(shrunk))
        except MassError:
            pass
    return _faceted(hull)


def _shrunk(polygon: Array, normal: Array, width: float) -> Array:
    """Return a convex polygon (n, 3) whose sides have moved inward."""
    sides = normalized(np.roll(polygon, -1, axis=0) - polygon)
    inward = cross(np.broadcast_to(normal, sides.shape), sides)
    middle = polygon.mean(axis=0)
    room = float(((middle - polygon) * inward).sum(axis=1).min())
    width = min(width, NARROW * room)
    before = np.roll(inward, 1, axis=0)
    cosine = (before * inward).sum(axis=1, keepdims=True)
    result: Array = polygon + width * (before + inward) / (1.0 + cosine)
    return result


def _faceted(hull: Hull) -> Solid:
    """Return a hull whose facets share no vertices, so that each is shaded flat."""
    vertices, faces, first = [], [], 0
    for facet in hull.facets:
        n = len(facet)
        vertices.append(hull.vertices[list(facet)])
        fan = np.arange(1, n - 1)
        faces.append(first + np.column_stack([np.zeros(n - 2, dtype=np.int64), fan, fan + 1]))
        first += n
    return Solid(np.concatenate(vertices), np.concatenate(faces).astype(np.uint32))
