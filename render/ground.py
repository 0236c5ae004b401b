"""Ground: what is seen of soil, sand, grass, snow or rock at a point.

Two layers of one pattern, the second larger, turned and in the second colour, are mixed
by slow patches, so that no tile is seen again beside itself; where the surface is steep,
rock lies bare.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.color import linear
from render.laying import Laid, laid, ragged_wave, turned
from render.packed import LEVELS, Sample, Texels, patch_texels, read, texels
from render.rough import PIXEL
from render.textures import TILE
from render.words import Material

WARMTH = (0.13, 0.0, -0.16)
"""How much a texel's warmth adds to red, green and blue."""

SECOND, BARE = (1.37, 37.0), (1.13, 11.0)
"""How much larger the second layer and the rock are than the first, and how far turned [deg]."""

PATCHES = (9.0, 19.0)
"""Tiles that the map of patches spans, and how far it is turned [deg]."""

SOFT_DEG = 9.0
"""The border of the bare rock is spread over this much slope to either side."""

BRIGHTEST = 0.9
"""Above this a surface would light itself through its many reflections."""


TINTED = "face_tinted"
"""Mesh attribute: 1 on faces that are shown in the colour of a warning, else 0."""

WARNING, TINT = (0.85, 0.12, 0.06), 0.55
"""The colour of a warning, sRGB, and its share of a tinted surface."""


class Ground:
    """What is seen of a ground: a `render.rough.Look`."""

    def __init__(self, words: Material, warned: bool = False) -> None:
        self.words, self.warned = words, warned
        # Not a constant of the kernel: another lens must not compile it again.
        self.values: dict[str, Any] = {PIXEL: dr.opaque(mi.Float, 1e-3)}
        self._first = _Source(texels(words.texture)) if words.texture != "none" else None
        self._patches = _Source(patch_texels()) if words.color2 is not None else None
        self._bare = _Source(texels("rock")) if words.steep_color is not None else None

    def __call__(self, si: Any) -> tuple[Any, Any]:
        """Return colour and normal at points that were hit."""
        color, normal = self._pattern(si)
        if self.warned:
            share = TINT * si.shape.eval_attribute_1(TINTED, si)
            color = dr.lerp(color, mi.Color3f(*_linear(WARNING)), share)
        return dr.clip(color, 0.003, BRIGHTEST), normal

    def _pattern(self, si: Any) -> tuple[Any, Any]:
        words, n = self.words, si.sh_frame.n
        if self._first is None:
            return mi.Color3f(*_linear(words.color)), n
        ragged = ragged_wave(si.p)
        on = laid(si.p, si.n, ragged)
        level = self._level(si)
        first = self._first.layer(on, words.texture_scale, 0.0, level)
        color, slopes = _colored(words.color, first), (first.slope_u, first.slope_v)
        if self._patches is not None and words.color2 is not None:
            second = self._first.layer(on, words.texture_scale * SECOND[0], SECOND[1], level)
            patch = self._patches.layer(on, words.texture_scale * PATCHES[0], PATCHES[1], None)
            color = dr.lerp(color, _colored(words.color2, second), patch.shade)
            slopes = _mixed(slopes, second, patch.shade)
        if self._bare is not None and words.steep_color is not None:
            bare = self._bare.layer(on, words.texture_scale * BARE[0], BARE[1], level)
            share = _steepness(n, words.steep_deg, ragged + 1.5 * (1.0 - first.shade))
            color = dr.lerp(color, _colored(words.steep_color, bare), share)
            slopes = _mixed(slopes, bare, share)
        return color, _bent(n, on.gradient(*slopes), words.bump)

    def _level(self, si: Any) -> Any:
        """Return the level whose texels are about as large as a pixel where it hits."""
        texel = self.words.texture_scale / TILE
        seen = si.t * self.values[PIXEL] / texel
        # A pixel on ground seen at a flat angle is long, but not as wide as it is long.
        seen = seen * dr.rsqrt(dr.sqrt(dr.maximum(dr.abs(si.wi.z), 0.02)))
        return mi.UInt32(dr.clip(dr.log2(dr.maximum(seen, 1.0)), 0.0, LEVELS - 1.0))


class _Source:
    """A tile in Dr.Jit."""

    def __init__(self, of: Texels) -> None:
        self.of = of
        self.words = _on_device(of, mi.variant())

    def layer(self, on: Laid, size: float, turn_deg: float, level: Any) -> Sample:
        """Return the tile laid at `size` metres, turned; its slopes are those of the surface."""
        u, v = turned(on.u / size, on.v / size, turn_deg)
        found = read(self.words, self.of, u, v, level)
        slope_u, slope_v = turned(found.slope_u, found.slope_v, -turn_deg)
        return Sample(found.shade, found.warmth, slope_u, slope_v)


@lru_cache(maxsize=16)
def _on_device(of: Texels, variant: str) -> Any:
    """Return the words of a tile as an array of a variant; all surfaces share it."""
    del variant
    return mi.UInt32(of.words)


def _colored(color: tuple[float, float, float], sample: Sample) -> Any:
    parts = [
        dr.fma(sample.warmth, warm * c, c) * sample.shade
        for c, warm in zip(_linear(color), WARMTH, strict=True)
    ]
    return mi.Color3f(*parts)


def _linear(color: tuple[float, float, float]) -> list[float]:
    return [float(c) for c in linear(color)]


def _mixed(slopes: tuple[Any, Any], other: Sample, share: Any) -> tuple[Any, Any]:
    return dr.lerp(slopes[0], other.slope_u, share), dr.lerp(slopes[1], other.slope_v, share)


def _steepness(n: Any, steep_deg: float, ragged: Any) -> Any:
    """Return the share of bare rock where the normal is `n`."""
    low, high = (
        float(np.cos(np.radians(np.clip(steep_deg + side, 0.0, 90.0))))
        for side in (SOFT_DEG, -SOFT_DEG)
    )
    slope = (high - dr.abs(n.y)) * (1.0 / (high - low)) + 0.25 * ragged
    t = dr.clip(slope, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _bent(n: Any, gradient: Any, bump: float) -> Any:
    along = gradient - n * dr.dot(n, gradient)
    return mi.Normal3f(n - bump * along)
