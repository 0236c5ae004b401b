"""Ground surface: the visible ground under plants and stones, on the terrain and on the land."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.production.edging.apron import Apron
from pipeline.production.surroundings.land import Land
from pipeline.production.surroundings.land_cover import Color, Site, woods
from pipeline.production.surroundings.rings import border, rim_places, turned
from pipeline.simulation.spatial import Array
from render.shot import Mesh

SHORE = 0.12
"""Height over water from which on something grows [m]."""

BANK = 0.6
"""Distance from the water's edge within which a place is on the shore [m]."""

DEEP = 0.7
"""Depth of water from which reeds and stones of a shore stand in it no more [m]."""

SLOPE_STEP = 0.4
"""Distance over which the slope of the land is measured [m]."""


@dataclass(frozen=True, eq=False)
class GroundPlaces:
    """The ground at N places.

    Attributes:
        height: (N,) [m].
        normals: (N, 3).
        color: (N, 3) linear.
        on_terrain: (N,) whether they lie on the terrain.
        dry: (N,) whether they lie above the water.
    """

    height: Array
    normals: Array
    color: Array
    on_terrain: NDArray[np.bool_]
    dry: NDArray[np.bool_]


class GroundSurface:
    """The triangles of terrain and land.

    Args:
        land: around the terrain.
        mesh: of the land.
        color: linear mean colour of the ground on the terrain.
        land_color: linear mean colour of the material of the land.
        around: number of vertices of a ring of the mesh.
        water: level of the water [m], None without any.
        apron: around a floor on the terrain, None where all of the terrain is seen.
    """

    def __init__(
        self,
        land: Land,
        mesh: Mesh,
        color: Color,
        land_color: Color,
        around: int,
        water: float | None = None,
        apron: Apron | None = None,
    ) -> None:
        self._land, self._water, self._apron = land, water, apron
        self._color, self._land_color = np.asarray(color, float), np.asarray(land_color, float)
        edge = len(border(land.field))
        rings = np.asarray(mesh.vertices[edge:], float)
        self._rings = rings.reshape(-1, around, 3)
        cover = np.zeros((len(mesh.vertices), 4)) if mesh.cover is None else mesh.cover
        self._cover = np.asarray(cover[edge:], float).reshape(-1, around, 4)
        self._rim = rim_places(land.half, around)
        self._angles = turned(self._rim, land.half)
        first = self._grid_places(self._rings[:, 0])
        self._out = np.hypot(*(first - self._rim[0]).T)

    @cached_property
    def end(self) -> float:
        """Distance from the middle of the terrain at which the land ends [m]."""
        return float(self._out[-1])

    def _grid_places(self, points: Array) -> Array:
        return np.stack(self._land.field.to_grid(points[:, 0], points[:, 2]), axis=-1)

    def at(self, x: Array, z: Array) -> GroundPlaces:
        """Return the ground at places (N,) of the world [m]."""
        field = self._land.field
        on_terrain = field.inside(x, z)
        height, normals = field.surface(x, z)
        color = np.broadcast_to(self._color, (len(x), 3)).copy()
        outside = np.flatnonzero(~on_terrain)
        if self._apron is not None:
            places = np.stack([x, z], axis=-1)
            bare = np.flatnonzero(on_terrain)
            bare = bare[~self._apron.is_floor(places[bare])]
            height[bare], normals[bare] = self._apron.surface(places[bare])
            color[bare] = self._land_color
            on_terrain = on_terrain.copy()
            on_terrain[bare] = False
        if len(outside):
            ox, oz = x[outside], z[outside]
            low, cover = self._land_at(ox, oz)
            rise = [
                (self._land_at(ox + SLOPE_STEP * i, oz + SLOPE_STEP * j)[0] - low) / SLOPE_STEP
                for i, j in ((1, 0), (0, 1))
            ]
            height[outside] = low
            normal = np.stack([-rise[0], np.ones_like(low), -rise[1]], axis=-1)
            normals[outside] = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
            share = cover[:, 3:]
            color[outside] = self._land_color * (1.0 - share) + cover[:, :3] * share
        dry = np.ones(len(x), bool) if self._water is None else height > self._water + SHORE
        return GroundPlaces(height, normals, color, on_terrain, dry)

    def height(self, x: Array, z: Array) -> Array:
        """Return the height of the ground at places (N,) of the world [m]."""
        field = self._land.field
        on_terrain = field.inside(x, z)
        height, _ = field.surface(x, z)
        outside = np.flatnonzero(~on_terrain)
        if self._apron is not None:
            places = np.stack([x, z], axis=-1)
            bare = np.flatnonzero(on_terrain)
            bare = bare[~self._apron.is_floor(places[bare])]
            height[bare] = self._apron.height(places[bare])
        if len(outside):
            height[outside] = self._land_at(x[outside], z[outside])[0]
        return height

    def shore(self, x: Array, z: Array, height: Array) -> NDArray[np.bool_]:
        """Return which places (N,), whose height is known, are near the edge of the water."""
        if self._water is None:
            return np.zeros(len(x), bool)
        wet = height < self._water
        others = np.zeros(len(x), int)
        for angle in np.arange(0.0, 2.0 * np.pi, 0.25 * np.pi):
            there = self.height(x + BANK * np.cos(angle), z + BANK * np.sin(angle))
            others += (there < self._water) != wet
        # What water surrounds is an islet, which stays as it is.
        near = np.where(wet, others > 1, (others > 0) & (others < 5))
        return near & (height > self._water - DEEP)

    def depth(self, height: Array) -> Array:
        """Return the depth (N,) of the water over ground of a height [m], 0 without any."""
        return np.zeros(len(height)) if self._water is None else self._water - height

    def woods(self, x: Array, z: Array, height: Array) -> Array:
        """Return the share (N,) of the land at places (N,) that trees cover."""
        places = np.stack(self._land.field.to_grid(x, z), axis=-1)
        out = self._land.beyond(places)
        sea = self._land.sea_level
        above = height - (self._land.level if sea is None else sea)
        still = np.zeros(len(x))
        site = Site(
            places, out, np.zeros_like(places), above, still, self._land.seed, (0.0, 0.0, 0.0)
        )
        return woods(site, self._land.kind)

    def _land_at(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Return height (N,) and cover (N, 4) of the triangles of the land."""
        places = np.stack(self._land.field.to_grid(x, z), axis=-1)
        count = len(self._angles)
        angle = turned(places, self._land.half)
        column = np.clip(np.searchsorted(self._angles, angle, side="right") - 1, 0, count - 1)
        after = (column + 1) % count
        ends = np.append(self._angles, 2.0 * np.pi)
        # Along a ring places are linear in the chord, not in the angle.
        a, b = self._rim[column], self._rim[after]
        cross_a = a[:, 0] * places[:, 1] - a[:, 1] * places[:, 0]
        cross_b = places[:, 0] * b[:, 1] - places[:, 1] * b[:, 0]
        part_a = np.abs(cross_a) / np.hypot(*a.T)
        part_b = np.abs(cross_b) / np.hypot(*b.T)
        u = part_a / np.maximum(part_a + part_b, 1e-12)
        u = np.where(ends[column + 1] > ends[column], u, 0.0)
        rim = np.hypot(*a.T) * (1.0 - u) + np.hypot(*b.T) * u
        out = np.hypot(*places.T) - rim
        ring = np.clip(np.searchsorted(self._out, out, side="right") - 1, 0, len(self._out) - 2)
        wide = self._out[ring + 1] - self._out[ring]
        v = np.clip((out - self._out[ring]) / wide, 0.0, 1.0)
        near, far = np.maximum(u, v), np.minimum(u, v)

        def value(table: Array) -> Array:
            low, high = table[ring, column], table[ring + 1, after]
            side = np.where((u >= v)[:, None], table[ring, after], table[ring + 1, column])
            return np.asarray(low + near[:, None] * (side - low) + far[:, None] * (high - side))

        return value(self._rings[..., 1:2])[:, 0], value(self._cover)
