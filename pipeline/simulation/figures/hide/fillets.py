"""Fillets: where the surface of a shank and that of the trunk go through one another.

Two surfaces that meet at a flat angle show a ragged line, because the light falls on them from
other sides. Both are moved out to the smooth union of the two solids: there they have one place
and one normal.

Source: Quilez 2013, the quadratic smooth minimum.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from pipeline.simulation.figures.hide.lumps import Lump, union_distance
from pipeline.simulation.figures.solids import Solid, vertex_normals
from pipeline.simulation.spatial import Array

BELOW = 0.92
"""Share of the way to the union by which hidden parts move out."""

WIDTH = 1.0
"""Distance of the other surface from which one is moved, in the mean radius of the shank."""


def filleted(trunk: Solid, lumps: Sequence[Lump], shank: Solid) -> tuple[Solid, Solid]:
    """Return a trunk and a shank with a fillet between them.

    Args:
        trunk: the surface of the lumps.
        lumps: of the trunk.
        shank: a closed surface that begins inside of the trunk.
    """
    on_trunk, on_shank = (vertex_normals(one.vertices, one.faces) for one in (trunk, shank))
    off, nearest = cKDTree(shank.vertices).query(trunk.vertices)
    width = WIDTH * _mean_radius(shank)
    # Beyond a vertex its tangential plane is the surface.
    away = trunk.vertices - shank.vertices[nearest]
    beyond = (away * on_shank[nearest]).sum(axis=-1)
    # Far aside of all vertices that plane means nothing.
    beyond = np.where(off < 4.0 * width, beyond, np.inf)
    from_trunk = union_distance(lumps, shank.vertices)
    return (
        Solid(trunk.vertices + _rise(beyond, width)[:, None] * on_trunk, trunk.faces),
        Solid(shank.vertices + _rise(from_trunk, width)[:, None] * on_shank, shank.faces),
    )


def _rise(distance: Array, width: float) -> Array:
    """Return by how much to move out a surface (n,) at distances from the other one.

    What is inside goes on just below the union: a surface that turned away from it at once would
    have another normal there.
    """
    near = np.maximum(width - np.abs(distance), 0.0)
    depth = np.maximum(-distance, 0.0)
    hidden = BELOW * np.minimum(depth, np.maximum(2.0 * width - depth, 0.0))
    return np.asarray(near * near / (4.0 * width) + hidden)


def _mean_radius(shank: Solid) -> float:
    """Return the mean radius of a shank: that of a tube of its volume and surface."""
    a, b, c = (shank.vertices[shank.faces[:, k]] for k in range(3))
    area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=-1).sum())
    volume = abs(float((a * np.cross(b, c)).sum())) / 6.0
    return 2.0 * volume / area
