"""Limits: how far a frame may lie from its golden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from render.comparison.flip_metric import flip
from render.comparison.image_statistics import seed_spread, tile_deviations, tile_means

MARGIN: Final = 1.25
"""Limits lie this far above the most that other seeds have shown."""

_LEAST_MEAN, _LEAST_TILE = 0.002, 0.01

# Of few seeds some variances are too small: in pictures of other noise alone up to 5.1 was seen.
_LEAST_Z = 8.0


class Limits(BaseModel):
    """How far a frame may lie from its golden; the one part of a golden that is meant for editing.

    The defaults suit frames of which nothing is known; calibrating says what they really show.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    mean: float = Field(0.03, gt=0, le=1, description="FLIP over a picture.")
    tile: float = Field(0.15, gt=0, le=1, description="FLIP over its worst tile.")
    z: float = Field(8.0, gt=0, le=1000, description="Deviations of the mean of its worst tile.")


@dataclass(frozen=True, slots=True)
class Seen:
    """The most that pictures showed which differ in noise alone.

    Attributes:
        count: of pictures of each frame.
        mean: FLIP over a picture.
        tile: FLIP over a tile.
        z: deviations of a tile, of each picture from all others.
    """

    count: int
    mean: float
    tile: float
    z: float

    def limits(self) -> Limits:
        """Return the limits that follow."""
        return Limits(
            mean=round(min(max(self.mean * MARGIN, _LEAST_MEAN), 1.0), 4),
            tile=round(min(max(self.tile * MARGIN, _LEAST_TILE), 1.0), 4),
            z=round(max(self.z * MARGIN, _LEAST_Z), 2),
        )


def seen(frames: Sequence[Sequence[NDArray[np.uint8]]]) -> Seen:
    """Compare the pictures of each frame, made with different seeds, with one another.

    Args:
        frames: of each frame its pictures, three at least.
    """
    means, tiles, zs = [], [], []
    for pictures in frames:
        for one, two in combinations(pictures, 2):
            errors = flip(one, two)
            means.append(float(errors.mean()))
            tiles.append(float(tile_means(errors).max()))
        for k, picture in enumerate(pictures):
            others = seed_spread([*pictures[:k], *pictures[k + 1 :]])
            zs.append(float(tile_deviations(others, picture).max()))
    return Seen(len(frames[0]), max(means), max(tiles), max(zs))
