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

_SHARED_ROUNDING: Final = 0.03
"""Part of that which all tiles may share [of 255]."""

_LUMINANCE: Final = (0.2126, 0.7152, 0.0722)
"""Of the primaries of sRGB. Source: ITU-R BT.709."""

_DARK: Final = 1e-4
"""Added to luminances, so that black pictures can be compared."""


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


def exposure_change(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> float:
    """Return the change of the mean luminance of an 8-bit image (H, W, 3) [stops]."""
    old, new = (float(_LINEAR[image].mean(axis=(0, 1)) @ _LUMINANCE) for image in (reference, test))
    return math.log2((new + _DARK) / (old + _DARK))


def _linear_levels() -> NDArray[np.float64]:
    """Return the linear light of the 256 levels of sRGB. Source: IEC 61966-2-1."""
    level = np.arange(256) / 255.0
    return np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055) ** 2.4)


_LINEAR: Final = _linear_levels()


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
    deviation = np.sqrt(_variances(spread) + _ROUNDING_DEVIATION**2)
    return np.asarray((np.abs(_shifts(spread, frame)) / deviation).max(axis=-1))


def region_deviation(spread: SeedSpread, frame: NDArray[np.uint8]) -> float:
    """Return the largest deviation of a region, in standard deviations.

    Regions are squares of 2, 4, ... tiles a side and the whole image: noise averages out in them,
    a light that changed does not.

    Raises:
        ValueError: the frame differs in size.
    """
    shifts, variances = _shifts(spread, frame), _variances(spread)
    own = _ROUNDING_DEVIATION**2 - _SHARED_ROUNDING**2
    rows, columns = shifts.shape[:2]
    worst, side = 0.0, 2
    while side < 2 * max(rows, columns):
        starts = np.arange(0, rows, side), np.arange(0, columns, side)
        sums, spreads, count = (
            np.add.reduceat(np.add.reduceat(values, starts[0], axis=0), starts[1], axis=1)
            for values in (shifts, variances + own, np.ones_like(shifts))
        )
        deviation = np.sqrt(spreads / count**2 + _SHARED_ROUNDING**2)
        worst = max(worst, float((np.abs(sums / count) / deviation).max()))
        side *= 2
    return worst


def _shifts(spread: SeedSpread, frame: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the distances (rows, columns, 3) of the tiles of a frame from their means."""
    tiles = tile_means(frame)
    if tiles.shape != spread.means.shape:
        raise ValueError(f"{tiles.shape[:2]} tiles, expected {spread.means.shape[:2]}")
    return tiles - spread.means


def _variances(spread: SeedSpread) -> NDArray[np.float64]:
    """Return the variances (rows, columns, 3) of the distances of a frame from the means."""
    own = spread.count - 1.0
    pooled = np.median(spread.variances, axis=(0, 1))
    variance = (own * spread.variances + _PRIOR_FREEDOM * pooled) / (own + _PRIOR_FREEDOM)
    # The mean of K frames is uncertain too.
    return np.asarray(variance * (1.0 + 1.0 / spread.count))
