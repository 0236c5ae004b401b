"""Placement: where plants and stones stand.

Each species has lattices in the world, each with half the spacing of the one before, and one
candidate a cell, at a place that only the cell, the species and the scene's seed decide. A
candidate stands if its rank is below the density that is wanted there; the ranks of each lattice
follow those of the coarser ones. So a lower density leaves things out and moves none, whatever
the cameras do, and far from them only the coarse lattices are looked at.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.ground_surface import GroundSurface
from pipeline.production.scenery.growth import GATHERED, Growth
from pipeline.production.scenery.species import KINDS, Species
from pipeline.production.surroundings.lattice_noise import fractal, hashed, smoothstep
from pipeline.simulation.spatial import Array

FALL = 1.5
"""Power of the distance with which densities fall."""

COARSEST, FINEST = 64.0, 0.0625
"""Spacings of the coarsest and finest lattices [m]."""

LEAST_TILE = 4.0
"""Side of the smallest tiles that are looked at [m]."""

WIDE_FROM, WIDEST = 6.0, 4.0
"""Distance from which far clumps are wider, as there are fewer [m], and by how much at most."""

OVERHANG, SOFT = 0.45, 0.03
"""How far the ground at the rim of a thing may be off its slope: relative to its radius, and [m].
"""

SLUMPED = 2.2
"""The same of stones on a shore, relative to others: they lie where a bank has slumped."""

MARGIN: Mapping[str, float] = {"cover": 0.0, "solid": 0.12, "tree": 1.4}
"""Distance from performers by layer, besides its own radius [m]."""


SHADOW = 1.6
"""How far beyond the frame cover is kept for its shadows, relative to its height."""

LENS_SHARE, LENS_HEIGHT = 0.16, 0.4
"""Share of the distance to a camera's target within which no grasses and herbs of a height [m] are
seen."""


@dataclass(frozen=True)
class Wanted:
    """One species that is wanted.

    Attributes:
        name: of the species.
        density: factor on its density.
        size: factor on its size.
        on_terrain: whether it may stand on the terrain.
        on_land: whether it may stand on the land around.
        even: whether it has its density all over its patches, as an author wants it, whatever
            thrives there; on average, where it stands in tufts or clumps.
        where: on dry ground, at the edge of water, or below it.
        cover: share of the ground that its patches take, None for its species' own.
    """

    name: str
    density: float
    size: float = 1.0
    on_terrain: bool = True
    on_land: bool = True
    even: bool = False
    where: Literal["dry", "shore", "wet"] = "dry"
    cover: float | None = None


@dataclass(frozen=True, eq=False)
class Placed:
    """N things of one species.

    Attributes:
        name: of the species.
        points: (N, 3) feet [m].
        normals: (N, 3) of the ground.
        color: (N, 3) of the ground, linear.
        distances: (N,) from the nearest camera [m].
        rank: (N,) below 1; the least are left out last.
        chance: (N, 4) random numbers, 0 to 1, of shape, turn, size and tint.
        size: factor on its size.
    """

    name: str
    points: Array
    normals: Array
    color: Array
    distances: Array
    rank: Array
    chance: Array
    size: float

    def taken(self, some: NDArray[np.bool_]) -> Placed:
        """Return some of them."""
        return Placed(
            self.name,
            *(self.points[some], self.normals[some], self.color[some], self.distances[some]),
            *(self.rank[some], self.chance[some], self.size),
        )


@dataclass(frozen=True, eq=False)
class Placement:
    """Places things over the ground of one film.

    Attributes:
        ground: surface.
        view: of the film.
        clearings: of the performers, None without any.
        seed: of the scene.
        growth: where plants thrive.
        detail: factor on the distances up to which things are dense, 1 for wide frames.
    """

    ground: GroundSurface
    view: FilmView
    clearings: Clearings | None
    seed: int
    growth: Growth
    detail: float = 1.0

    def placed(self, wanted: Wanted) -> Placed:
        """Return the things of one species."""
        species = KINDS[wanted.name]
        pieces = list(self._pieces(species, wanted))
        if not pieces:
            none, empty = np.zeros((0, 3)), np.zeros(0)
            chance = np.zeros((0, 4))
            return Placed(wanted.name, none, none, none, empty, empty, chance, wanted.size)
        points, normals, color, distances, rank, chance = (
            np.concatenate([getattr(piece, key) for piece in pieces])
            for key in ("points", "normals", "color", "distances", "rank", "chance")
        )
        return Placed(wanted.name, points, normals, color, distances, rank, chance, wanted.size)

    def _pieces(self, species: Species, wanted: Wanted) -> Iterator[Placed]:
        """Yield what stands on each lattice, the coarsest first."""
        peak = _peak(species, wanted)
        spacing, before, level = COARSEST, 0.0, 0
        while spacing >= FINEST and before < peak:
            density = spacing**-2
            reach = self._reach(species, wanted, before / peak)
            tiles = self._tiles(max(LEAST_TILE, spacing), reach, species, wanted.size)
            if len(tiles):
                found = self._candidates(species, wanted, tiles, (spacing, before, level))
                if found is not None:
                    yield found
            before += density
            spacing, level = spacing / 2.0, level + 1

    def _near(self, species: Species, wanted: Wanted) -> float:
        """Return the distance up to which a species has its full density [m]; large ones show."""
        return species.near * self.detail * max(1.0, wanted.size)

    def _reach(self, species: Species, wanted: Wanted, share: float) -> float:
        """Return the distance up to which a share of the full density is wanted [m]."""
        near = self._near(species, wanted)
        reach = species.reach * min(1.0, self.detail + 0.2) * max(1.0, wanted.size)
        return min(near * share ** (-1.0 / FALL) if share > 0.0 else np.inf, reach)

    def _tiles(self, least: float, reach: float, species: Species, size: float) -> Array:
        """Return tiles (T, 3), low corners and sides [m], that come within reach of a camera."""
        low = self.view.eyes[:, [0, 2]].min(axis=0) - reach
        high = self.view.eyes[:, [0, 2]].max(axis=0) + reach
        x, z = (
            np.arange(np.floor(a / COARSEST), np.ceil(b / COARSEST) + 1) * COARSEST
            for a, b in zip(low, high, strict=True)
        )
        corner = np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2)
        tiles = np.column_stack([corner, np.full(len(corner), COARSEST)])
        kept = []
        while len(tiles):
            middle = tiles[:, :2] + 0.5 * tiles[:, 2:]
            ground = self.ground.at(*middle.T).height
            high_as = species.height * species.sizes[1] * size
            center = np.stack([middle[:, 0], ground + 0.5 * high_as, middle[:, 1]], axis=-1)
            radii = 0.75 * tiles[:, 2] + species.radius * size + 0.5 * high_as
            # The ground of a wide tile may lie higher or lower than in its middle.
            near = self.view.tile_distances(center, radii + 0.15 * tiles[:, 2])
            tiles, near = tiles[near < reach], near[near < reach]
            small = (tiles[:, 2] <= max(least, LEAST_TILE)) | (tiles[:, 2] < 0.25 * near)
            small |= tiles[:, 2] <= least
            kept.append(tiles[small])
            rest, half = tiles[~small], 0.5 * tiles[~small, 2:]
            tiles = np.concatenate(
                [
                    np.column_stack([rest[:, :2] + half * [i, j], half])
                    for i in (0, 1)
                    for j in (0, 1)
                ]
            )
        return np.concatenate(kept)

    def _candidates(
        self,
        species: Species,
        wanted: Wanted,
        tiles: Array,
        lattice: tuple[float, float, int],
    ) -> Placed | None:
        """Return what stands on one lattice: its spacing, the density of coarser ones, number."""
        spacing, before, level = lattice
        cells = []
        for side in np.unique(tiles[:, 2]):
            corner = np.rint(tiles[tiles[:, 2] == side, :2] / spacing).astype(np.int32)
            n = np.arange(round(side / spacing), dtype=np.int32)
            grid = np.stack(np.meshgrid(n, n), axis=-1).reshape(-1, 2)
            cells.append((corner[:, None] + grid[None]).reshape(-1, 2))
        i, j = np.concatenate(cells).T
        seed = (zlib.crc32(wanted.name.encode()) + 8191 * self.seed + 131 * level) & 0xFFFFFF
        random = [hashed(i, j, seed + k).astype(float) for k in range(7)]
        x, z = spacing * (i + random[0]), spacing * (j + random[1])
        share = (before + spacing**-2 * random[2]) / _peak(species, wanted)
        # Most candidates end by what is cheap to know.
        here = self._patches(species, wanted, x, z)
        some = np.flatnonzero(here > share)
        x, z, share, here = x[some], z[some], share[some], here[some]
        if wanted.where == "dry":
            if wanted.even:
                here = here * self.growth.gathered(species.habitat, np.stack([x, z], axis=-1))
            else:
                here = here * self.growth.share(species.habitat, x, z)
        thrives = np.flatnonzero(here > share)
        x, z, share, here = x[thrives], z[thrives], share[thrives], here[thrives]
        some = some[thrives]
        chance = np.stack([one[some] for one in random[3:]], axis=-1)
        ground = self.ground.at(x, z)
        points = np.stack([x, ground.height, z], axis=-1)
        distances = self.view.distances(points)
        near = self._near(species, wanted)
        here = here * np.minimum(1.0, (near / np.maximum(distances, 1e-3)) ** FALL)
        end = self._reach(species, wanted, 0.0)
        here = here * (1.0 - smoothstep(0.7 * end, end, distances))
        steep = np.hypot(ground.normals[:, 0], ground.normals[:, 2]) / ground.normals[:, 1]
        if wanted.where != "shore":
            here = here * (1.0 - smoothstep(0.7 * species.steepest, species.steepest, steep))
        likely = np.flatnonzero(here > share)
        suits = np.zeros(len(here), bool)
        suits[likely] = self._suits(species, wanted, points[likely], ground.dry[likely])
        here = here * suits
        here = here * np.where(ground.on_terrain, wanted.on_terrain, wanted.on_land)
        if species.layer == "tree":
            woods = self.ground.woods(x, z, ground.height)
            here = here * np.where(ground.on_terrain, 1.0, np.maximum(woods, 0.5))
        rank = share / np.maximum(here, 1e-12)
        kept = rank < 1.0
        if species.layer == "cover":
            kept[kept] &= self.is_seen_and_free(wanted, points[kept])
        else:
            kept[kept] &= self._is_free(species, wanted, points[kept])
        if wanted.where != "shore":
            # Stones of a shore hide its edge.
            kept[kept] &= self._lies_level(species, wanted, points[kept], ground.normals[kept])
        if not kept.any():
            return None
        return Placed(
            *(wanted.name, points, ground.normals, ground.color, distances, rank, chance),
            wanted.size,
        ).taken(kept)

    def _suits(
        self, species: Species, wanted: Wanted, points: Array, dry: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Return which places (N, 3) are as dry or wet as is wanted."""
        if wanted.where == "dry":
            return dry
        x, height, z = points.T
        depth = self.ground.depth(height)
        if wanted.where == "wet":
            return np.asarray(depth > 0.75 * species.height * wanted.size)
        near = self.ground.shore(x, z, height)
        # Plants of a shore stand in the water; stones lie along its edge, too.
        return np.asarray(near & (species.is_stone | (depth > -0.08)))

    def _patches(self, species: Species, wanted: Wanted, x: Array, z: Array) -> Array:
        """Return the share (N,) of the full density that patches leave."""
        cover = species.cover if wanted.cover is None else wanted.cover
        if cover >= 1.0 or (wanted.where == "shore" and species.is_stone):
            return np.ones_like(x)
        places = np.stack([x, z], axis=-1)
        seed = (
            zlib.crc32(b"patch " + (species.family or wanted.name).encode()) + self.seed
        ) & 0xFFFFFF
        value = fractal(places / species.patch, seed, 3)
        # The noise is about normal with a deviation of 0.45.
        low = 0.45 * np.sqrt(2.0) * _inverse_error(1.0 - 2.0 * cover)
        return np.asarray(smoothstep(low - species.edge, low + species.edge, value))

    def _lies_level(
        self, species: Species, wanted: Wanted, points: Array, normals: Array
    ) -> NDArray[np.bool_]:
        """Return under which things the ground goes on as far as they reach, without a wall."""
        level = np.ones(len(points), bool)
        if species.layer == "tree":
            return level
        radius = species.radius * wanted.size
        most = OVERHANG * radius + SOFT
        if species.is_stone and wanted.where == "shore":
            most *= SLUMPED
        for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            x, z = points[:, 0] + radius * i, points[:, 2] + radius * j
            plane = points[:, 1] - radius * (normals[:, 0] * i + normals[:, 2] * j) / normals[:, 1]
            level &= np.abs(self.ground.height(x, z) - plane) < most
        return level

    def is_seen_and_free(self, wanted: Wanted, points: Array) -> NDArray[np.bool_]:
        """Return which places (N, 3) of cover a frame shows, clear of performers."""
        species = KINDS[wanted.name]
        kept = self._is_in_frame(species, wanted, points)
        kept[kept] &= self._is_free(species, wanted, points[kept])
        return kept

    def _is_in_frame(self, species: Species, wanted: Wanted, points: Array) -> NDArray[np.bool_]:
        """Return which cover a frame shows; most of what is near, and costs most, is below it."""
        tall = species.height * species.sizes[1] * wanted.size
        middle = points + np.array([0.0, 0.5 * tall, 0.0])
        return self.view.sees(middle, np.full(len(points), SHADOW * tall))

    def _is_free(self, species: Species, wanted: Wanted, points: Array) -> NDArray[np.bool_]:
        """Return which places are clear of performers and of the line of sight."""
        free = np.ones(len(points), bool)
        radius = species.radius * wanted.size
        if self.clearings is not None:
            x, z = points[:, 0], points[:, 2]
            if species.layer == "cover":
                free &= ~self.clearings.is_covered(x, z)
            else:
                free &= self.clearings.distance(x, z) > radius + MARGIN[species.layer]
        height = species.height * wanted.size
        some = np.flatnonzero(free)
        count = len(some)
        heights, radii = np.full(count, height), np.full(count, radius)
        free[some] = ~self.view.in_the_way(
            points[some],
            heights,
            radii,
            hides=species.layer == "solid",
            grows=not species.is_stone,
        )
        if height > LENS_HEIGHT and species.layer == "cover":
            # A single stalk right before the lens is no foreground.
            some = np.flatnonzero(free)
            heights, radii = np.full(len(some), height), np.full(len(some), radius)
            free[some] = ~self.view.in_the_foreground(points[some], heights, radii, LENS_SHARE)
        return free


def _peak(species: Species, wanted: Wanted) -> float:
    """Return the greatest density of a species [1/m^2]."""
    gathers = wanted.even and wanted.where == "dry"
    mean = GATHERED.get(species.habitat, 1.0) if gathers else 1.0
    return species.density * wanted.density / mean


def _inverse_error(y: float) -> float:
    """Return about the inverse error function of y; Winitzki 2008."""
    y = float(np.clip(y, -0.999, 0.999))
    log = np.log(1.0 - y * y)
    a = 2.0 / (np.pi * 0.147) + 0.5 * log
    return float(np.sign(y) * np.sqrt(np.sqrt(a * a - log / 0.147) - a))
