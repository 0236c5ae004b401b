"""Tiles: squares of a picture, each judged by itself.

The mean over a picture loses what is small: a block of 8 by 8 pixels that is entirely wrong
adds 0.001 to the mean of a picture of 320 by 180 and 0.25 to that of its tile.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

TILE: Final = 16
"""Pixels along the side of a tile; what a side has left over goes to its last tile."""


def tile_means(values: NDArray[Any]) -> NDArray[np.float64]:
    """Return the means (rows, columns, ...) of values (H, W, ...) over tiles."""
    starts = [_starts(length) for length in values.shape[:2]]
    sums = values.astype(np.float64)
    for axis, begin in enumerate(starts):
        sums = np.add.reduceat(sums, begin, axis=axis)
    tall, wide = (
        np.diff([*begin, length]) for begin, length in zip(starts, values.shape, strict=False)
    )
    areas = np.multiply.outer(tall, wide).astype(np.float64)
    return np.asarray(sums / areas.reshape(areas.shape + (1,) * (values.ndim - 2)))


def tile_box(row: int, column: int, shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return left, top, width and height of a tile of a picture (H, W, ...) [pixels]."""
    top, left = row * TILE, column * TILE
    rows, columns = (len(_starts(length)) for length in shape[:2])
    height = shape[0] - top if row == rows - 1 else TILE
    width = shape[1] - left if column == columns - 1 else TILE
    return left, top, width, height


def _starts(length: int) -> list[int]:
    return [TILE * k for k in range(max(length // TILE, 1))]
