"""Carried lamps: where the lamps of a scene are while its take goes on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.camera.parent_nodes import nodes_of
from pipeline.production.shots.skinning import poses
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Take
from pipeline.spec.scene import Scene
from render.config import Lamp
from render.shot import LampPlace

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class CarriedLamps:
    """Lamps with the nodes that carry them.

    Attributes:
        lamps: their words.
        nodes: that each goes along with, -1 for the world.
    """

    lamps: tuple[Lamp, ...]
    nodes: tuple[int, ...]

    @staticmethod
    def of(scene: Scene, take: Take) -> CarriedLamps:
        """Find who carries the lamps of a scene.

        Raises:
            SceneError: a lamp goes along with a part that nobody has.
        """
        lamps = scene.light.lamps
        parents = {f"light.lamps[{i}]": lamp.parent for i, lamp in enumerate(lamps)}
        return CarriedLamps(lamps, tuple(nodes_of(scene, NodeNames.of(take), parents)))

    def placed(self, take: Take, at: float) -> tuple[LampPlace, ...]:
        """Return where they are at a row of a take or between two."""
        if not self.lamps:
            return ()
        q, p, _ = poses(take, at)
        places = []
        for lamp, node in zip(self.lamps, self.nodes, strict=True):
            R, origin = np.eye(3), np.zeros(3)
            if node >= 0:
                R, origin = matrix(q[node]), p[node]
            aim = None if lamp.spot is None else _brought(R, origin, lamp.spot.toward)
            places.append(LampPlace(_brought(R, origin, lamp.at), aim))
        return tuple(places)


def _brought(R: Array, origin: Array, point: Triple) -> Triple:
    x, y, z = (float(c) for c in origin + (R * np.array(point)).sum(axis=-1))
    return x, y, z
