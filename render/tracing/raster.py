"""Raster: the pixels of a picture, a part at a time, and the sums of what falls on them."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]

LANES = 1 << 17
"""Most paths that are under way at once, which bounds the memory."""

TILE = 4
"""Side of the squares of pixels whose paths lie beside each other."""

Sums = tuple[Any, Any]
"""What all passes have brought, lane by lane, `mi.Color3f`: light, and the colour it fell on."""


class Raster:
    """The pixels of a picture in the order in which they are worked on, a part at a time.

    Args:
        size: width and height [pixels].

    Attributes:
        size: the same.
        parts: numbers of pixels, row by row, `mi.UInt32` each.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self.size = size
        order = _tiled(*size)
        self.parts = [mi.UInt32(p) for p in np.array_split(order, -(-len(order) // LANES))]

    def sums(self) -> list[Sums]:
        """Return sums of nothing, for each part."""
        return [
            (dr.opaque(mi.Color3f, 0.0, len(p)), dr.opaque(mi.Color3f, 0.0, len(p)))
            for p in self.parts
        ]

    def pictures(self, sums: list[Sums], count: int) -> tuple[Image, Image]:
        """Return the means, (H, W, 3), of as many samples as are in sums, which are used up."""
        first, second = (list(one) for one in zip(*sums, strict=True))
        sums.clear()
        return self._picture(first, count), self._picture(second, count)

    def _picture(self, sums: list[Any], count: int) -> Image:
        width, height = self.size
        values = dr.empty(mi.Float, 3 * width * height)
        for pixels in self.parts:
            dr.scatter(values, sums.pop(0) / dr.opaque(mi.Float, count), pixels)
        return np.array(values, np.float32).reshape(height, width, 3)


def _tiled(width: int, height: int) -> NDArray[np.uint32]:
    """Return the pixels, square after square."""
    y, x = np.mgrid[0:height, 0:width]
    across = -(-width // TILE)
    place = ((y // TILE) * across + x // TILE) * TILE**2 + (y % TILE) * TILE + x % TILE
    return np.argsort(place.ravel(), kind="stable").astype(np.uint32)
