"""Packed tiles: a pattern as one array of 32-bit texels that Dr.Jit reads in a kernel.

A texel holds shade, warmth and the slopes of the relief along both axes, 8 bits each, so
that one read fetches all that a point of a surface needs. Coarser and coarser copies
follow the tile in the same array: a far surface reads few texels, which stay in the
cache and do not sparkle.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.textures import TILE, Plane, patches, tile

LEVELS = 10
"""Copies of a tile, each half as wide as the one before: far away no tile is seen to repeat."""

_SOME = 1 << 16
"""Slopes that are kept of each level: enough for a mean."""

_SHADES = 2.0
"""The brightest shade that a texel can hold."""


@dataclass(frozen=True, eq=False)
class Texels:
    """A tile and its coarser copies, packed.

    Attributes:
        words: texels, row by row, level after level.
        width: of the tile [pixels].
        steepest: the greatest slope that a texel can hold.
        squares: (LEVELS, n) squares of some slopes of each level.
    """

    words: NDArray[np.uint32]
    width: int
    steepest: float
    squares: NDArray[np.float32]

    def smoothness(self, bump: float) -> NDArray[np.float32]:
        """Return how dark each level is beside the one that it stands for, (LEVELS,).

        Bent normals make ground darker; where the bends are too fine to be seen, that must
        remain, or the ground would be brighter far away than near.
        """
        upright = (1.0 / np.sqrt(1.0 + bump**2 * self.squares)).mean(axis=1)
        return np.asarray(upright[0] / upright, np.float32)


@dataclass(frozen=True, eq=False)
class Sample:
    """What a tile is at the points of a kernel: `mi.Float` each.

    Attributes:
        shade: factor on the base colour.
        warmth: -1 to 1, from blue to red.
        slope_u: of the relief along the first axis of the tile.
        slope_v: along the second.
    """

    shade: Any
    warmth: Any
    slope_u: Any
    slope_v: Any


@lru_cache(maxsize=16)
def texels(pattern: str) -> Texels:
    """Return the packed tile of a pattern of `render.textures`."""
    drawn = tile(pattern)
    slope_u, slope_v = (_slope(drawn.relief, axis, drawn.size) for axis in (1, 0))
    steepest = float(max(np.abs(slope_u).max(), np.abs(slope_v).max(), 1e-6))
    planes = [drawn.shade, drawn.warmth, slope_u, slope_v]
    ranges = [(0.0, _SHADES), (-1.0, 1.0), (-steepest, steepest), (-steepest, steepest)]
    levels, squares = [], []
    for _ in range(LEVELS):
        levels.append(_packed(planes, ranges))
        slopes = planes[2] ** 2 + planes[3] ** 2
        squares.append(np.resize(slopes.ravel()[:: slopes.size // _SOME | 1], _SOME))
        planes = [_halved(plane) for plane in planes]
    return Texels(np.concatenate(levels), TILE, steepest, np.array(squares))


@lru_cache(maxsize=1)
def patch_texels() -> Texels:
    """Return the packed map of slow patches; its shade is 0 to 1."""
    plane, words = patches(), []
    for _ in range(LEVELS):
        flat = np.zeros_like(plane)
        words.append(_packed([plane, flat, flat, flat], [(0.0, _SHADES), *[(-1.0, 1.0)] * 3]))
        plane = _halved(plane)
    return Texels(np.concatenate(words), len(patches()), 1.0, np.zeros((LEVELS, 1), np.float32))


def _slope(relief: Plane, axis: int, size: float) -> Plane:
    across = np.roll(relief, -1, axis) - np.roll(relief, 1, axis)
    return np.asarray(across * (0.5 * len(relief) / size), np.float32)


def _packed(planes: list[Plane], ranges: list[tuple[float, float]]) -> NDArray[np.uint32]:
    words = np.zeros(planes[0].shape, np.uint32)
    for k, (plane, (low, high)) in enumerate(zip(planes, ranges, strict=True)):
        part = np.rint((plane - low) * (255.0 / (high - low))).clip(0, 255)
        words |= part.astype(np.uint32) << np.uint32(8 * k)
    return words.ravel()


def _halved(plane: Plane) -> Plane:
    pairs = plane[0::2] + plane[1::2]
    return np.asarray(0.25 * (pairs[:, 0::2] + pairs[:, 1::2]), np.float32)


def read(source: Any, of: Texels, u: Any, v: Any, level: Any) -> Sample:
    """Return a tile at points of a kernel, straight between its texels.

    Args:
        source: `of.words` as an array of Dr.Jit.
        of: the tile that they belong to.
        u: `mi.Float`, along the rows; the tile goes from 0 to 1 and starts again.
        v: across them.
        level: `mi.UInt32`, the copy that is read; None for the tile itself.
    """
    width, start = _level(of.width, level)
    x, y = u * mi.Float(width) - 0.5, v * mi.Float(width) - 0.5
    floor_x, floor_y = dr.floor(x), dr.floor(y)
    x, y = x - floor_x, y - floor_y
    mask = width - 1
    left, top = mi.UInt32(mi.Int32(floor_x)) & mask, mi.UInt32(mi.Int32(floor_y)) & mask
    right, bottom = (left + 1) & mask, (top + 1) & mask
    top, bottom = start + top * width, start + bottom * width
    a, b, c, d = (
        dr.gather(mi.UInt32, source, row + column)
        for row, column in ((top, left), (top, right), (bottom, left), (bottom, right))
    )
    parts = []
    for k in range(4):
        p, q, r, s = (mi.Float((word >> (8 * k)) & 255) for word in (a, b, c, d))
        upper, lower = dr.fma(q - p, x, p), dr.fma(s - r, x, r)
        parts.append(dr.fma(lower - upper, y, upper))
    shade, warmth, slope_u, slope_v = parts
    steep = 2 * of.steepest / 255
    return Sample(
        shade * (_SHADES / 255),
        warmth * (2 / 255) - 1,
        slope_u * steep - of.steepest,
        slope_v * steep - of.steepest,
    )


def _level(width: int, level: Any) -> tuple[Any, Any]:
    """Return the width of a level and the place of its first texel."""
    if level is None:
        return mi.UInt32(width), mi.UInt32(0)
    small = mi.UInt32(width) >> level
    # The levels before are a geometric series of squares, a quarter each time.
    return small, (mi.UInt32(width * width) - small * small) * 4 // 3
