"""Carried lamps: positions of the lamps of a scene at any row of its take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.camera.parent_nodes import resolve_parents
from pipeline.production.shots.skinning import interpolated_poses
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Place, Take
from pipeline.spec.scene import Scene
from render.config import Lamp
from render.shot import LampPlace


@dataclass(frozen=True)
class CarriedLamps:
    """Lamps with the nodes that carry them.

    Attributes:
        lamps: their configuration.
        nodes: that carry each lamp, -1 for the world.
    """

    lamps: tuple[Lamp, ...]
    nodes: tuple[int, ...]

    @staticmethod
    def of(scene: Scene, take: Take) -> CarriedLamps:
        """Return the lamps of a scene with their nodes.

        Raises:
            SceneError: the parent of a lamp does not exist.
        """
        lamps = scene.light.lamps
        parents = {f"light.lamps[{i}]": lamp.parent for i, lamp in enumerate(lamps)}
        return CarriedLamps(lamps, tuple(resolve_parents(scene, NodeNames.of(take), parents)))

    def placed(self, take: Take, at: float) -> tuple[LampPlace, ...]:
        """Return the places of the lamps at a row of a take or between two."""
        if not self.lamps:
            return ()
        q, p, _ = interpolated_poses(take, at)
        places = []
        for lamp, node in zip(self.lamps, self.nodes, strict=True):
            R, origin = np.eye(3), np.zeros(3)
            if node >= 0:
                R, origin = matrix(q[node]), p[node]
            aim = None if lamp.spot is None else _transformed(R, origin, lamp.spot.toward)
            places.append(LampPlace(_transformed(R, origin, lamp.at), aim))
        return tuple(places)


def _transformed(R: Array, origin: Array, point: Place) -> Place:
    x, y, z = (float(c) for c in origin + (R * np.array(point)).sum(axis=-1))
    return x, y, z
