"""Weathered pit: how water has worn the banks and the stones of a pit, as the picture shows it.

A pit of stepping stones has walls of one cell, for footholds. Under water no wall stays like that:
the banks have slumped to slopes whose edge wanders, silt lies about the feet of the stones, and
their shoulders are broken. In the picture the bed is raised so; what feet stand on is left alone.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from pipeline.production.shots.natural_ground import natural_pit
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TerrainRecord
from pipeline.spec.scene import Scene

GROWN, GROWN_OF_GAP, SLOPE = 0.34, 0.5, (0.6, 1.25)
"""How far a bank has grown into the pit at most [m], the same relative to the gap between stones,
and the width of its slope [m]."""

SHOULDER, SHOULDER_OF_GAP = (0.05, 0.34), 0.5
"""Width of the broken shoulder of a stone [m], and at most relative to the gap between stones."""

SILT, SILT_WIDTH = 0.22, 0.45
"""Height of the silt about the foot of a stone, and how far it lies around it [m]."""

BED = 0.07
"""Half of the height between lows and highs of the bed [m]."""

LOWEST = 0.02
"""Depth of what is raised below the edge that it is raised to [m]."""


def weathered(terrain: TerrainRecord, scene: Scene) -> TerrainRecord:
    """Return a take's terrain as it is drawn: with a weathered pit, if it is one in water."""
    author = natural_pit(terrain, scene)
    if author is None:
        return terrain
    return _weathered(terrain, scene.seed, float(author.gap))


@lru_cache(maxsize=2)
def _weathered(terrain: TerrainRecord, seed: int, gap: float) -> TerrainRecord:
    # Kept, because the land around it is kept by the terrain.
    shape = terrain.cells[1] + 1, terrain.cells[0] + 1
    grid = np.asarray(terrain.vertices[: shape[0] * shape[1]], float).reshape(*shape, 3)
    if len(terrain.vertices) != shape[0] * shape[1]:
        return terrain
    height = grid[..., 1]
    is_bed = height < height.min() + 1e-6
    if is_bed.all() or not is_bed.any():
        return terrain
    cell = float(np.hypot(*(grid[0, 1] - grid[0, 0])[[0, 2]]))
    is_bank = _banks(~is_bed)
    places = grid[..., [0, 2]]
    lowest = float(height.min())
    bed = lowest + BED * (1.0 + fractal(places / 0.7, seed + 610, 3))
    raised = np.maximum.reduce(
        [
            bed,
            _slumped(height, is_bank, places, (cell, lowest, gap), seed),
            _broken(height, ~is_bed & ~is_bank, places, (cell, lowest, gap), seed),
        ]
    )
    vertices = grid.copy()
    vertices[..., 1] = np.where(is_bed, raised, height)
    return replace(terrain, vertices=vertices.reshape(-1, 3))


def _banks(is_high: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which vertices lie on banks: on high ground that reaches the ends along x."""
    number, _ = label(is_high)
    ends = np.unique(number[:, [0, -1]])
    return np.asarray(np.isin(number, ends[ends > 0]))


def _slumped(
    height: Array,
    is_bank: NDArray[np.bool_],
    places: Array,
    bed: tuple[float, float, float],
    seed: int,
) -> Array:
    """Return the heights of the slopes of the banks; far below the bed where there are none."""
    cell, lowest, gap = bed
    if not is_bank.any():
        return np.full(height.shape, -np.inf)
    away, edge = _nearest(is_bank, height, cell)
    broad, fine = fractal(places / 1.6, seed + 620, 3), fractal(places / 0.45, seed + 630, 3)
    grown = min(GROWN, GROWN_OF_GAP * gap) * np.clip(0.5 + 0.8 * broad, 0.0, 1.0)
    wide = SLOPE[0] + (SLOPE[1] - SLOPE[0]) * np.clip(0.5 + 0.7 * fine, 0.0, 1.0)
    down = np.clip((away - grown) / wide, 0.0, 1.0)
    # Round at the turf, flat at the foot.
    fallen = smoothstep(0.0, 1.0, down**0.8)
    rough = 0.04 * fine * smoothstep(0.0, 0.25, down)
    return np.asarray(edge - LOWEST - (edge - lowest) * fallen + rough)


def _broken(
    height: Array,
    is_stone: NDArray[np.bool_],
    places: Array,
    bed: tuple[float, float, float],
    seed: int,
) -> Array:
    """Return the heights of shoulders of stones and of the silt about them."""
    cell, lowest, gap = bed
    if not is_stone.any():
        return np.full(height.shape, -np.inf)
    away, edge = _nearest(is_stone, height, cell)
    rough = fractal(places / 0.3, seed + 640, 3)
    low, high = SHOULDER
    wide = low + (high - low) * np.clip(0.4 + 0.8 * rough, 0.0, 1.0)
    wide = np.minimum(wide, max(SHOULDER_OF_GAP * gap, cell))
    part = np.clip(away / wide, 0.0, 1.0)
    fine = fractal(places / 0.13, seed + 650, 2)
    shoulder = edge - LOWEST - (edge - lowest) * part**1.4 + 0.05 * fine * (part > 0.1)
    silt = lowest + SILT * (1.0 + 0.6 * rough) * (1.0 - smoothstep(0.0, SILT_WIDTH, away))
    return np.asarray(np.maximum(np.minimum(shoulder, edge - LOWEST), silt))


def _nearest(is_high: NDArray[np.bool_], height: Array, cell: float) -> tuple[Array, Array]:
    """Return the distance from high ground [m] and the height of its nearest vertex."""
    away, (rows, columns) = distance_transform_edt(~is_high, return_indices=True)
    return cell * away, height[rows, columns]
