"""Prints: what was pressed into the ground, as a raster of blocks.

Only blocks that hold a print are kept. A texel says the number of the print that made it,
how dark it is and how steep along X and Z, so that one array serves a whole film: a frame
shows those up to the number of prints that have been made by then.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

BLOCK = 32
"""Texels between the borders of a block; it has one row and one column more, its neighbour's."""

MOST = (1 << 13) - 1
"""The highest number of a print."""

STEEPEST = 1.5
"""The greatest slope that a texel can hold."""


@dataclass(frozen=True, eq=False)
class Prints:
    """A raster of prints, seen from above.

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
        """All of it."""
        head = repr((self.corner, self.spacing, self.blocks.shape)).encode()
        return head + self.blocks.tobytes() + self.texels.tobytes()


def packed(
    number: NDArray[np.uint32], dark: NDArray[np.floating], slopes: NDArray[np.floating]
) -> NDArray[np.uint32]:
    """Return texels.

    Args:
        number: of the print, from 1; 0 for none.
        dark: 0 to 1.
        slopes: (2, ...) along X and Z.
    """
    parts = np.rint((slopes / STEEPEST).clip(-1, 1) * 63 + 64).astype(np.uint32)
    shade = np.rint(dark.clip(0, 1) * 31).astype(np.uint32)
    return np.asarray(number | shade << 13 | parts[0] << 18 | parts[1] << 25, np.uint32)
