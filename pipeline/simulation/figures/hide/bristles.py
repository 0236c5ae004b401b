"""Bristles: the hair of arthropods, which stands off their plates and limbs."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.combed_hair import combed
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.hide.hair_lay import COATS
from pipeline.simulation.figures.solids import Solid, vertex_normals
from pipeline.simulation.spatial import Array

BACKWARD = np.array([-1.0, 0.0, 0.0])

BRISTLE_LIFT = np.radians(38.0)
"""How far bristles stand off [rad]."""

LIMB_LENGTH = 0.6
"""Length of the bristles of limbs, in that of the trunk."""


def bristle_length(figure: Figure) -> float:
    """Return the length of the bristles of the trunk [m]: none without a word for the coat."""
    name = figure.skin.coat
    if name is None:
        return 0.0
    girth = float(figure.drawing.radii[list(figure.anatomy.body)].max()) * figure.scale
    return COATS[name][0] * figure.skin.coat_length * girth


def trunk_bristles(figure: Figure, solid: Solid) -> Array | None:
    """Return the bristles (V, 3) of plates as the figure stands [m], None without."""
    return _bristles(solid, BACKWARD, bristle_length(figure))


def limb_bristles(figure: Figure, solid: Solid, way: Array) -> Array | None:
    """Return the bristles (V, 3) of a link that goes some way (3,) [m], None without."""
    return _bristles(solid, way, LIMB_LENGTH * bristle_length(figure))


def _bristles(solid: Solid, flow: Array, length: float) -> Array | None:
    if length == 0.0:
        return None
    normals = vertex_normals(solid.vertices, solid.faces)
    flows = np.broadcast_to(flow, normals.shape)
    return combed(flows, normals, length, float(BRISTLE_LIFT))
