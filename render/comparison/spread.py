"""Spread: how far pictures of one scene differ that have other noise alone.

Where the same numbers cannot be expected (another variant of the renderer, another class of
processor), a picture is judged by the means of its tiles: each has a distribution over the
seeds of the sampler, of which K pictures tell mean and variance.

Source: G. K. Smyth, Linear Models and Empirical Bayes Methods for Assessing Differential
    Expression in Microarray Experiments, Stat. Appl. Genet. Mol. Biol. 3(1), 2004: variances
    of few samples are drawn towards that of all, or the smallest of many is far too small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from render.comparison.tiles import tile_means

_PRIOR: Final = 4.0
"""Degrees of freedom that the variance of all tiles counts beside a tile's own."""

_FLOOR: Final = 0.15
"""Standard deviation that is granted to every tile for what rounds otherwise [of 255]."""


@dataclass(frozen=True, eq=False)
class Spread:
    """What K pictures of other seeds have told.

    Attributes:
        count: K.
        means: (rows, columns, 3) of the tiles [of 255].
        variances: (rows, columns, 3) of the tiles of a single picture.
    """

    count: int
    means: NDArray[np.float64]
    variances: NDArray[np.float64]


def spread_of(pictures: Sequence[NDArray[np.uint8]]) -> Spread:
    """Return the spread of two or more pictures (H, W, 3)."""
    tiles = np.stack([tile_means(picture) for picture in pictures])
    return Spread(len(tiles), tiles.mean(axis=0), tiles.var(axis=0, ddof=1))


def distances(spread: Spread, picture: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return z (rows, columns): by how many deviations each tile's worst channel is off.

    Raises:
        ValueError: the picture is of another size.
    """
    tiles = tile_means(picture)
    if tiles.shape != spread.means.shape:
        raise ValueError(f"{tiles.shape[:2]} tiles where {spread.means.shape[:2]} belong")
    own = spread.count - 1.0
    pooled = np.median(spread.variances, axis=(0, 1))
    variance = (own * spread.variances + _PRIOR * pooled) / (own + _PRIOR)
    # The mean of K pictures is uncertain too.
    deviation = np.sqrt(variance * (1.0 + 1.0 / spread.count) + _FLOOR**2)
    return np.asarray((np.abs(tiles - spread.means) / deviation).max(axis=-1))
