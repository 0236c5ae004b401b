"""Shooting: take and scene -> the shot of a frame."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.production.camera import camera_poses
from pipeline.production.landscape import ground_meshes
from pipeline.production.mounting import mounts_of
from pipeline.production.skinning import Skin
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Take
from pipeline.spec.scene import Scene
from render.shot import Mesh, Shot
from render.words import MATERIALS, Material


class Shooting:
    """Makes the shots of one take under one scene's looks.

    Attributes:
        poses: of the camera at every frame.

    Raises:
        SceneError: a camera goes along with a part that nobody has.
    """

    def __init__(self, scene: Scene, take: Take) -> None:
        self.take = take
        self.film = scene.film.resolved()
        self.light = scene.light
        header = take.header
        self.clock = Clock(header.rate, header.frames, header.steps, header.samples)
        aspect = self.film.size[0] / self.film.size[1]
        self.poses = camera_poses(take, scene.camera, aspect, mounts_of(scene, take.nodes))
        self.materials = _materials(scene, take)
        self._ground = ground_meshes(take.terrain, scene.terrain.show_forbidden)
        self._skin = Skin.of(take)

    def shot(self, frame: int) -> Shot:
        """Return the shot of the 1-based `frame`."""
        row = self.clock.row_of_frame(frame)
        vertices = self._skin.posed(self.take, row)
        meshes = list(self._ground)
        for i, part in enumerate(self.take.parts):
            mesh = self.take.meshes[part.mesh]
            placed = vertices[self._skin.starts[i] : self._skin.starts[i + 1]]
            if not part.life[0] <= row < part.life[1]:
                # Hidden by collapsing: the topology of a build stays as it is.
                placed = np.zeros_like(placed)
            meshes.append(Mesh(part.name, placed, mesh.faces, part.material))
        return Shot(
            meshes=tuple(meshes),
            materials=self.materials,
            light=self.light,
            camera=self.poses[frame - 1],
            film=self.film,
        )


def _materials(scene: Scene, take: Take) -> Mapping[str, Material]:
    """Return the materials that the take names: the author's own before the presets."""
    names = {part.material for part in take.parts} | {take.terrain.material}
    own = scene.materials
    return {name: own[name] if name in own else MATERIALS[name] for name in sorted(names)}
