"""Stepping stones: flat tops in rows over a pit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.heightfield import HeightField
from pipeline.spec.terrain import StonesTerrain

ON_EDGE = 1e-9
"""Of a diameter: rounding is not to decide about vertices on the rim."""


@dataclass(frozen=True, eq=False)
class Layout:
    """Where stones stand: n_z rows along z of n_x stones along x.

    Attributes:
        x: (n_z, n_x) places of their middles along x [m].
        z: (n_z, n_x) along z [m].
        tops: (n_z, n_x) heights of their tops [m].
        pit: where the pit begins and ends along x [m].
    """

    x: Array
    z: Array
    tops: Array
    pit: tuple[float, float]


def layout(words: StonesTerrain, chance: np.random.Generator) -> Layout:
    """Return the stones; one row lies along the terrain's middle."""
    pitch = words.diameter + words.gap
    n_x = max(1, round((words.length - words.gap) / pitch))
    beside = int(words.size[1] / (2.0 * pitch)) + 1
    n_z = 2 * beside + 1
    off_x, off_z, off_y = chance.uniform(-0.5, 0.5, (3, n_z, n_x))
    # At most a quarter of the gap either way, so half of a gap is left between two.
    off = 0.5 * words.jitter * words.gap
    first = words.start + words.gap + 0.5 * words.diameter
    return Layout(
        x=first + pitch * np.arange(n_x) + off * off_x,
        z=pitch * (np.arange(n_z) - beside)[:, None] + off * off_z,
        tops=words.height_variation * off_y,
        pit=(words.start, words.start + n_x * pitch + words.gap),
    )


def stones(words: StonesTerrain, chance: np.random.Generator) -> HeightField:
    """Return stepping stones; their walls take one cell."""
    stand = layout(words, chance)
    pitch = words.diameter + words.gap
    n_z, n_x = stand.x.shape
    half_x, half_z = words.size[0] / 2.0, words.size[1] / 2.0
    x = np.linspace(-half_x, half_x, words.cells[0] + 1)
    z = np.linspace(-half_z, half_z, words.cells[1] + 1)
    heights = np.zeros((len(z), len(x)))
    over = (x > stand.pit[0]) & (x < stand.pit[1])
    # A stone, moved however, keeps to its own square of a pitch: one stone a vertex to look at.
    first = words.start + words.gap + 0.5 * words.diameter
    i = np.clip(np.rint((x[over] - first) / pitch).astype(np.int64), 0, n_x - 1)
    j = np.clip(np.rint(z / pitch).astype(np.int64) + n_z // 2, 0, n_z - 1)
    which = np.ix_(j, i)
    away = (x[over] - stand.x[which]) ** 2 + (z[:, None] - stand.z[which]) ** 2
    on_top = away <= ((0.5 + ON_EDGE) * words.diameter) ** 2
    heights[:, over] = np.where(on_top, stand.tops[which], -words.depth)
    return HeightField(heights, words.size)
