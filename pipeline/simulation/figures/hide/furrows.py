"""Furrows: what of a hide lies between muscles, under a belly or behind a shoulder, and is darker.

The field of the lumps tells how open the air is above a place: over a bulge it grows faster than
the distance from the hide, in a furrow more slowly.

Source: Evans 2006 (ambient occlusion from distance fields).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.figures.hide.lumps import Lump, union_distance
from pipeline.simulation.figures.hide.sheets import Paint, lay, painted
from pipeline.simulation.figures.hide.stance import smoothstep
from pipeline.simulation.figures.solids import Solid, vertex_normals
from pipeline.simulation.spatial import Array

PROBES = (0.14, 0.38)
"""Heights above the hide at which the field is read, in the girth of the part."""

COLOR, SHARE = "#150e0a", 0.72
"""Colour of the deepest furrows, and its share there."""

LEAST, MOST = 0.07, 0.45
"""Loss of the field, in its distance, at which a furrow begins, and at which it is deepest."""


def furrowed(paint: Paint | None, lumps: Sequence[Lump], solid: Solid, girth: float) -> Paint:
    """Return the paint of a surface with its furrows, changing it where there is one.

    Args:
        paint: None for a surface without.
        lumps: whose union the surface is, with its vertices on it.
        solid: the surface as the figure stands.
        girth: radius of the part [m].
    """
    found = painted(len(solid.vertices), COLOR, 0.0) if paint is None else paint
    lay(found, COLOR, SHARE * furrow_share(lumps, solid, girth))
    return found


def furrow_share(lumps: Sequence[Lump], solid: Solid, girth: float) -> Array:
    """Return how deep in a furrow each vertex (V,) lies, from 0 to 1.

    Args:
        lumps: whose union the surface is, with its vertices on it.
        solid: the surface as the figure stands.
        girth: radius of the part [m].
    """
    normals = vertex_normals(solid.vertices, solid.faces)
    loss = np.zeros(len(solid.vertices))
    for height in PROBES:
        away = height * girth
        value = union_distance(lumps, solid.vertices + away * normals)
        loss += np.clip(1.0 - value / away, 0.0, 1.0) / len(PROBES)
    return smoothstep((loss - LEAST) / (MOST - LEAST))
