"""Land: the height of the ground beyond the edge of a terrain."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from pipeline.production.surroundings.choice import Choice
from pipeline.production.surroundings.landforms import LANDFORMS, SEA_DEPTH, beach
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.production.surroundings.roughness import Roughness
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TerrainRecord
from pipeline.simulation.terrain.heightfield import surface_of_vertices

PLATFORM_HEIGHT = 0.12
"""Height of a floor's lowest edge over the ground around it [m]."""

FADE = 110.0
"""Distance within which the roughness of the terrain fades to half [m]."""

SEA_BELOW = 0.35
"""Depth of the sea below the lowest point of the terrain [m]."""


class Land:
    """The ground beyond the edge of a terrain.

    Args:
        terrain: where it begins.
        kind: of surroundings; see `landforms`.
        joins: `rough` if the roughness of the terrain goes on, `drawn out` if its edge does, as
            that of a ditch, `platform` if the terrain stands on the ground with walls.
        seed: of its shapes.
        water_level: height of water over it [m], None for that of a sea, where there is one.

    Attributes:
        kind: of surroundings.
        is_platform: whether the terrain stands on it with walls.
        seed: of its shapes.
        field: surface of the terrain.
        half: half the terrain's extent along x and z [m].
    """

    def __init__(
        self,
        terrain: TerrainRecord,
        kind: str = "none",
        joins: str = "rough",
        seed: int = 0,
        water_level: float | None = None,
    ) -> None:
        self.kind, self.seed, self._joins, self._water_level = kind, seed, joins, water_level
        self.is_platform = joins == "platform"
        self.field = surface_of_vertices(terrain.vertices, terrain.cells)
        self.half = np.array(self.field.size) / 2.0
        self._heights = self.field.heights
        self._rough = Roughness(self._heights, self.field.size, seed + 90)

    @staticmethod
    def of(terrain: TerrainRecord, around: Choice) -> Land:
        """Return the land that a scene has around its terrain."""
        return Land(terrain, around.kind, around.joins, around.seed, around.water_level)

    @cached_property
    def level(self) -> float:
        """Height that the land has on average near the terrain [m]."""
        grid = self._heights
        rim = np.concatenate([grid[0], grid[-1], grid[:, 0], grid[:, -1]])
        if self.is_platform:
            return float(rim.min()) - PLATFORM_HEIGHT
        return float(rim.mean()) if self._joins == "drawn out" else self._rough.mean

    @property
    def sea_level(self) -> float | None:
        """Height of the sea [m], None where there is none."""
        if self.kind != "sea":
            return None
        return self.level + self._sea_shift if self._water_level is None else self._water_level

    @property
    def _sea_shift(self) -> float:
        low = self.level if self.is_platform else float(self._heights.min())
        return min(low - self.level, 0.0) - SEA_BELOW

    def height(self, x: Array, z: Array) -> Array:
        """Return the heights (N,) of the land at places (N,) of the world outside the terrain."""
        return self.height_in_grid(np.stack(self.field.to_grid(x, z), axis=-1))

    def beyond(self, places: Array) -> Array:
        """Return the distance (N,) of places (N, 2) in the grid's frame from the terrain [m]."""
        return np.hypot(*np.maximum(np.abs(places) - self.half, 0.0).T)

    def height_in_grid(self, places: Array) -> Array:
        """Return the heights (N,) of the land at places (N, 2) in the frame of the grid [m]."""
        out = self.beyond(places)
        near = self._near(places, out) / (1.0 + (out / FADE) ** 2)
        # A terrace stands at the shore.
        form = beach if self.is_platform and self.kind == "sea" else LANDFORMS[self.kind]
        return self.level + near + form(places, out, self.seed)

    def _near(self, places: Array, out: Array) -> Array:
        """Return what goes on of the terrain, relative to the level (N,)."""
        if self.is_platform:
            wave = fractal(places / 11.0, self.seed + 80, 4)
            return 0.16 * smoothstep(1.0, 14.0, out) * wave
        if self._joins == "rough":
            return self._rough.at(places) - self.level
        on_edge = np.clip(places, -self.half, self.half)
        edge = self._rough.at(on_edge) - self.level
        calm = np.exp(-((out / (1.2 * float(self.half.min()))) ** 2))
        return edge * calm + 0.12 * smoothstep(0.0, 9.0, out) * fractal(
            places / 7.0, self.seed + 80, 4
        )


__all__ = ["SEA_DEPTH", "Land"]
