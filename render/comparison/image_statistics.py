"""Image statistics: PSNR, the means of tiles, and their deviation from frames of other seeds.

The mean over an image hides small errors: a wrong block of 8 by 8 pixels adds 0.001 to the mean
of an image of 320 by 180, and 0.25 to that of its tile.

Where equal numbers cannot be expected (another variant of the renderer, another class of
processor), a frame is judged by the means of its tiles: each is distributed over the seeds of
the sampler, and K frames estimate its mean and variance.

Source: G. K. Smyth, Linear Models and Empirical Bayes Methods for Assessing Differential
    Expression in Microarray Experiments, Stat. Appl. Genet. Mol. Biol. 3(1), 2004: variances
    of few samples are drawn towards the pooled one, or the smallest of many is far too small.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

TILE: Final = 16
"""Side of a tile [pixels]; the last tile of a row or column takes the remainder."""

_PRIOR_FREEDOM: Final = 4.0
"""Degrees of freedom of the pooled variance in the variance of a tile."""

_ROUNDING_DEVIATION: Final = 0.15
"""Standard deviation granted to every tile for rounding [of 255]."""


def psnr(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> float:
    """Return the PSNR of two 8-bit images of one size [dB], infinite where they are equal."""
    difference = reference.astype(np.float64) - test.astype(np.float64)
    error = float(np.mean(difference**2))
    return 10.0 * math.log10(255.0**2 / error) if error else math.inf


def tile_means(values: NDArray[Any]) -> NDArray[np.float64]:
    """Return the means (rows, columns, ...) of values (H, W, ...) over tiles."""
    starts = [_tile_starts(length) for length in values.shape[:2]]
    sums = values.astype(np.float64)
    for axis, start in enumerate(starts):
        sums = np.add.reduceat(sums, start, axis=axis)
    tall, wide = (
        np.diff([*start, length]) for start, length in zip(starts, values.shape, strict=False)
    )
    areas = np.multiply.outer(tall, wide).astype(np.float64)
    return np.asarray(sums / areas.reshape(areas.shape + (1,) * (values.ndim - 2)))


def tile_box(row: int, column: int, shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return left, top, width and height of a tile of an image (H, W, ...) [pixels]."""
    top, left = row * TILE, column * TILE
    rows, columns = (len(_tile_starts(length)) for length in shape[:2])
    height = shape[0] - top if row == rows - 1 else TILE
    width = shape[1] - left if column == columns - 1 else TILE
    return left, top, width, height


def _tile_starts(length: int) -> list[int]:
    return [TILE * k for k in range(max(length // TILE, 1))]


@dataclass(frozen=True, eq=False)
class SeedSpread:
    """Distribution of the tiles of a frame over the seeds of the sampler.

    Attributes:
        count: K, number of frames.
        means: (rows, columns, 3) of the tiles [of 255].
        variances: (rows, columns, 3) of the tiles of a single frame.
    """

    count: int
    means: NDArray[np.float64]
    variances: NDArray[np.float64]


def seed_spread(frames: Sequence[NDArray[np.uint8]]) -> SeedSpread:
    """Return the distribution of two or more frames (H, W, 3) of different seeds."""
    tiles = np.stack([tile_means(frame) for frame in frames])
    return SeedSpread(len(tiles), tiles.mean(axis=0), tiles.var(axis=0, ddof=1))


def tile_deviations(spread: SeedSpread, frame: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return z (rows, columns): deviation of each tile's worst channel in standard deviations.

    Raises:
        ValueError: the frame differs in size.
    """
    tiles = tile_means(frame)
    if tiles.shape != spread.means.shape:
        raise ValueError(f"{tiles.shape[:2]} tiles, expected {spread.means.shape[:2]}")
    own = spread.count - 1.0
    pooled = np.median(spread.variances, axis=(0, 1))
    variance = (own * spread.variances + _PRIOR_FREEDOM * pooled) / (own + _PRIOR_FREEDOM)
    # The mean of K frames is uncertain too.
    deviation = np.sqrt(variance * (1.0 + 1.0 / spread.count) + _ROUNDING_DEVIATION**2)
    return np.asarray((np.abs(tiles - spread.means) / deviation).max(axis=-1))
