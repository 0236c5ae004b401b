"""Pass tracer: the passes of a frame, moment by moment of its exposure.

Only the paths' first segments are traced, in a pass of its own: what the film's paths meet on
their way is none of its business, and glass is met like anything else.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from render.meshes import MeshGroup
from render.passes.cryptomatte import Cryptomatte, cryptomatte
from render.passes.first_hits import SKY, CenterHits, FirstHits
from render.passes.pass_images import SKY_DEPTH, Image, PassImages
from render.shot import CameraPose, Mesh, Moment, Shot
from render.tracing.stratification import PassStrata, stratum_grid

SAMPLES = 16
"""Fewest samples of a pixel for coverage: edges in steps of a sixteenth."""


class PassTracer:
    """Traces the passes of the shots of one build.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        shapes: of the scene by their names: that of group g is `mesh{g}`, that of group s of the
            scenery `still{s}`, that of lamp i `lamp{i}`.
        shot: any of the build.
        groups: merged meshes of the shot.
        still: merged meshes of its scenery.
    """

    def __init__(
        self,
        scene: Any,
        shapes: Mapping[str, Any],
        shot: Shot,
        groups: Sequence[MeshGroup],
        still: Sequence[MeshGroup],
    ) -> None:
        self._film, self._groups = shot.film.resolved(), groups
        lamps = [name for name in shapes if name.startswith("lamp")]
        objects = [*shot.meshes, *shot.scenery]
        first_still, first_lamp = 1 + len(shot.meshes), 1 + len(objects)
        self._names: Mapping[str, Sequence[str]] = {
            "CryptoObject": ["", *(mesh.name for mesh in objects), *lamps],
            "CryptoAsset": ["", *(mesh.owner or mesh.name for mesh in objects), *lamps],
            "CryptoMaterial": ["", *(mesh.material for mesh in objects), *("lamp" for _ in lamps)],
        }
        merged = [
            *((f"mesh{g}", group, shot.meshes, 1) for g, group in enumerate(groups)),
            *((f"still{s}", group, shot.scenery, first_still) for s, group in enumerate(still)),
        ]
        self._hits = FirstHits(
            scene,
            [
                (shapes[name], _objects_of_faces(group, meshes, first))
                for name, group, meshes, first in merged
            ],
            [(shapes[name], first_lamp + i) for i, name in enumerate(lamps)],
            self._film.size,
        )

    def begin(self, shot: Shot) -> PassExposure:
        """Return the passes of a shot before its first moment."""
        return PassExposure(self, shot)

    def centers(self, sensor: Any) -> CenterHits:
        """Return what is in the middle of every pixel."""
        return self._hits.centers(sensor)

    def objects(self, sensor: Any, strata: PassStrata) -> NDArray[np.uint32]:
        """Return the number of the object that one sample of every pixel meets, (H, W)."""
        return self._hits.objects(sensor, strata)

    def mattes(self, ids: NDArray[np.uint32]) -> tuple[Cryptomatte, ...]:
        """Return the mattes of all samples (N, H, W)."""
        return tuple(cryptomatte(name, names, ids) for name, names in self._names.items())

    def moved(self, hits: CenterHits, meshes: Sequence[Mesh]) -> NDArray[np.float64]:
        """Return where the points that are hit are (P, 3) when the meshes have moved [m]."""
        points = hits.point.astype(float)
        for g, group in enumerate(self._groups):
            seen = np.flatnonzero(hits.group == g)
            if not seen.size:
                continue
            vertices = np.concatenate([meshes[i].vertices for i in group.members]).astype(float)
            corners = vertices[group.faces[hits.face[seen]]]
            u, v = hits.place[seen].astype(float).T
            shares = np.stack([1 - u - v, u, v], axis=-1)
            points[seen] = (shares[..., None] * corners).sum(axis=1)
        return points


class PassExposure:
    """The passes of one frame while its shutter is open."""

    def __init__(self, tracer: PassTracer, shot: Shot) -> None:
        self._tracer, self._shot = tracer, shot
        self._film = shot.film.resolved()
        self._wanted = frozenset(self._film.passes)
        self._first: CenterHits | None = None
        self._ids: list[NDArray[np.uint32]] = []

    def add(self, sensor: Any, k: int) -> None:
        """Add what the sensor sees at the k-th moment of the exposure."""
        if k == 0 and self._wanted & {"depth", "normal", "motion"}:
            self._first = self._tracer.centers(sensor)
        if not self._wanted & {"id", "alpha"}:
            return
        each = -(-SAMPLES // len(self._shot.moments))
        total = each * len(self._shot.moments)
        for pass_ in range(k * each, (k + 1) * each):
            strata = PassStrata(self._shot.seed, pass_, stratum_grid(total))
            self._ids.append(self._tracer.objects(sensor, strata))

    def images(self) -> PassImages:
        """Return the passes when the shutter has closed."""
        wanted, hits = self._wanted, self._first
        depth = normal = motion = alpha = None
        if hits is not None:
            depth = self._depth(hits) if "depth" in wanted else None
            normal = self._shaped(hits.normal) if "normal" in wanted else None
            motion = self._motion(hits) if "motion" in wanted else None
        ids = np.stack(self._ids) if self._ids else np.zeros((0, 0, 0), np.uint32)
        if "alpha" in wanted:
            alpha = (ids != SKY).mean(axis=0, dtype=np.float32)
        mattes = self._tracer.mattes(ids) if "id" in wanted else ()
        return PassImages(depth, normal, motion, alpha, mattes)

    def _shaped(self, values: NDArray[Any]) -> Image:
        width, height = self._film.size
        return values.astype(np.float32).reshape(height, width, *values.shape[1:])

    def _depth(self, hits: CenterHits) -> Image:
        camera = self._shot.camera
        along = (hits.point - np.array(camera.p_WC)) @ camera.axes[2]
        return self._shaped(np.where(hits.object == SKY, SKY_DEPTH, along))

    def _motion(self, hits: CenterHits) -> Image:
        after = self._shot.after or Moment(self._shot.meshes, self._shot.camera)
        now = self._tracer.moved(hits, self._shot.meshes)
        then = self._tracer.moved(hits, after.meshes)
        # The sky is so far away that only the turning of the camera moves it.
        sky = hits.object == SKY
        if sky.any():
            rays = self._sky_rays()[sky]
            now[sky] = np.array(self._shot.camera.p_WC) + rays
            then[sky] = np.array(after.camera.p_WC) + rays
        way = self._pixels(then, after.camera) - self._pixels(now, self._shot.camera)
        return self._shaped(np.nan_to_num(way, nan=0.0, posinf=0.0, neginf=0.0))

    def _pixels(self, points: NDArray[np.float64], camera: CameraPose) -> NDArray[np.float64]:
        """Return where points (P, 3) are in the picture (P, 2) [pixels], right and up."""
        x, y, z = ((points - np.array(camera.p_WC)) @ camera.axes.T).T
        scale = self._film.size[1] / 2 / math.tan(math.radians(camera.fov_deg) / 2)
        # What is beside or behind the camera is nowhere in the picture.
        z = np.where(z > 1e-6, z, np.nan)
        return scale * np.stack([x / z, y / z], axis=-1)

    def _sky_rays(self) -> NDArray[np.float64]:
        """Return the directions (P, 3) through the middles of the pixels."""
        width, height = self._film.size
        camera = self._shot.camera
        scale = 2 * math.tan(math.radians(camera.fov_deg) / 2) / height
        rows, columns = np.mgrid[0:height, 0:width]
        x = (columns.ravel() + 0.5 - width / 2) * scale
        y = (height / 2 - rows.ravel() - 0.5) * scale
        return np.asarray(np.stack([x, y, np.ones_like(x)], axis=-1) @ camera.axes)


def _objects_of_faces(group: MeshGroup, meshes: Sequence[Mesh], first: int) -> NDArray[np.uint32]:
    """Return the number of the mesh that each triangle of a merged mesh belongs to.

    Args:
        group: of the meshes.
        meshes: those that were merged in groups.
        first: number of the first of them.
    """
    counts = [len(meshes[i].faces) for i in group.members]
    return np.repeat(np.array(group.members, np.uint32) + np.uint32(first), counts)
