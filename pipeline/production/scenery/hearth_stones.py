"""Hearth stones: the rings of sooty stones around fires."""

from __future__ import annotations

import numpy as np

from pipeline.production.scenery.expansion import size_chance
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.ground_surface import GroundSurface
from pipeline.production.scenery.hearths import Hearths
from pipeline.production.scenery.placement import Placed
from pipeline.production.scenery.species import KINDS
from pipeline.simulation.spatial import Array

RING, RING_WIDTH = 1.75, 0.16
"""Distance of the ring's stones from the middle, and by how much it varies, in the fire's radius.
"""

STONE_SIZE = 0.30, 0.48
"""Sizes of the stones, in the fire's radius."""

SOOT = 0.62
"""Brightness of the stones, which are sooty, relative to that of the ground."""

SPECIES = "stone"


def hearth_stones(hearths: Hearths, ground: GroundSurface, view: FilmView) -> Placed | None:
    """Return the rings of stones around the fires, None without any."""
    rows = [_ring(hearths, k) for k in range(len(hearths.radii))]
    if not rows:
        return None
    x, z, size, turn = np.concatenate(rows).T
    found = ground.at(x, z)
    rng = np.random.default_rng(hearths.seed + 4310)
    chance = rng.uniform(0.0, 1.0, (len(x), 4))
    chance[:, 1] = turn
    low, high = KINDS[SPECIES].sizes
    scale = float(size.min()) / low
    chance[:, 2] = size_chance(size / scale, (low, high))
    points = np.stack([x, found.height, z], axis=-1)
    color, rank = SOOT * found.color, np.zeros(len(x))
    return Placed(
        *(SPECIES, points, found.normals, color, view.distances(points), rank, chance, scale)
    )


def _ring(hearths: Hearths, number: int) -> Array:
    """Return x, z, size and turn (M, 4) of the stones of one ring."""
    rng = np.random.default_rng([hearths.seed, 4300, number])
    radius = float(hearths.radii[number])
    sizes, around = [], 0.0
    while around < 2.0 * np.pi:
        sizes.append(radius * rng.uniform(*STONE_SIZE))
        # Neighbours nearly touch.
        around += 1.75 * sizes[-1] / (RING * radius)
    size = np.array(sizes[:-1])
    angle = np.cumsum(size) - 0.5 * size
    angle = angle * (2.0 * np.pi / size.sum()) + rng.uniform(0.0, 2.0 * np.pi)
    out = radius * (RING + RING_WIDTH * rng.uniform(-1.0, 1.0, len(size)))
    x, z = hearths.places[number][:, None] + out * np.stack([np.cos(angle), np.sin(angle)])
    return np.stack([x, z, size, rng.uniform(0.0, 1.0, len(size))], axis=-1)
