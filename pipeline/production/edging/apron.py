"""Apron: the ground between a floor and the edge of its terrain, which creeps over the border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.surroundings.land import PLATFORM_HEIGHT
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array
from render.shot import Mesh

CELL = 0.22
"""Side of the cells of its mesh [m]."""

BELOW = 0.09
"""Depth of the bed on which slabs lie [m]."""

MOST_OVER = 0.06
"""Greatest height of the soil over a floor [m]."""

SLOPE_STEP = 0.3
"""Distance over which its slope is measured [m]."""

SOIL = (0.062, 0.045, 0.028)
"""Linear colour of bare soil along a floor."""


@dataclass(frozen=True, eq=False)
class Apron:
    """The ground around and under a floor.

    Attributes:
        plan: of the floor.
        creeps: whether soil and grass come over its border.
        seed: of its unevenness.
    """

    plan: FloorPlan
    creeps: bool
    seed: int

    def height(self, places: Array) -> Array:
        """Return the heights (N,) at places (N, 2) on the terrain [m]."""
        plan = self.plan
        out = plan.beyond(places)
        level = plan.height - PLATFORM_HEIGHT
        edge = np.minimum(places - plan.ground[0], plan.ground[1] - places).min(axis=-1)
        far = level + 0.05 * fractal(places / 2.3, self.seed + 31, 3) * smoothstep(0.0, 2.0, edge)
        if not self.creeps:
            return np.asarray(np.where(out < 0.0, level - 0.05, far))
        ragged = out + 0.75 * plan.piece * fractal(places / 1.7, self.seed + 32, 3)
        over = smoothstep(-1.7 * plan.piece, 0.25 * plan.piece, ragged)
        rough = 0.035 * fractal(places / 0.6, self.seed + 33, 3)
        near = plan.height - BELOW + over * (BELOW - 0.002 + rough)
        held = smoothstep(0.4, 1.0, plan.free(places))
        near = np.minimum(near, plan.height - BELOW + held * (BELOW + MOST_OVER))
        inner = near + (far - near) * smoothstep(0.2, 3.0, out)
        # Where the floor reaches the edge of the terrain, the land begins below it.
        return np.asarray(level + (inner - level) * smoothstep(0.0, 0.6, edge))

    def is_floor(self, places: Array) -> NDArray[np.bool_]:
        """Return at which places (N, 2) the floor is seen."""
        if not self.creeps:
            return self.plan.beyond(places) < 0.0
        return self.plan.has_piece(places) & (self.height(places) < self.plan.height - 0.004)

    def surface(self, places: Array) -> tuple[Array, Array]:
        """Return heights (N,) and normals (N, 3) at places (N, 2)."""
        low = self.height(places)
        rise = [
            (self.height(places + SLOPE_STEP * np.array(way)) - low) / SLOPE_STEP
            for way in ((1.0, 0.0), (0.0, 1.0))
        ]
        normal = np.stack([-rise[0], np.ones_like(low), -rise[1]], axis=-1)
        return low, normal / np.linalg.norm(normal, axis=-1, keepdims=True)

    def mesh(self, material: str) -> Mesh:
        """Return its mesh, of the material of the land."""
        low, high = self.plan.ground
        counts = np.maximum(np.ceil((high - low) / CELL).astype(int), 2)
        x, z = (np.linspace(low[k], high[k], counts[k] + 1) for k in (0, 1))
        places = np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2)
        height = self.height(places)
        vertices = np.stack([places[:, 0], height, places[:, 1]], axis=-1).astype(np.float32)
        i, j = np.meshgrid(np.arange(counts[0]), np.arange(counts[1]))
        a = (j * (counts[0] + 1) + i).ravel()
        b, c = a + 1, a + counts[0] + 1
        faces = np.concatenate(
            [np.stack([a, c, b], axis=-1), np.stack([b, c, c + 1], axis=-1)]
        ).astype(np.uint32)
        out = self.plan.beyond(places)
        ragged = np.abs(out) + 0.8 * fractal(places / 0.9, self.seed + 34, 3)
        share = 0.85 * (1.0 - smoothstep(0.15, 1.3, ragged))
        cover = np.column_stack([np.tile(SOIL, (len(places), 1)), share]).astype(np.float32)
        return Mesh("apron", vertices, faces, material, uv=vertices[:, [0, 2]], cover=cover)
