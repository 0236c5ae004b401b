"""Footprint raster: what feet have pressed into the ground over a film, in sparse blocks.

Only blocks with footprints are stored. A texel holds the number of the footprint that made it,
its darkness, and its slopes along X and Z, so that one array serves the whole film: a frame
shows the footprints up to the number made by then.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

BLOCK = 32
"""Texels along a block, which also has the first row and column of its neighbours."""

MAX_FOOTPRINTS = (1 << 13) - 1
"""The highest number of a footprint."""

MAX_SLOPE = 1.5
"""The greatest slope that a texel can hold."""


@dataclass(frozen=True, eq=False)
class FootprintRaster:
    """All footprints of a film, seen from above.

    Attributes:
        corner: x and z of the first block's first texel [m].
        spacing: between texels [m].
        blocks: (rows, columns) number of the block there, 0 for none; rows go along Z.
        texels: (B, BLOCK + 1, BLOCK + 1) packed; block 0 is empty.
    """

    corner: tuple[float, float]
    spacing: float
    blocks: NDArray[np.uint32]
    texels: NDArray[np.uint32]

    @cached_property
    def bytes(self) -> bytes:
        """The whole raster as bytes, for a digest."""
        head = repr((self.corner, self.spacing, self.blocks.shape)).encode()
        return head + self.blocks.tobytes() + self.texels.tobytes()


def pack_texels(
    number: NDArray[np.uint32], darkness: NDArray[np.floating], slopes: NDArray[np.floating]
) -> NDArray[np.uint32]:
    """Return packed texels.

    Args:
        number: of the footprint, from 1; 0 for none.
        darkness: 0 to 1.
        slopes: (2, ...) along X and Z.
    """
    parts = np.rint((slopes / MAX_SLOPE).clip(-1, 1) * 63 + 64).astype(np.uint32)
    shade = np.rint(darkness.clip(0, 1) * 31).astype(np.uint32)
    return np.asarray(number | shade << 13 | parts[0] << 18 | parts[1] << 25, np.uint32)
