"""Puddles: rain that stands in the hollows of level ground.

Where it stands depends on the place, the ground and a seed alone. The surface follows the ground,
whose relief it washes level, a little above it, and shines as if it were level.
Drops raise rings in it, each for a moment that a hash of its place and its number decides.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.production.scenery.film_view import FilmView
from pipeline.production.surroundings.lattice_noise import fractal, hashed, smoothstep
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from render.config import Material, Weather
from render.shot import Mesh

MATERIAL = "puddle"

FLOOR_MATERIAL = "puddle on a floor"

MATERIALS = {
    MATERIAL: Material(color=(0.17, 0.15, 0.125), roughness=0.05),
    FLOOR_MATERIAL: Material(color=(0.22, 0.205, 0.19), roughness=0.03),
}
"""Shallow water over mud and over soaked paving, by name."""

LEAST_RAIN, SOAKED = 0.15, 0.5
"""Rain from which puddles begin to stand, and by which there are as many as there will be."""

FLOOR_RAIN = 2.5
"""How much more water a rain leaves on a floor, from which none seeps away."""

MOST = 0.42, 0.25
"""Heights of the noise above which ground is a puddle, in the least and in heavy rain."""

HOLLOW, HOLLOW_DEPTH = 0.7, 0.05
"""Width of the hollows in which water gathers, and a depth that counts [m]."""

LEVEL = 0.09, 0.2
"""Rises per metre from which less water stands, and from which none does."""

RIM = -0.05, 0.15
"""Depths in the noise between which the surface comes out of the ground."""

SUNK, LIFTED, FLOOR_LIFTED = 0.003, 0.003, 0.003
"""How far below the ground the surface ends, and how far it stands above it and a floor [m]. Its
edge must be less steep than what it mirrors is high, or it would mirror the ground below it."""

WASHED = -0.16, -0.07
"""Depths in the noise between which water washes the relief of the ground level, before the
surface begins."""

CRUMBS = 0.07, 0.09
"""Height of crumbs in the noise and their width [m]."""

MUD, DROWNED = (-0.3, 0.0), (-0.1, 0.06)
"""Depths in the noise between which the ground turns to mud, and between which plants end."""

REACH, BUDGET = 11.0, 110_000
"""Distance from the cameras up to which puddles are seen [m], and most of their triangles."""

TILE, PARTS = 0.24, 14
"""Side of the tiles of the surface [m], and edges along it."""

RING_CELL, RING_CYCLE, RING_LIFE = 0.2, 0.7, 0.62
"""Side of a cell that one drop at a time strikes [m], time from drop to drop and of a ring [s]."""

RING_SPEED, RING_LENGTH, RING_WIDTH, RING_SLOPE = 0.26, 0.05, 0.036, 0.5
"""Speed of a ring [m/s], length of its waves and width of their train [m], greatest slope."""

NOWHERE = -1.0
"""Depth in the noise of ground that is certainly dry."""


@dataclass(frozen=True, eq=False)
class Puddles:
    """The puddles of a scene.

    Attributes:
        seed: of the scene.
        rain: amount, 0 to 1.
        ground: of the terrain, beyond which none are looked for.
        is_floor: whether it is paved.
    """

    seed: int
    rain: float
    ground: HeightField
    is_floor: bool = False

    @staticmethod
    def of(
        seed: int, weather: Weather, ground: HeightField, *, is_floor: bool = False
    ) -> Puddles | None:
        """Return the puddles that a weather leaves on the ground, None without any."""
        made = Puddles(seed, weather.rain, ground, is_floor)
        return made if made._standing > LEAST_RAIN else None

    @property
    def _standing(self) -> float:
        """Rain that would leave as much water on natural ground."""
        return self.rain * (FLOOR_RAIN if self.is_floor else 1.0)

    def depth(self, x: Array, z: Array) -> Array:
        """Return about how deep (N,) places lie in a puddle, negative outside any."""
        result = np.full(len(x), NOWHERE)
        some = np.flatnonzero(self.ground.inside(x, z))
        x, z = x[some], z[some]
        wet = float(smoothstep(LEAST_RAIN, SOAKED, np.array(self._standing)))
        places = np.stack([x, z], axis=-1)
        noise = 0.45 * fractal(places / 1.5, self.seed + 4210, 2)
        noise += 0.22 * fractal(places / 0.42, self.seed + 4220, 2)
        # Crumbs of soil break the edge of the water.
        noise += CRUMBS[0] * fractal(places / CRUMBS[1], self.seed + 4225, 2)
        noise -= MOST[0] + wet * (MOST[1] - MOST[0])
        # The ground changes it by a quarter at most.
        near = np.flatnonzero(noise > MUD[0] - 0.25)
        noise[near] += self._gathered(x[near], z[near])
        result[some] = noise
        return result

    def _gathered(self, x: Array, z: Array) -> Array:
        """Return how much more water (N,) the shape of the ground gathers, or less."""
        height = self.ground.height
        sides = [(HOLLOW, 0.0), (-HOLLOW, 0.0), (0.0, HOLLOW), (0.0, -HOLLOW)]
        right, left, down, up = (height(x + a, z + b) for a, b in sides)
        hollow = 0.25 * (right + left + down + up) - height(x, z)
        steep = np.hypot(right - left, down - up) / (2.0 * HOLLOW)
        return np.asarray(
            0.25 * np.clip(hollow / HOLLOW_DEPTH, -1.0, 1.0) - smoothstep(*LEVEL, steep)
        )

    def mud(self, x: Array, z: Array) -> Array:
        """Return the share (N,) of mud in the ground about and below puddles."""
        return smoothstep(*MUD, self.depth(x, z))

    def relief(self, x: Array, z: Array) -> Array:
        """Return the share (N,) of the ground's relief that the water leaves."""
        return 1.0 - smoothstep(*WASHED, self.depth(x, z))

    def dry(self, x: Array, z: Array) -> Array:
        """Return the share (N,) of plants that the water leaves."""
        return 1.0 - smoothstep(*DROWNED, self.depth(x, z))

    def surface(self, view: FilmView) -> PuddleSurface | None:
        """Return what the cameras of a film see of them, None without any."""
        low = np.floor((view.eyes[:, [0, 2]].min(axis=0) - REACH) / TILE)
        high = np.ceil((view.eyes[:, [0, 2]].max(axis=0) + REACH) / TILE)
        i, j = (np.arange(a, b) for a, b in zip(low, high, strict=True))
        corners = TILE * np.stack(np.meshgrid(i, j), axis=-1).reshape(-1, 2)
        x, z = (corners + 0.5 * TILE).T
        middle = np.stack([x, self.ground.height(x, z), z], axis=-1)
        near = view.tile_distances(middle, np.full(len(x), TILE), around=0.0)
        seen = np.flatnonzero(near < REACH)
        # A tile may be dry in its middle and hold water at its edge.
        spots = [(a * TILE, b * TILE) for a in (-0.5, 0.0, 0.5) for b in (-0.5, 0.0, 0.5)]
        depths = [self.depth(x[seen] + a, z[seen] + b) for a, b in spots]
        seen = seen[np.max(depths, axis=0) > RIM[0]]
        most = BUDGET // (2 * PARTS**2)
        kept = np.sort(seen[np.argsort(near[seen], kind="stable")[:most]])
        return PuddleSurface.of(self, corners[kept]) if len(kept) else None


@dataclass(frozen=True, eq=False)
class PuddleSurface:
    """The surface of puddles, in triangles.

    Attributes:
        mesh: of the surface at rest.
        rain: amount, 0 to 1.
    """

    mesh: Mesh
    rain: float

    @staticmethod
    def of(puddles: Puddles, corners: Array) -> PuddleSurface | None:
        """Return the surface in tiles (T, 2), given by their low corners [m]."""
        at = np.arange(PARTS + 1) * (TILE / PARTS)
        spots = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
        x, z = (corners[:, None] + spots).reshape(-1, 2).T
        depth = puddles.depth(x, z)
        lifted = FLOOR_LIFTED if puddles.is_floor else LIFTED
        up = -SUNK + (SUNK + lifted) * smoothstep(*RIM, depth)
        vertices = np.stack([x, puddles.ground.height(x, z) + up, z], axis=-1)
        number = np.arange((PARTS + 1) ** 2).reshape(PARTS + 1, PARTS + 1)
        a, b, c, d = (
            part.ravel()
            for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:])
        )
        pattern = np.concatenate([np.stack([a, c, b], -1), np.stack([b, c, d], -1)])
        faces = (len(spots) * np.arange(len(corners))[:, None, None] + pattern).reshape(-1, 3)
        faces = faces[depth[faces].max(axis=1) > RIM[0]]
        if not len(faces):
            return None
        used, faces = np.unique(faces, return_inverse=True)
        still = np.zeros((len(used), 3), np.float32)
        still[:, 1] = 1.0
        mesh = Mesh(
            "puddles",
            vertices[used].astype(np.float32),
            faces.reshape(-1, 3).astype(np.uint32),
            FLOOR_MATERIAL if puddles.is_floor else MATERIAL,
            normals=still,
        )
        return PuddleSurface(mesh, puddles.rain)

    @cached_property
    def _cells(self) -> Array:
        return np.floor(self.mesh.vertices[:, [0, 2]] / RING_CELL).astype(np.int32)

    def at(self, time: float) -> Mesh:
        """Return the surface with the rings in it at a time of the film [s]."""
        x, z = self.mesh.vertices[:, [0, 2]].T.astype(float)
        slopes, raised = np.zeros((len(x), 2)), np.zeros(len(x))
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                i, j = (self._cells + np.array([di, dj], np.int32)).T
                cycle = time / RING_CYCLE + hashed(i, j, 4230)
                count = np.floor(cycle)
                age = (cycle - count) * RING_CYCLE
                # A number of its own for each drop that strikes a cell.
                turn = (count.astype(np.int32) * 7919 + i).astype(np.int32)
                is_there = (age < RING_LIFE) & (hashed(turn, j, 4231) < 0.3 + 0.9 * self.rain)
                way_x = x - RING_CELL * (i + hashed(turn, j, 4232))
                way_z = z - RING_CELL * (j + hashed(turn, j, 4233))
                away = np.hypot(way_x, way_z)
                behind = (away - RING_SPEED * age) / RING_WIDTH
                fading = 1.0 - smoothstep(0.0, 1.0, age / RING_LIFE)
                train = is_there * fading * np.exp(-(behind**2))
                phase = 2.0 * np.pi * (away - RING_SPEED * age) / RING_LENGTH
                slope = RING_SLOPE * train * np.cos(phase) / np.maximum(away, 1e-3)
                slopes += np.stack([slope * way_x, slope * way_z], axis=-1)
                height = RING_SLOPE * RING_LENGTH / (2.0 * np.pi)
                raised += height * train * np.sin(phase)
        vertices = self.mesh.vertices.copy()
        vertices[:, 1] += 0.5 * raised
        normals = np.stack([-slopes[:, 0], np.ones(len(x)), -slopes[:, 1]], axis=-1)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        return Mesh(
            *(self.mesh.name, vertices, self.mesh.faces, self.mesh.material),
            normals=normals.astype(np.float32),
        )
