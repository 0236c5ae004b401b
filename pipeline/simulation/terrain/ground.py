"""Ground: the surface of a scene with its forbidden zones.

A place is forbidden where the slope cannot be stepped on, and within one foot
radius downhill of such a slope, where a foot would touch the wall. The zones are
kept as a field of one truth value a cell, computed to the safe side: a cell is
forbidden if any of its points may be.

Source: Sims 1987, 8.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import SceneError
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import (  # noqa: F401 - register
    constructed_terrain,
    height_files,
    natural_terrain,
)
from pipeline.simulation.terrain.generators import GENERATORS, below
from pipeline.simulation.terrain.heightfield import HeightField, surface_of
from pipeline.spec.model_base import WORLD_LIMIT
from pipeline.spec.terrain.base import TerrainConfig

ROWS_AT_ONCE = 128
"""Rows of cells whose slopes are computed together."""


@dataclass(frozen=True, eq=False)
class Ground:
    """A surface with its forbidden zones and its material.

    Attributes:
        field: the surface.
        forbidden: (n_z, n_x) cells without footholds.
        material: name of its material.
    """

    field: HeightField
    forbidden: NDArray[np.bool_]
    material: str

    def height(self, x: Array, z: Array) -> Array:
        """Return the height of the surface [m] at world (x, z)."""
        return self.field.height(x, z)

    def normal(self, x: Array, z: Array) -> Array:
        """Return the unit normals (..., 3) of the surface at (x, z)."""
        return self.field.normal(x, z)

    def surface(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Return heights (...) [m] and unit normals (..., 3) at (x, z), found together."""
        return self.field.surface(x, z)

    def steppable(self, x: Array, z: Array) -> NDArray[np.bool_]:
        """Return where a foot may be put; outside the grid it may not."""
        forbidden = self.forbidden[self.field.cell_of(x, z)]
        return self.field.inside(x, z) & ~forbidden


def level_ground(height: float, like: Ground) -> Ground:
    """Return level ground everywhere at `height` [m], of the material of `like`."""
    field = HeightField(np.full((3, 3), height), (2.0 * WORLD_LIMIT, 2.0 * WORLD_LIMIT))
    return Ground(field, np.zeros((2, 2), dtype=bool), like.material)


def build_ground(terrain: TerrainConfig, seed: int) -> Ground:
    """Build the ground of a scene.

    The terrain draws from the scene's seed under the name "terrain".

    Raises:
        SceneError: a file of the terrain does not hold what it should.
    """
    try:
        field = GENERATORS[type(terrain)](terrain, generator(seed, "terrain"))
    except SceneError as error:
        raise below(error, "terrain") from None
    field = surface_of(field, terrain.polygons).placed(
        terrain.at, math.radians(terrain.heading_deg)
    )
    zones = forbidden_cells(field, math.radians(terrain.unsteppable_slope_deg), terrain.foot_radius)
    return Ground(field, zones, terrain.material)


def forbidden_cells(
    field: HeightField, unsteppable_slope: float, foot_radius: float
) -> NDArray[np.bool_]:
    """Return the cells (n_z, n_x) without footholds.

    Args:
        field: the surface.
        unsteppable_slope: slopes at or above this angle cannot be stepped on [rad].
        foot_radius: how far downhill of them it is still forbidden [m].
    """
    limit = math.tan(unsteppable_slope) ** 2
    zones = np.zeros(field.cells[::-1], dtype=bool)
    facets = [_SteepFacets() for _ in field.facets_of(slice(0, 1))]
    # Some rows at a time: of large ground each array takes hundreds of megabytes.
    for first in range(0, len(zones), ROWS_AT_ONCE):
        rows = slice(first, min(first + ROWS_AT_ONCE, len(zones)))
        for facet, (x, z) in zip(facets, field.facets_of(rows), strict=True):
            steep = np.flatnonzero(_sum_of_squares(x, z) >= limit)
            zones[rows].ravel()[steep] = True
            facet.add(rows.start * zones.shape[1] + steep, x.ravel()[steep], z.ravel()[steep])
    if foot_radius == 0.0 or not zones.any():
        return zones
    near = _near(field.cell, foot_radius)
    margin = int(np.abs(near).max(initial=0))
    # With a margin around it no neighbour needs to be looked for.
    wide = np.pad(zones, margin)
    # The triangles of a cell may fall to different sides.
    for facet in facets:
        cells, along_x, along_z = facet.joined()
        row, column = np.divmod(cells, zones.shape[1])
        source = (row + margin) * wide.shape[1] + column + margin
        _mark_downhill(wide, source, (along_x, along_z), field.cell, near)
    return np.ascontiguousarray(wide[margin:-margin, margin:-margin]) if margin else zones


@dataclass(slots=True)
class _SteepFacets:
    """Those of one triangle of each cell that cannot be stepped on, collected part by part."""

    _parts: list[tuple[NDArray[np.int64], Array, Array]] = field(default_factory=list)

    def add(self, cells: NDArray[np.int64], along_x: Array, along_z: Array) -> None:
        """Add cells, as places in the ravelled grid, and their rises (n,), in order."""
        self._parts.append((cells, along_x, along_z))

    def joined(self) -> tuple[NDArray[np.int64], Array, Array]:
        """Return the cells and rises (n,) of all parts."""
        cells, along_x, along_z = zip(*self._parts, strict=True)
        return np.concatenate(cells), np.concatenate(along_x), np.concatenate(along_z)


def _sum_of_squares(x: Array, z: Array) -> Array:
    squares = x * x
    squares += z * z
    return squares


def _near(cell: tuple[float, float], radius: float) -> NDArray[np.int64]:
    """Return the offsets (i, j) of cells that have points within `radius` of this one's."""
    reach = [math.ceil(radius / side) for side in cell]
    i, j = np.meshgrid(*(np.arange(-r, r + 1) for r in reach))
    gap = np.hypot(np.maximum(np.abs(i) - 1, 0) * cell[0], np.maximum(np.abs(j) - 1, 0) * cell[1])
    is_near = (gap <= radius) & ((i != 0) | (j != 0))
    return np.stack([i[is_near], j[is_near]], axis=-1)


def _mark_downhill(
    wide: NDArray[np.bool_],
    source: NDArray[np.int64],
    gradient: tuple[Array, Array],
    cell: tuple[float, float],
    near: NDArray[np.int64],
) -> None:
    """Set the cells of `wide` that are near and downhill of `source`.

    Args:
        wide: zones with a margin.
        source: steep cells, as places in the ravelled `wide`.
        gradient: rise along x and z of each of them, per metre.
        cell: length of a cell along x and z [m].
        near: (n, 2) offsets of neighbours that are near enough.
    """
    flat, columns = wide.ravel(), wide.shape[1]
    over_x, over_z = gradient[0] * cell[0], gradient[1] * cell[1]
    across = np.abs(over_x) + np.abs(over_z)
    for i, j in near.tolist():
        # Some point of that cell lies downhill of some point of this one.
        flat[source[over_x * i + over_z * j < across] + (j * columns + i)] = True
