"""First hits: what the camera meets first, sample by sample.

Objects are the meshes of the shot, which Mitsuba has merged: a table leads from the triangles of
a merged mesh back to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.tracing.camera_rays import camera_ray, central_ray
from render.tracing.stratification import PassStrata
from render.tracing.tracer import PixelLanes

SKY = 0
"""Number of no object."""


@dataclass(frozen=True, eq=False)
class CenterHits:
    """What the ray through the middle of each pixel meets, from a camera in full focus.

    Attributes:
        object: (P,) number of the object, `SKY` for none.
        group: (P,) number of the merged mesh, -1 for other shapes.
        face: (P,) of the merged mesh.
        place: (P, 2) second and third barycentric coordinate in the face.
        point: (P, 3) in the world [m]; of no meaning in the sky.
        normal: (P, 3) unit normal in the world, towards the camera; 0 in the sky.
    """

    object: NDArray[np.uint32]
    group: NDArray[np.int64]
    face: NDArray[np.uint32]
    place: NDArray[np.float32]
    point: NDArray[np.float32]
    normal: NDArray[np.float32]


class FirstHits:
    """Finds the objects of one Mitsuba scene.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        groups: shape of each merged mesh -> its number, and the numbers of the objects that its
            triangles belong to.
        others: shape -> number of the object that it is.
        size: width and height of the frame [pixels].
    """

    def __init__(
        self,
        scene: Any,
        groups: Sequence[tuple[Any, NDArray[np.uint32]]],
        others: Sequence[tuple[Any, int]],
        size: tuple[int, int],
    ) -> None:
        self._scene = scene
        self._lanes = PixelLanes(size)
        ids = [_registry_id(shape) for shape, _ in (*groups, *others)]
        starts = np.zeros(max(ids, default=0) + 1, np.uint32)
        self._group = np.full(len(starts), -1, np.int64)
        # Other shapes have one entry for all their faces.
        strides = np.zeros(len(starts), np.uint32)
        table: list[NDArray[np.uint32]] = [np.zeros(1, np.uint32)]
        end = 1
        for number, (shape, objects) in enumerate(groups):
            key = _registry_id(shape)
            starts[key], strides[key], self._group[key] = end, 1, number
            table.append(objects)
            end += len(objects)
        for shape, number in others:
            starts[_registry_id(shape)] = end
            table.append(np.array([number], np.uint32))
            end += 1
        self._starts, self._strides = mi.UInt32(starts), mi.UInt32(strides)
        self._table = mi.UInt32(np.concatenate(table))

    def objects(self, sensor: Any, strata: PassStrata) -> NDArray[np.uint32]:
        """Return the number of the object that one sample of every pixel meets, (H, W)."""
        width, height = self._lanes.size
        found = np.zeros(width * height, np.uint32)
        for pixels in self._lanes.chunks:
            ray = camera_ray(sensor, pixels, self._lanes.size, strata.step(0))
            hit = self._scene.ray_intersect_preliminary(ray, coherent=True)
            found[np.array(pixels)] = np.array(self._object(hit))
        return found.reshape(height, width)

    def centers(self, sensor: Any) -> CenterHits:
        """Return what is in the middle of every pixel."""
        width, height = self._lanes.size
        n = width * height
        hits = CenterHits(
            np.zeros(n, np.uint32),
            np.full(n, -1, np.int64),
            np.zeros(n, np.uint32),
            np.zeros((n, 2), np.float32),
            np.zeros((n, 3), np.float32),
            np.zeros((n, 3), np.float32),
        )
        for pixels in self._lanes.chunks:
            ray = central_ray(sensor, pixels, self._lanes.size)
            hit = self._scene.ray_intersect_preliminary(ray, coherent=True)
            si = hit.compute_surface_interaction(ray)
            normal = dr.select(hit.is_valid(), si.sh_frame.n, 0.0)
            normal = dr.select(dr.dot(si.n, ray.d) > 0.0, -normal, normal)
            at = np.array(pixels)
            shape = np.array(dr.reinterpret_array(mi.UInt32, hit.shape))
            hits.object[at] = np.array(self._object(hit))
            hits.group[at] = self._group[np.where(shape < len(self._group), shape, 0)]
            hits.face[at] = np.array(hit.prim_index)
            hits.place[at] = np.array(hit.prim_uv).T
            hits.point[at] = np.array(si.p).T
            hits.normal[at] = np.array(normal).T
        return hits

    def _object(self, hit: Any) -> Any:
        """Return the numbers of the objects that are hit."""
        shape: Any = dr.reinterpret_array(mi.UInt32, hit.shape)
        known = hit.is_valid() & (shape < dr.width(self._starts))
        start = dr.gather(mi.UInt32, self._starts, shape, known)
        stride = dr.gather(mi.UInt32, self._strides, shape, known)
        return dr.gather(mi.UInt32, self._table, start + stride * hit.prim_index, known)


def _registry_id(shape: Any) -> int:
    return int(np.array(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape)))[0])
