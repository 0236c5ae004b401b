"""Weathering: colours of what rain, mud and age leave on the plaster of houses.

Source: J. Dorsey, H. K. Pedersen, P. Hanrahan, Flow and Changes in Appearance, 1996, for streaks
    below sills and cornices, where water leaves what it has carried.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.production.edging.house_front import Front, covered
from pipeline.production.surroundings.lattice_noise import noise, smoothstep
from pipeline.simulation.spatial import Array
from render.shot import Mesh

CELL = 0.12
"""Breadth of cells of plaster, at most [m]."""

DIRT, PALE = (0.055, 0.046, 0.034), (0.72, 0.68, 0.58)
"""Linear colours of what water leaves, and of plaster that has lost its wash."""

SPLASH, SPLASH_HEIGHT = 0.6, 0.6
"""Dirt at the foot of a wall, and the height over which it falls to 1/e [m]."""

EAVES, EAVES_HEIGHT = 0.42, 0.6
"""Dirt under the eaves, and the height over which it falls to 1/e [m]."""

DRIP, DRIP_HEIGHT, DRIP_WIDTH = 0.7, 0.8, 0.09
"""Dirt below the ends of sills, the height over which it falls to 1/e, and its breadth [m]."""

STREAKS, WORN = 0.22, 0.17
"""Dirt in streaks all over, and share of its wash that plaster loses at most in patches."""


def add_weathering(mesh: Mesh, fronts: Sequence[Front], seed: int) -> Mesh:
    """Return plaster, in cells, with what the weather has left on it.

    Args:
        mesh: of boxes, four vertices to a side.
        fronts: of the houses that it is part of.
        seed: of the scene.
    """
    return covered(mesh, fronts, CELL, lambda f, p: _weather(f, p, seed))


def _weather(front: Front, local: Array, seed: int) -> Array:
    """Return colours and shares (N, 4) of weather at points of a facade's own frame (N, 3)."""
    along, up, before = local.T
    wide, _, wall_height = front.size
    is_facade = (before > -0.3) & (np.abs(along) < 0.5 * wide - 0.02)
    # Around its corners the noise goes on along the depth of the house.
    unfolded = along + np.where(is_facade, 0.0, before)
    x, z = front.key
    key = (seed + 7919 * x + 104_729 * z) & 0xFFFFFF
    column = noise(np.column_stack([unfolded / 0.23, up / 3.1]), key)
    patch = noise(np.column_stack([unfolded / 1.7, up / 1.3]), key + 1)
    patch = patch + 0.6 * noise(np.column_stack([unfolded / 0.5, up / 0.4]), key + 2)
    uneven = 0.75 + 0.5 * column
    dirt = SPLASH * np.exp(-np.maximum(up, 0.0) / SPLASH_HEIGHT) * (0.8 + 0.5 * patch)
    # Over the eaves a gable fades again.
    dirt += EAVES * np.exp(-np.abs(up - wall_height) / EAVES_HEIGHT) * uneven
    dirt += STREAKS * np.maximum(column, 0.0)
    for middle, sill, width in front.sills:
        below = sill - up
        falls = np.where(is_facade & (below > 0.0), np.exp(-below / DRIP_HEIGHT), 0.0)
        end = np.abs(np.abs(along - middle) - 0.5 * width + 0.03)
        dirt += DRIP * falls * np.exp(-np.square(end / DRIP_WIDTH)) * uneven
        dirt += 0.3 * DRIP * falls * (np.abs(along - middle) < 0.5 * width) * uneven
    worn = WORN * smoothstep(0.15, 0.8, patch)
    dirt = np.clip(dirt, 0.0, 0.75)
    share = dirt + worn * (1.0 - dirt)
    mix = (dirt / np.maximum(share, 1e-6))[:, None]
    return np.column_stack([mix * np.array(DIRT) + (1.0 - mix) * np.array(PALE), share])
