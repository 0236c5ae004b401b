"""Ground: what is seen of soil, sand, grass, snow or rock at a point.

Two layers of one pattern, the second larger, turned and in the second colour, are mixed
by slow patches, so that no tile is seen again beside itself; where the surface is steep,
rock lies bare.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.color import linear
from render.config import Material
from render.footprints import Prints
from render.hatching import hatched
from render.laying import Laid, laid, ragged_wave, turned
from render.surfaces.bsdf_plugins import PIXEL
from render.surfaces.footprint_lookup import Pressed
from render.surfaces.texture_mapping import (
    LEVELS,
    Sample,
    Texels,
    patch_texels,
    read,
    texels,
)
from render.textures import TILE

WARMTH = (0.13, 0.0, -0.16)
"""How much a texel's warmth adds to red, green and blue."""

SECOND, BARE = (1.37, 37.0), (1.13, 11.0)
"""How much larger the second layer and the rock are than the first, and how far turned [deg]."""

PATCHES = (9.0, 19.0)
"""Tiles that the map of patches spans, and how far it is turned [deg]."""

FIELDS = (61.0, 52.0)
"""The same of larger patches."""

_CONTRAST = 0.8
"""How much patches of each size weigh."""

REGULAR = frozenset({"wood", "planks", "weave", "tiles", "checker", "scratches", "brushed"})
"""Patterns with lines, which a second, turned layer would cross; their colours share one layer."""

SOFT_DEG, SOFT = 9.0, 0.2
"""The borders of bare rock and of crests and hollows are spread over this much slope [deg] and
height [m] to either side."""

BRIGHTEST = 0.9
"""Above this a surface would light itself through its many reflections."""


class Ground:
    """What is seen of a ground: a `render.surfaces.bsdf_plugins.Look`."""

    def __init__(self, words: Material, warned: bool = False, prints: Prints | None = None) -> None:
        self.words, self.warned = words, warned
        # Not a constant of the kernel: another lens must not compile it again.
        self.values: dict[str, Any] = {PIXEL: dr.opaque(mi.Float, 1e-3)}
        self._pressed = Pressed(prints, self.values) if prints is not None else None
        self._first = self._patches = self._bare = None
        if words.texture != "none":
            tile = texels(words.texture)
            self._first = source(tile, self.values, "first")
            self.values["smoothness"] = mi.Float(tile.smoothness(words.bump))
        if words.color2 is not None:
            self._patches = source(patch_texels(), self.values, "patches")
        if words.steep_color is not None:
            self._bare = source(texels("rock"), self.values, "bare")

    def __call__(self, si: Any) -> tuple[Any, Any]:
        """Return colour and normal at points that were hit."""
        color, normal = self._pattern(si)
        if self._pressed is not None:
            dark, gradient = self._pressed.at(si.p)
            color *= 1.0 - dark
            normal = bent(dr.normalize(normal), gradient, 1.0)
        if self.warned:
            color = hatched(si, color)
        return dr.clip(color, 0.003, BRIGHTEST), normal

    def _pattern(self, si: Any) -> tuple[Any, Any]:
        words, n = self.words, si.sh_frame.n
        if self._first is None:
            return mi.Color3f(*_linear(words.color)), mi.Normal3f(n)
        ragged = ragged_wave(si.p)
        on = laid(si.p, si.n, ragged)
        level = level_of(si, words.texture_scale, self.values[PIXEL])
        first = self._first.layer(on, words.texture_scale, 0.0, level)
        color, slopes = colored(words.color, first), (first.slope_u, first.slope_v)
        if self._patches is not None and words.color2 is not None:
            second = first
            if words.texture not in REGULAR:
                second = self._first.layer(on, words.texture_scale * SECOND[0], SECOND[1], level)
            share = self._patch(si, on)
            color = dr.lerp(color, colored(words.color2, second), share)
            slopes = mixed(slopes, second, share) if second is not first else slopes
        # The pattern itself breaks the border up: the dark between clods fills first.
        uneven = 0.2 * SOFT * (ragged + 2.0 * (1.0 - first.shade))
        color = _by_height(words, color, first, si.p.y + uneven)
        if self._bare is not None and words.steep_color is not None:
            bare = self._bare.layer(on, words.texture_scale * BARE[0], BARE[1], level)
            share = _steepness(n, words.steep_deg, ragged + 1.5 * (1.0 - first.shade))
            color = dr.lerp(color, colored(words.steep_color, bare), share)
            slopes = mixed(slopes, bare, share)
        color *= dr.gather(mi.Float, self.values["smoothness"], level)
        return color, bent(n, on.gradient(*slopes), words.bump)

    def _patch(self, si: Any, on: Laid) -> Any:
        """Return the share of the second colour: patches of two sizes, which never meet again."""
        assert self._patches is not None
        share = mi.Float(0.5)
        for larger, turn_deg in (PATCHES, FIELDS):
            size = self.words.texture_scale * larger
            # The map has half as many texels as a tile.
            level = level_of(si, 2.0 * size, self.values[PIXEL])
            layer = self._patches.layer(on, size, turn_deg, level)
            share += _CONTRAST * (layer.shade - 0.5)
        return dr.clip(share, 0.0, 1.0)


def level_of(si: Any, size: float, pixel: Any) -> Any:
    """Return the level whose texels are about as large as a pixel where it hits.

    Args:
        si: `mi.SurfaceInteraction3f`.
        size: of a tile [m].
        pixel: `mi.Float`, width of a pixel at a metre [m].
    """
    # A pixel on ground seen at a flat angle is longer than wide: its area counts. Seven
    # tenths of that keep it crisp; what is left to sparkle the samples average.
    seen = si.t * pixel * (0.7 * TILE / size) * dr.rsqrt(dr.maximum(dr.abs(si.wi.z), 0.01))
    return mi.UInt32(dr.clip(dr.log2(dr.maximum(seen, 1.0)), 0.0, LEVELS - 1.0))


@dataclass(frozen=True, eq=False)
class Source:
    """A tile in Dr.Jit.

    Attributes:
        of: the tile.
        values: of the surface, among which its texels are.
        name: of the texels.
    """

    of: Texels
    values: dict[str, Any]
    name: str

    def at(self, u: Any, v: Any, turn_deg: float, level: Any) -> Sample:
        """Return the tile, turned, at coordinates in tiles; its slopes are along these."""
        found = read(self.values[self.name], self.of, *turned(u, v, turn_deg), level)
        slope_u, slope_v = turned(found.slope_u, found.slope_v, -turn_deg)
        return Sample(found.shade, found.warmth, slope_u, slope_v)

    def layer(self, on: Laid, size: float, turn_deg: float, level: Any) -> Sample:
        """Return the tile laid at `size` metres, turned; its slopes are those of the surface."""
        return self.at(on.u / size, on.v / size, turn_deg, level)


def source(of: Texels, values: dict[str, Any], name: str) -> Source:
    """Put the texels of a tile among the values of a surface and return the tile."""
    values[name] = _on_device(of, str(mi.variant()))
    return Source(of, values, name)


@lru_cache(maxsize=64)
def _on_device(of: Texels, variant: str) -> Any:
    """Return the texels of a tile in a variant; all surfaces share them."""
    del variant
    return mi.UInt32(of.words)


def colored(color: tuple[float, float, float], sample: Sample) -> Any:
    """Return a colour in sRGB under a pattern, `mi.Color3f`."""
    parts = [
        dr.fma(sample.warmth, warm * c, c) * sample.shade
        for c, warm in zip(_linear(color), WARMTH, strict=True)
    ]
    return mi.Color3f(*parts)


def _linear(color: tuple[float, float, float]) -> list[float]:
    return [float(c) for c in linear(color)]


def _by_height(words: Material, color: Any, sample: Sample, height: Any) -> Any:
    """Return the colour of ground with those of hollows and crests."""
    if words.hollow_color is not None:
        share = _step((words.hollow_height - height) * (1.0 / SOFT))
        color = dr.lerp(color, colored(words.hollow_color, sample), share)
    if words.crest_color is not None:
        share = _step((height - words.crest_height) * (1.0 / SOFT))
        color = dr.lerp(color, colored(words.crest_color, sample), share)
    return color


def _step(place: Any) -> Any:
    """Return 0 at -1 and 1 at 1, with a soft passage."""
    t = dr.clip(0.5 + 0.5 * place, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def mixed(slopes: tuple[Any, Any], other: Sample, share: Any) -> tuple[Any, Any]:
    """Return slopes with a share of those of another layer."""
    # Two reliefs that know nothing of one another would smooth each other where they mix.
    scale = dr.rsqrt(share * share + (1.0 - share) * (1.0 - share))
    u, v = (
        dr.lerp(a, b, share) for a, b in zip(slopes, (other.slope_u, other.slope_v), strict=True)
    )
    return u * scale, v * scale


def _steepness(n: Any, steep_deg: float, ragged: Any) -> Any:
    """Return the share of bare rock where the normal is `n`."""
    low, high = (
        float(np.cos(np.radians(np.clip(steep_deg + side, 0.0, 90.0))))
        for side in (SOFT_DEG, -SOFT_DEG)
    )
    slope = (high - dr.abs(n.y)) * (1.0 / (high - low)) + 0.25 * ragged
    t = dr.clip(slope, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def bent(n: Any, gradient: Any, bump: float) -> Any:
    """Return the normal of a relief whose gradient in the world is given."""
    along = gradient - n * dr.dot(n, gradient)
    return mi.Normal3f(n - bump * along)
