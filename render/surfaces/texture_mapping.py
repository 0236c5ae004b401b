"""Texture mapping: packed mipmaps of patterns, and how they are projected on a surface.

A texel holds shade, warmth and the slopes of the relief along both axes, 8 bits each, so that
one read fetches all that a point needs. The mip levels follow the tile in the same array: a far
surface reads few texels, which stay in the cache and do not sparkle.

On ground, a pattern is projected along the axis of the world that the surface faces, so that no
wall has streaks. Where two projections meet, the border is ragged, which hides it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.image_resizing import half_size
from render.textures import TILE, Plane, creases, lumps, patches, tile
from render.textures.layers import DETAIL, DETAIL_LAYER

LEVELS = 10
"""Mip levels of a tile, each half as wide as the one before."""

SLOPE_SAMPLES = 1 << 16
"""Slopes that are kept of each level, enough for a mean."""

MAX_SHADE = 2.0
"""The brightest shade that a texel can hold."""

DETAIL_LOST, DETAIL_FADING = 5.0, 3.0
"""Mip level of a small copy of a pattern from which on it is not shown, and levels over which it
fades: farther away the pattern itself is finer than pixels."""

BORDER_WANDER = 0.10
"""How far the border between two projections wanders, as a fraction of a normal's length."""

WAVE_SHOWN = 0.1
"""Width of a pixel up to which the ragged wave is shown in full [m]; at twice that it is gone."""

PIXEL_WIDTH = "pixel"
"""Name of the surface parameter that holds the width of a pixel at a distance of 1 m [m]."""


def set_pixel_width(values: Any, fov_deg: float, height: int) -> None:
    """Set the width of a pixel in all surfaces of a scene.

    Args:
        values: the scene's parameters.
        fov_deg: vertical field of view [degrees].
        height: of the frame [pixels].
    """
    width = 2.0 * math.tan(math.radians(fov_deg) / 2.0) / height
    for name in values.keys():
        if name.endswith(f".{PIXEL_WIDTH}"):
            values[name] = dr.opaque(type(values[name]), width)


@dataclass(frozen=True, eq=False)
class Mipmap:
    """A tile and its mip levels, packed.

    Attributes:
        texels: row by row, level after level.
        width: of the tile [pixels].
        max_slope: the greatest slope that a texel can hold.
        squared_slopes: (LEVELS, n) of some texels of each level.
    """

    texels: NDArray[np.uint32]
    width: int
    max_slope: float
    squared_slopes: NDArray[np.float32]

    def relief_darkening(self, bump: float) -> NDArray[np.float32]:
        """Return the brightness of each level relative to the level it replaces, (LEVELS,).

        Bent normals darken ground. Where the relief is too fine to be resolved the darkening
        must remain, or ground would be brighter far away than near.
        """
        upright = (1.0 / np.sqrt(1.0 + bump**2 * self.squared_slopes)).mean(axis=1)
        return np.asarray(upright[0] / upright, np.float32)


@dataclass(frozen=True, eq=False)
class Sample:
    """A pattern at the points of a kernel: `mi.Float` each.

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

    def under(self, fine: Sample) -> Sample:
        """Return the pattern under a finer one, whose shade is relative to its mean."""
        return Sample(
            self.shade * fine.shade,
            dr.clip(self.warmth + fine.warmth, -1.0, 1.0),
            self.slope_u + fine.slope_u,
            self.slope_v + fine.slope_v,
        )


@lru_cache(maxsize=16)
def pattern_mipmap(pattern: str) -> Mipmap:
    """Return the mipmap of a pattern of `render.textures`."""
    drawn = tile(pattern)
    slope_u, slope_v = (_slope(drawn.relief, axis, drawn.size) for axis in (1, 0))
    max_slope = float(max(np.abs(slope_u).max(), np.abs(slope_v).max(), 1e-6))
    planes = [drawn.shade, drawn.warmth, slope_u, slope_v]
    ranges = [(0.0, MAX_SHADE), (-1.0, 1.0), (-max_slope, max_slope), (-max_slope, max_slope)]
    levels, squares = [], []
    for _ in range(LEVELS):
        levels.append(_packed(planes, ranges))
        slopes = planes[2] ** 2 + planes[3] ** 2
        stride = slopes.size // SLOPE_SAMPLES | 1
        squares.append(np.resize(slopes.ravel()[::stride], SLOPE_SAMPLES))
        planes = [half_size(plane) for plane in planes]
    return Mipmap(np.concatenate(levels), TILE, max_slope, np.array(squares))


@lru_cache(maxsize=1)
def patch_mipmap() -> Mipmap:
    """Return the mipmap of slow patches; its shade is 0 to 1, its slopes have a deviation of 1."""
    return _plain_mipmap(patches(), lumps())


@lru_cache(maxsize=1)
def crease_mipmap() -> Mipmap:
    """Return the mipmap of creases of cloth; its slopes along the rows have a deviation of 1."""
    relief = creases()
    return _plain_mipmap(np.ones_like(relief), relief)


def _plain_mipmap(shade: Plane, relief: Plane) -> Mipmap:
    """Return the mipmap of a shade and a relief, relative to the size of the tile."""
    planes = [shade, np.zeros_like(shade), *(_slope(relief, axis, 1.0) for axis in (1, 0))]
    max_slope = float(max(np.abs(slope).max() for slope in planes[2:]))
    ranges = [(0.0, MAX_SHADE), (-1.0, 1.0), *[(-max_slope, max_slope)] * 2]
    levels = []
    for _ in range(LEVELS):
        levels.append(_packed(planes, ranges))
        planes = [half_size(part) for part in planes]
    squares = np.zeros((LEVELS, 1), np.float32)
    return Mipmap(np.concatenate(levels), len(shade), max_slope, squares)


def share_mipmap(shares: NDArray[np.uint8]) -> Mipmap:
    """Return the mipmap of a square of shares, 255 for all; its shade is the share."""
    plane = shares.astype(np.float32) / np.float32(255)
    none = (0.0, 1.0)
    levels = []
    for _ in range(LEVELS):
        levels.append(
            _packed([plane, *[np.zeros_like(plane)] * 3], [(0.0, MAX_SHADE), *[none] * 3])
        )
        plane = half_size(plane)
    return Mipmap(np.concatenate(levels), len(shares), 1.0, np.zeros((LEVELS, 1), np.float32))


def _slope(relief: Plane, axis: int, size: float) -> Plane:
    difference = np.roll(relief, -1, axis) - np.roll(relief, 1, axis)
    return np.asarray(difference * (0.5 * len(relief) / size), np.float32)


def _packed(planes: list[Plane], ranges: list[tuple[float, float]]) -> NDArray[np.uint32]:
    texels = np.zeros(planes[0].shape, np.uint32)
    for k, (plane, (low, high)) in enumerate(zip(planes, ranges, strict=True)):
        part = np.rint((plane - low) * (255.0 / (high - low))).clip(0, 255)
        texels |= part.astype(np.uint32) << np.uint32(8 * k)
    return texels.ravel()


def lookup(texels: Any, mipmap: Mipmap, u: Any, v: Any, level: Any) -> Sample:
    """Return a pattern at points of a kernel, bilinear within one level.

    Args:
        texels: `mipmap.texels` as an array of Dr.Jit.
        mipmap: that they belong to.
        u: `mi.Float`, along the rows; the tile spans 0 to 1 and repeats.
        v: along the columns.
        level: `mi.UInt32`, the level to read; None for the tile itself.
    """
    width, start = _level_start(mipmap.width, level)
    x, y = u * mi.Float(width) - 0.5, v * mi.Float(width) - 0.5
    floor_x, floor_y = dr.floor(x), dr.floor(y)
    x, y = x - floor_x, y - floor_y
    mask = width - 1
    left, top = mi.UInt32(mi.Int32(floor_x)) & mask, mi.UInt32(mi.Int32(floor_y)) & mask
    right, bottom = (left + 1) & mask, (top + 1) & mask
    top, bottom = start + top * width, start + bottom * width
    a, b, c, d = (
        dr.gather(mi.UInt32, texels, row + column)
        for row, column in ((top, left), (top, right), (bottom, left), (bottom, right))
    )
    parts = []
    for k in range(4):
        p, q, r, s = (mi.Float((texel >> (8 * k)) & 255) for texel in (a, b, c, d))
        upper, lower = dr.fma(q - p, x, p), dr.fma(s - r, x, r)
        parts.append(dr.fma(lower - upper, y, upper))
    shade, warmth, slope_u, slope_v = parts
    slope_step = 2 * mipmap.max_slope / 255
    return Sample(
        shade * (MAX_SHADE / 255),
        warmth * (2 / 255) - 1,
        slope_u * slope_step - mipmap.max_slope,
        slope_v * slope_step - mipmap.max_slope,
    )


def _level_start(width: int, level: Any) -> tuple[Any, Any]:
    """Return the width of a level and the index of its first texel."""
    if level is None:
        return mi.UInt32(width), mi.UInt32(0)
    small = mi.UInt32(width) >> level
    # The levels before are a geometric series of squares with ratio 1/4.
    return small, (mi.UInt32(width * width) - small * small) * 4 // 3


def mip_level(si: Any, size: float, pixel: Any) -> Any:
    """Return the level whose texels are about as large as a pixel at a point.

    Args:
        si: `mi.SurfaceInteraction3f`.
        size: of a tile [m].
        pixel: `mi.Float`, width of a pixel at 1 m [m].
    """
    # At a grazing angle a pixel covers more ground: its area counts. A factor of 0.7 keeps the
    # texture crisp; the samples average the sparkle that is left.
    footprint = si.t * pixel * (0.7 * TILE / size) * dr.rsqrt(dr.maximum(dr.abs(si.wi.z), 0.01))
    # The samples of a pixel are spread over two levels: a border between them would be seen as a
    # ring around the camera.
    level = dr.log2(dr.maximum(footprint, 1.0)) + _spread(si.p) - 0.5
    return mi.UInt32(dr.clip(level, 0.0, LEVELS - 1.0))


def _spread(p: Any) -> Any:
    """Return a number, 0 to 1, that differs between the samples of a pixel, by their places."""
    x: Any = dr.reinterpret_array(mi.UInt32, mi.Float(p.x))
    z: Any = dr.reinterpret_array(mi.UInt32, mi.Float(p.z))
    word = (x * 0x9E3779B1) ^ (z * 0x85EBCA77)
    word ^= word >> 15
    word *= 0x2C1B3C6D
    return mi.Float(word >> 8) * 2.0**-24


@dataclass(frozen=True, eq=False)
class Projection:
    """Points of a surface, projected along an axis of the world.

    Attributes:
        u: `mi.Float`, first coordinate in the plane of projection [m].
        v: second coordinate [m].
        is_along_x: `mi.Bool`, the axis is X.
        is_along_y: the axis is Y.
    """

    u: Any
    v: Any
    is_along_x: Any
    is_along_y: Any

    def gradient(self, slope_u: Any, slope_v: Any) -> Any:
        """Return the gradient in the world, `mi.Vector3f`, of a relief with these slopes."""
        none = mi.Float(0)
        return mi.Vector3f(
            dr.select(self.is_along_x, none, slope_u),
            dr.select(self.is_along_y, none, slope_v),
            dr.select(self.is_along_x, slope_u, dr.select(self.is_along_y, slope_v, none)),
        )


def box_projection(p: Any, n: Any, ragged: Any) -> Projection:
    """Return the projection of points along the axis that they face.

    Args:
        p: `mi.Point3f` in the world [m].
        n: `mi.Normal3f`, geometric.
        ragged: `mi.Float`, -1 to 1, displaces the borders between the axes.
    """
    shift = BORDER_WANDER * ragged
    x, y, z = dr.abs(n.x) + shift, dr.abs(n.y), dr.abs(n.z) - shift
    is_along_y = (y >= x) & (y >= z)
    is_along_x = ~is_along_y & (x >= z)
    return Projection(
        dr.select(is_along_x, p.z, p.x), dr.select(is_along_y, p.z, p.y), is_along_x, is_along_y
    )


def ragged_wave(si: Any, pixel: Any) -> Any:
    """Return a number, -1 to 1, that varies over some decimetres without visible repetition.

    Args:
        si: `mi.SurfaceInteraction3f`.
        pixel: `mi.Float`, width of a pixel at 1 m [m].
    """
    p = si.p
    # Incommensurable wavelengths.
    first = dr.sin(5.1 * p.x + 1.7 * p.z + 2.3 * p.y)
    # Far away they would be a grid of dots.
    shown = dr.clip(2.0 - si.t * pixel / WAVE_SHOWN, 0.0, 1.0)
    return 0.5 * shown * (first + dr.sin(3.3 * p.z - 4.4 * p.x + 1.9 * p.y + 1.1))


def turned(u: Any, v: Any, degrees: float) -> tuple[Any, Any]:
    """Return coordinates, or slopes, rotated about the origin."""
    c, s = float(np.cos(np.radians(degrees))), float(np.sin(np.radians(degrees)))
    return c * u - s * v, s * u + c * v


@dataclass(frozen=True, eq=False)
class DeviceTexture:
    """A mipmap on the device.

    Attributes:
        mipmap: its layout.
        values: parameters of the surface, which hold the texels.
        name: of the texels among them.
    """

    mipmap: Mipmap
    values: dict[str, Any]
    name: str

    def at(self, u: Any, v: Any, turn_deg: float, level: Any) -> Sample:
        """Return the turned pattern at coordinates in tiles, with slopes along these."""
        found = lookup(self.values[self.name], self.mipmap, *turned(u, v, turn_deg), level)
        slope_u, slope_v = turned(found.slope_u, found.slope_v, -turn_deg)
        return Sample(found.shade, found.warmth, slope_u, slope_v)

    def on(self, projection: Projection, size: float, turn_deg: float, level: Any) -> Sample:
        """Return the turned pattern on a projected surface, with tiles of `size` metres."""
        return self.at(projection.u / size, projection.v / size, turn_deg, level)


def device_texture(mipmap: Mipmap, values: dict[str, Any], name: str) -> DeviceTexture:
    """Add the texels of a mipmap to the parameters of a surface and return the texture."""
    values[name] = _on_device(mipmap, str(mi.variant()))
    return DeviceTexture(mipmap, values, name)


@lru_cache(maxsize=64)
def _on_device(mipmap: Mipmap, variant: str) -> Any:
    """Return the texels of a mipmap in a variant; all surfaces share them."""
    del variant
    return mi.UInt32(mipmap.texels)


def fine_copy(
    si: Any, projection: Projection, texture: DeviceTexture, size: float, pixel: Any
) -> Sample:
    """Return a small copy of a pattern of ground, as strong as pixels show it.

    Args:
        si: `mi.SurfaceInteraction3f`.
        projection: of its points.
        texture: of a pattern that is alike at all sizes.
        size: of its tile [m].
        pixel: `mi.Float`, width of a pixel at 1 m [m].
    """
    level = mip_level(si, size * DETAIL_LAYER.scale, pixel)
    found = texture.on(projection, size * DETAIL_LAYER.scale, DETAIL_LAYER.turn_deg, level)
    shown = DETAIL * dr.clip((DETAIL_LOST - mi.Float(level)) / DETAIL_FADING, 0.0, 1.0)
    return Sample(
        1.0 + shown * (found.shade - 1.0),
        shown * found.warmth,
        shown * found.slope_u,
        shown * found.slope_v,
    )
