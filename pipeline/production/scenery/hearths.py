"""Hearths: the places of fires on natural ground, which are burnt bare within a ring of stones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.group import Fire, Group
from pipeline.spec.scene import Scene

LEAST_RADIUS = 0.12
"""Radius from which a fire has a hearth [m]: smaller ones are those of torches and candles."""

HIGHEST = 0.4
"""Height over the ground from which a fire has none [m]: it burns on something."""

BURNT, UNEVEN = (1.7, 3.6), 0.5
"""Distances from the middle of a fire up to which the ground is bare, and from which grass grows
as ever, in its radius, and by how much they vary."""


@dataclass(frozen=True, eq=False)
class Hearths:
    """The hearths of a scene.

    Attributes:
        seed: of the scene.
        places: (N, 2) x and z of their middles [m].
        radii: (N,) of the fires [m].
    """

    seed: int
    places: Array
    radii: Array

    @staticmethod
    def of(scene: Scene, ground: HeightField) -> Hearths:
        """Return the hearths of the fires that stand on the ground of a scene."""
        kept = []
        for member in scene.cast:
            if not isinstance(member, Group) or not isinstance(member.group, Fire):
                continue
            is_carried = member.parent is not None
            if is_carried or scene.material(member.material or "flame").glow == 0.0:
                continue
            fire, (x, *up, z) = member.group, (float(c) for c in member.at)
            # Of two numbers it stands on the ground.
            over = up[0] - float(ground.height(np.array([x]), np.array([z]))[0]) if up else 0.0
            if fire.radius >= LEAST_RADIUS and over < HIGHEST:
                kept.append((x, z, fire.radius + 0.5 * fire.size))
        table = np.array(kept, float).reshape(-1, 3)
        return Hearths(scene.seed, table[:, :2], table[:, 2])

    def bare(self, places: Array, uneven: Array) -> Array:
        """Return the share (N,) of bare ground at places (N, 2), as uneven as noise (N,)."""
        result = np.zeros(len(places))
        for middle, radius in zip(self.places, self.radii, strict=True):
            away = np.hypot(*(places - middle).T) / radius + UNEVEN * uneven
            result = np.maximum(result, 1.0 - smoothstep(*BURNT, away))
        return result
