"""Rooms behind panes: colours of what is seen by day through the windows of a house."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.production.edging.house_front import Front, covered
from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array
from render.shot import Mesh

CELL = 0.1
"""Breadth of cells of panes, at most [m]."""

ROOMS = (
    (0.105, 0.078, 0.050),
    (0.060, 0.072, 0.080),
    (0.080, 0.086, 0.062),
    (0.120, 0.100, 0.076),
    (0.085, 0.056, 0.046),
)
"""Linear colours of the walls of rooms as they are seen from a street by day."""


def add_rooms(mesh: Mesh, fronts: Sequence[Front], seed: int) -> Mesh:
    """Return panes, in cells, with the rooms behind them.

    Args:
        mesh: of boxes, four vertices to a side.
        fronts: of the houses that they are part of.
        seed: of the scene.
    """
    return covered(mesh, fronts, CELL, lambda f, p: _rooms(f, p, seed))


def _rooms(front: Front, local: Array, seed: int) -> Array:
    """Return colours and shares (N, 4) of the rooms behind panes.

    From below one sees the ceiling of an upper room, which the light from the street brightens,
    and what hangs from it; of a room at the street its furniture.
    """
    color = np.zeros((len(local), 4))
    for middle, low, wide, tall in front.panes:
        u, v = (local[:, 0] - middle) / wide, (local[:, 1] - low) / tall
        own = np.flatnonzero((np.abs(u) < 0.53) & (v > -0.03) & (v < 1.03))
        if not len(own):
            continue
        u, v = u[own], v[own]
        window = np.rint(100 * np.array([middle, low])).astype(int) & 65535
        rng = np.random.default_rng([seed, 467, *front.key, *window])
        wall = np.array(ROOMS[int(rng.integers(len(ROOMS)))])
        side = rng.choice((-1.0, 1.0))
        lit = 0.75 + 0.5 * side * u
        if low > 3.0:
            lit = lit * (0.45 + 1.15 * v)
            ceiling = smoothstep(0.0, 0.1, v - rng.uniform(0.45, 0.7))
            seen = wall + ceiling[:, None] * (np.array([0.21, 0.20, 0.18]) - wall)
        else:
            seen = np.tile(wall, (len(u), 1))
            top = rng.uniform(0.3, 0.6)
            at, half = rng.uniform(-0.3, 0.3), rng.uniform(0.12, 0.3)
            is_shelf = (np.abs(u - at) < half) & (v < top)
            seen[is_shelf] *= np.where(
                np.sin(23.0 * u + 31.0 * np.floor(6.0 * v)) > 0.2, 1.7, 0.45
            )[is_shelf, None]
        if rng.uniform() < 0.5:
            far = np.hypot((u - side * 0.18) / 0.16, (v - 0.72) / 0.1 * min(tall / 1.5, 1.0))
            seen = seen + (0.30 * np.array([1.0, 0.86, 0.62]) - seen) * (far < 1.0)[:, None]
        color[own, :3], color[own, 3] = lit[:, None] * seen, 1.0
    return color
