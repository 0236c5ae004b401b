"""Shadow origins: where rays to a light start on a mesh with smooth normals.

Flat faces stand for a round surface. Near the edge of its shade some of them face away from a
light that the smooth normals still see, and rays from them would end in the mesh itself: the shade
would have the outline of the faces. So rays start on the round surface that the normals of the
corners describe.

Strands of a coat would shade one another in dots: their shadow rays start above the coat. How far
above them that is, is the length of their normals beyond 1.

Source: Hanika 2021; the rise besides is ours.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

MAX_RISE = 0.02
"""Farthest that a shadow origin lies from its face, which bounds light leaks at creases [m]."""

SPARE = 2.0
"""Rise besides, in the height of the round surface over its faces: neighbouring faces rise, too."""


def shadow_offset(hit: Any, si: Any, direction: Any, is_solid: Any, active: Any) -> Any:
    """Return the vector from points on faces to where their shadow rays start, `mi.Vector3f` [m].

    It is zero where the surface is flat or hollow towards the light, and on thin sheets.

    Args:
        hit: preliminary intersection with the face and the place in it.
        si: surface interaction at the same place.
        direction: to the light, unit vector.
        is_solid: which points are of surfaces that are no thin sheets.
        active: which points are asked for.
    """
    # A light behind the surface sees its other side, where hollows are round.
    side = dr.select(dr.dot(si.sh_frame.n, direction) < 0.0, mi.Float(-1), mi.Float(1))
    places = hit.prim_index, hit.prim_uv, si.p
    offset, lift = dr.dispatch(hit.shape, _rise, *places, side, active)
    length = dr.norm(offset)
    offset *= dr.select(length > MAX_RISE, MAX_RISE / length, 1.0)
    above = dr.select(side > 0.0, lift * si.sh_frame.n, 0.0)
    return dr.select(is_solid, offset, 0.0) + above


def _rise(shape: Any, face: Any, place: Any, p: Any, side: Any, active: Any) -> tuple[Any, Any]:
    """Return the way from points of one shape to its round surface, and their lift [m].

    Args:
        shape: of Mitsuba.
        face: of the shape.
        place: second and third barycentric coordinate in the face.
        p: points.
        side: 1 where the light is in front of the surface, -1 behind it.
        active: which points are asked for.
    """
    offset, middle, lift = mi.Vector3f(0.0), mi.Vector3f(0.0), mi.Float(0.0)
    if not isinstance(shape, mi.Mesh) or not shape.has_vertex_normals():
        return offset, lift
    found = shape.face_indices(face, active)
    corners = found.x, found.y, found.z
    at = [shape.vertex_position(corner, active) for corner in corners]
    normals = [side * mi.Vector3f(shape.vertex_normal(corner, active)) for corner in corners]
    shares = 1.0 - place.x - place.y, place.x, place.y
    bend: Any = mi.Float(0.0)
    for i, share in enumerate(shares):
        lift += share * (dr.norm(normals[i]) - 1.0)
        k = (i + 1) % 3
        offset -= share * dr.minimum(dr.dot(p - at[i], normals[i]), 0.0) * normals[i]
        bend = dr.maximum(bend, dr.abs(dr.dot(normals[k] - normals[i], at[k] - at[i])))
        middle += share * normals[i]
    return offset + SPARE * bend / 8.0 * middle, dr.maximum(lift, 0.0)
