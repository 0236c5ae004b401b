"""Sunken stones: most stones of a pit in water lie lower than those that are trodden on.

For footholds the stones of a pit stand in rows, all about as high as the banks. In the picture
those that no performer comes near have sunk by amounts of their own, in groups: some are gone, some
lie just below the water, some barely above it, tilted; so there is open water about the way across.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.ndimage import find_objects, label

from pipeline.production.shots.natural_ground import natural_pit
from pipeline.production.shots.untrodden import distance_from_treads
from pipeline.production.surroundings.lattice_noise import fractal
from pipeline.simulation.take import Take, TerrainRecord
from pipeline.spec.scene import Scene

CLEAR = 0.06
"""Distance from treads up to which a stone stands as it was [m]."""

GROUP = 1.5
"""Width of groups of stones that have sunk about as far [m]."""

GONE, LOW = 0.02, 0.4
"""Values of the noise of groups below which stones are gone, and lie about the water's surface."""

ABOUT_WATER = -0.09, 0.05
"""Heights over the water between which the tops of low stones lie [m]."""

TILT = 0.22
"""Greatest rise per metre of the top of a stone that nobody treads on."""

SAME = 1e-6
"""Height over the bed up to which ground belongs to it [m]."""


def sunken(terrain: TerrainRecord, scene: Scene, take: Take) -> TerrainRecord:
    """Return a take's terrain as it is drawn: with sunken stones, if it is a pit in water.

    Args:
        terrain: of the take.
        scene: of the film.
        take: whose performers tread on it.
    """
    author = natural_pit(terrain, scene)
    if author is None or author.water is None:
        return terrain
    shape = terrain.cells[1] + 1, terrain.cells[0] + 1
    if len(terrain.vertices) != shape[0] * shape[1]:
        return terrain
    return _sunken(terrain, take, scene.seed, author.water.level)


@lru_cache(maxsize=2)
def _sunken(terrain: TerrainRecord, take: Take, seed: int, level: float) -> TerrainRecord:
    # Kept, because the weathered pit and the land around it are kept by the terrain.
    shape = terrain.cells[1] + 1, terrain.cells[0] + 1
    grid = np.array(terrain.vertices, float).reshape(*shape, 3)
    height, places = grid[..., 1], grid[..., [0, 2]]
    lowest = float(height.min())
    number, _ = label(height > lowest + SAME)
    ends = set(np.unique(number[:, [0, -1]]).tolist())
    away = distance_from_treads(places.reshape(-1, 2), take).reshape(shape)
    rng = np.random.default_rng(seed + 700)
    for k, box in enumerate(find_objects(number), start=1):
        draw, way = rng.uniform(0.0, 1.0, 2), rng.uniform(0.0, 2.0 * np.pi)
        own = number[box] == k
        if k in ends or float(away[box][own].min()) < CLEAR:
            continue
        at = places[box]
        middle = at[own].mean(axis=0)
        value = float(fractal(middle[None] / GROUP, seed + 701, 2)[0]) + 0.3 * (draw[0] - 0.5)
        top = height[box]
        if value < GONE:
            top[own] = lowest
            continue
        rise = TILT * draw[1] * ((at - middle) @ np.array([np.cos(way), np.sin(way)]))
        if value < LOW:
            low, high = ABOUT_WATER
            down = float(top[own].mean()) - level - (low + (high - low) * draw[0])
            top[own] = np.maximum(top - down + rise, lowest + 0.02)[own]
        else:
            top[own] = np.minimum(top + rise, top + 0.05)[own]
    return replace(terrain, vertices=grid.reshape(-1, 3).astype(terrain.vertices.dtype))
