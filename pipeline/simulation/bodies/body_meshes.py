"""Body meshes: bevelled polyhedra, balls, and the pips of dice.

Edges are cut off so that light catches on them: every facet shrinks a little in its plane, and the
hull of the smaller ones has a strip for each edge and a small polygon for each corner.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import MassError
from pipeline.simulation.bodies.prop_shapes import SHAPE_SOLIDS, prop_solid
from pipeline.simulation.dynamics.hull import Hull, hull_of
from pipeline.simulation.dynamics.rigid_body import BodyModel
from pipeline.simulation.figures.solids import Solid, ball_solid
from pipeline.simulation.spatial import Array, cross, normalized

BEVEL_WIDTH = 0.02
"""Width that facets lose, relative to the extent of the body."""

MAX_INSET = 0.3
"""Largest inset, relative to the distance of a facet's centre from its sides."""

MAX_BEVELLED_FACETS = 64
"""Bodies with more facets are not bevelled."""


def bevelled(hull: Hull) -> Solid:
    """Returns the visible surface, each facet with its own vertices."""
    if len(hull.facets) <= MAX_BEVELLED_FACETS:
        width = BEVEL_WIDTH * float(np.ptp(hull.vertices, axis=0).max())
        shrunk = [
            _inset_polygon(hull.vertices[list(facet)], normal, width)
            for facet, normal in zip(hull.facets, hull.normals, strict=True)
        ]
        try:
            hull = hull_of(np.concatenate(shrunk))
        except MassError:
            pass
    return _flat_shaded(hull)


def _inset_polygon(polygon: Array, normal: Array, width: float) -> Array:
    """Returns a convex polygon (n, 3) whose sides are moved inward."""
    sides = normalized(np.roll(polygon, -1, axis=0) - polygon)
    inward = cross(np.broadcast_to(normal, sides.shape), sides)
    middle = polygon.mean(axis=0)
    room = float(((middle - polygon) * inward).sum(axis=1).min())
    width = min(width, MAX_INSET * room)
    before = np.roll(inward, 1, axis=0)
    cosine = (before * inward).sum(axis=1, keepdims=True)
    return polygon + width * (before + inward) / (1.0 + cosine)


def _flat_shaded(hull: Hull) -> Solid:
    """Returns a hull whose facets share no vertices, for flat shading."""
    vertices, faces, first = [], [], 0
    for facet in hull.facets:
        n = len(facet)
        vertices.append(hull.vertices[list(facet)])
        fan = np.arange(1, n - 1)
        faces.append(first + np.column_stack([np.zeros(n - 2, dtype=np.int64), fan, fan + 1]))
        first += n
    return Solid(np.concatenate(vertices), np.concatenate(faces).astype(np.uint32))


PIP_MATERIAL = "rubber"

PIP_RADIUS = 0.085
"""Radius of a pip, in edges."""

PIP_SPREAD = 0.25
"""Distance of a pip from the centre lines of the face, in edges."""

PIP_HEIGHT = 0.003
"""Height of a pip above the face, in edges."""

PIP_SIDES = 20

PIP_PLACES = {
    1: [(0, 0)],
    2: [(-1, -1), (1, 1)],
    3: [(-1, -1), (0, 0), (1, 1)],
    4: [(-1, -1), (-1, 1), (1, -1), (1, 1)],
    5: [(-1, -1), (-1, 1), (0, 0), (1, -1), (1, 1)],
    6: [(-1, -1), (-1, 0), (-1, 1), (1, -1), (1, 0), (1, 1)],
}

FACE_AXES = {1: (1, 1.0), 6: (1, -1.0), 2: (0, 1.0), 5: (0, -1.0), 3: (2, 1.0), 4: (2, -1.0)}
"""Axis and sign of the outward normal of each face of a die."""


def pips(edge: float) -> Solid:
    """Returns the pips of a die about its centre; opposite faces add up to seven.

    Args:
        edge: of the die [m].
    """
    angle = np.arange(PIP_SIDES) * (2.0 * np.pi / PIP_SIDES)
    vertices, faces = list[Array](), list[NDArray[np.int64]]()
    for number, (axis, sign) in FACE_AXES.items():
        out = np.zeros(3)
        out[axis] = sign
        a = np.roll(out, 1) * sign
        b = np.cross(out, a)
        rim = PIP_RADIUS * (np.cos(angle)[:, None] * a + np.sin(angle)[:, None] * b)
        for u, v in PIP_PLACES[number]:
            middle = 0.5 * out + PIP_SPREAD * (u * a + v * b)
            disc = np.concatenate([[middle + PIP_HEIGHT * out], middle + 0.001 * out + rim])
            first = sum(len(one) for one in vertices)
            k = np.arange(PIP_SIDES)
            turn = np.column_stack([np.zeros_like(k), 1 + k, 1 + (k + 1) % PIP_SIDES])
            vertices.append(edge * disc)
            faces.append(first + turn)
    return Solid(np.concatenate(vertices), np.concatenate(faces).astype(np.uint32))


def visible_solids(config: Any, build: BodyModel, material: str) -> list[tuple[str, Solid, str]]:
    """Returns the visible solids of a body: suffix of the part's name, solid and material."""
    if type(config) in SHAPE_SOLIDS:
        return [("", prop_solid(config), material)]
    if build.hull is None:
        return [("", ball_solid(np.zeros(3), build.radius), material)]
    seen = [("", bevelled(build.hull), material)]
    if config.shape == "die":
        seen.append((".pips", pips(config.size), PIP_MATERIAL))
    return seen
