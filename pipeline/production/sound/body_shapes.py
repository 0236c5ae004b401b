"""Body shapes: the box, cylinder or ellipsoid that a part rings like, from its mesh."""

from __future__ import annotations

import numpy as np

from audio.acoustic_materials import shape_in_material
from audio.body_shape import FILLED_SHARES, BodyShape, ShapeKind
from pipeline.production.sound.sounding_parts import RigidPart
from pipeline.simulation.dynamics.mass import volume_of_solid
from pipeline.simulation.spatial import Array

# Shares of the bounding box that a box and a cylinder fill at least.
_BOX, _CYLINDER = 0.9, 0.66
# The last digits of places differ between classes of processor.
_DIGITS = 3
# A mesh that is open or flat may enclose nothing.
_LEAST_SHARE = 0.05


def body_shape(part: RigidPart, wall: float = 0.0) -> BodyShape | None:
    """Return the shape of a part; None if it has no extent.

    Args:
        part: the part.
        wall: thickness of its wall if it is hollow [m]; 0 if it is solid.
    """
    vertices = part.mesh.vertices.astype(float)
    extents = _extents(vertices, part.principal_axes)
    if extents.min() <= 0:
        return None
    share = abs(volume_of_solid(vertices, part.mesh.faces)) / float(extents.prod())
    kind: ShapeKind = "ellipsoid"
    if share > _CYLINDER:
        kind = "box" if share > _BOX else "cylinder"
    else:
        # What has corners fills less of its box: as much as this ellipsoid.
        extents = extents * (max(share, _LEAST_SHARE) / FILLED_SHARES[kind]) ** (1 / 3)
    thickness, width, length = (float(f"{x:.{_DIGITS}g}") for x in np.sort(extents))
    shape = BodyShape(kind, length, width, thickness)
    return shape.hollow(wall) if wall else shape_in_material(part.material, shape)


def _extents(vertices: Array, principal_axes: Array) -> Array:
    """Return the extents of the smaller of two bounding boxes [m]: (3,).

    The principal axes of a cube or a square plate are any.
    """
    own = np.ptp(vertices, axis=0)
    along = np.ptp((vertices[:, :, None] * principal_axes).sum(axis=1), axis=0)
    return np.asarray(along if along.prod() < 0.99 * own.prod() else own)
