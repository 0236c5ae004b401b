"""Pattern shaders: colour and normal of ground and of bodies at the points of a kernel.

On ground, two layers of one pattern, the second larger, turned and in the second colour, are
mixed by slow patches, so that no tile is seen to repeat. Bare rock shows where the surface is
steep. Forbidden faces are hatched in a warning colour.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.color import linear
from render.config import Material
from render.footprints import FootprintRaster
from render.ground_wear import GroundWear
from render.surfaces import laid_pieces
from render.surfaces.footprint_lookup import FootprintLookup
from render.surfaces.texture_mapping import (
    PIXEL_WIDTH,
    DeviceTexture,
    Projection,
    Sample,
    box_projection,
    crease_mipmap,
    device_texture,
    fine_copy,
    mip_level,
    patch_mipmap,
    pattern_mipmap,
    ragged_wave,
)
from render.surfaces.wear_lookup import WearLookup
from render.textures.layers import (
    BODY_PATCHES,
    CALM,
    DETAILED,
    LARGE_PATCHES,
    PATCH_CONTRAST,
    PATCHES,
    RIPPLED,
    RIPPLED_MOST,
    ROCK_LAYER,
    SECOND_LAYER,
    Layer,
)

Shader = Callable[[Any], tuple[Any, Any]]
"""From `mi.SurfaceInteraction3f` the colour, `mi.Color3f`, and the normal in the world."""


COVER_LAYERS = (Layer(29.0, 23.0), Layer(173.0, 61.0), Layer(911.0, 8.0))
"""Uneven tones and lumps of the cover of land; their scales are metres."""

COVER_CONTRAST, COVER_RELIEF = 0.6, 0.16
"""How uneven the tones and the slopes of the cover of land are."""

BARE, GROWN, BARE_CONTRAST = 0.75, 0.95, 0.2
"""Green relative to red up to which land is bare and from which plants cover it, and the share of
its uneven tones that is left where it is bare: sand is not blotched."""

REPEATED, FADING_LEVELS = 5.0, 3.0
"""Mip level from which a layer of cover is left out, and the levels over which it fades: a tile of
ten pixels would be seen as a grid over far slopes."""

WARMTH = (0.13, 0.0, -0.16)
"""Share of a texel's warmth added to red, green and blue."""

LINED_PATTERNS = frozenset(
    {"wood", "planks", "weave", "tiles", "checker", "slabs", "scratches", "brushed"}
)
"""Patterns with lines, which a turned second layer would cross; both colours share one layer."""

WORN = 0.3
"""How much lighter and darker a floor of pieces is in patches."""

SOFT_SLOPE_DEG, SOFT_HEIGHT = 9.0, 0.2
"""Half-width of the border of bare rock [degrees of slope], and of crests and hollows [m]."""

MIN_REFLECTANCE, MAX_REFLECTANCE = 0.003, 0.9
"""Range of colours; a brighter surface would light itself by its many reflections."""

LOST_COLOR = 0.05
"""Reflectance where a colour between vertices is lost, about that of leaves."""

WARNED = "vertex_tinted"
"""Mesh attribute: share of the faces around a vertex that are hatched, 0 to 1."""

COVER_COLOR, COVER_SHARE = "vertex_cover", "vertex_covered"
"""Mesh attributes: linear colour of what covers land, and its share, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Hatching:
    """Warning hatching of forbidden zones.

    Attributes:
        color: sRGB.
        tint: share of that colour between the lines.
        line: share that lines add.
        rim: share that the rim adds.
        spacing: distance between lines [m].
    """

    color: tuple[float, float, float] = (0.85, 0.12, 0.06)
    tint: float = 0.42
    line: float = 0.30
    rim: float = 0.35
    spacing: float = 0.24


HATCHING = Hatching()


CREASED = "weave"
"""Pattern of cloth, on which creases lie that are wider than the pattern."""

CREASE_TILE, CREASE_SLOPE = 0.8, 0.17
"""Size of a tile of creases [m], and the deviation of their slopes along its rows."""


class GroundShader:
    """Shades ground, with footprints and hatching."""

    def __init__(
        self,
        material: Material,
        is_warned: bool = False,
        footprints: FootprintRaster | None = None,
        *,
        has_cover: bool = False,
        wear: GroundWear | None = None,
    ) -> None:
        self._material, self._is_warned, self._has_cover = material, is_warned, has_cover
        # Opaque, so that another lens does not compile the kernel again.
        self.values: dict[str, Any] = {PIXEL_WIDTH: dr.opaque(mi.Float, 1e-3)}
        self._footprints = None
        if footprints is not None:
            self._footprints = FootprintLookup(footprints, self.values)
        self._first = self._patches = self._rock = self._worn = None
        if material.texture != "none":
            mipmap = pattern_mipmap(material.texture)
            self._first = device_texture(mipmap, self.values, "first")
            self.values["smoothness"] = mi.Float(mipmap.relief_darkening(material.bump))
            laid_pieces.prepare(material.texture, self.values)
        if material.color2 is not None:
            self._patches = device_texture(patch_mipmap(), self.values, "patches")
        if wear is not None and self._first is not None:
            self._worn = WearLookup(wear, self.values)
        if has_cover:
            self._uneven = device_texture(patch_mipmap(), self.values, "uneven")
        if material.steep_color is not None:
            self._rock = device_texture(pattern_mipmap("rock"), self.values, "bare")

    def __call__(self, si: Any) -> tuple[Any, Any]:
        """Return colour and normal at surface interactions."""
        color, normal = self._textured(si)
        if self._has_cover:
            color, normal = self._covered(si, color, normal)
        if self._footprints is not None:
            dark, gradient = self._footprints.at(si.p)
            color *= 1.0 - dark
            normal = bent_normal(dr.normalize(normal), gradient, 1.0)
        if self._is_warned:
            color = hatched(si, color)
        return dr.clip(color, MIN_REFLECTANCE, MAX_REFLECTANCE), normal

    def _textured(self, si: Any) -> tuple[Any, Any]:
        material, n = self._material, si.sh_frame.n
        if self._first is None:
            return mi.Color3f(*_linear(material.color)), mi.Normal3f(n)
        ragged = ragged_wave(si, self.values[PIXEL_WIDTH])
        projection = box_projection(si.p, si.n, ragged)
        size = material.texture_scale
        level = mip_level(si, size, self.values[PIXEL_WIDTH])
        first = self._first_layer(projection, level)
        fine = None
        if material.texture in DETAILED:
            fine = fine_copy(si, projection, self._first, size, self.values[PIXEL_WIDTH])
            first = first.under(fine)
        color, slopes = colored(material.color, first), (first.slope_u, first.slope_v)
        if self._patches is not None and material.color2 is not None:
            second = first
            if material.texture not in LINED_PATTERNS:
                second = self._first.on(
                    projection, size * SECOND_LAYER.scale, SECOND_LAYER.turn_deg, level
                )
                second = second if fine is None else second.under(fine)
            share = self._patch_share(si, projection, self._patches)
            color = dr.lerp(color, colored(material.color2, second), share)
            slopes = _mixed_slopes(slopes, second, share) if second is not first else slopes
            if material.texture in RIPPLED:
                strength = CALM + (1.0 - CALM) * RIPPLED_MOST * share
                slopes = slopes[0] * strength, slopes[1] * strength
            if laid_pieces.has_pieces(material.texture):
                # Worn and stained in places, across the pieces.
                color *= 1.0 + WORN * (share - 0.5)
        if self._worn is not None:
            share, soil, clods = self._worn.at(si, projection, first.shade)
            color = dr.lerp(color, patterned(soil, clods), share)
            slopes = _mixed_slopes(slopes, clods, share)
        # The pattern itself breaks up the border: the dark between clods fills first.
        uneven = 0.2 * SOFT_HEIGHT * (ragged + 2.0 * (1.0 - first.shade))
        color = _by_height(material, color, first, si.p.y + uneven)
        if self._rock is not None and material.steep_color is not None:
            rock = self._rock.on(projection, size * ROCK_LAYER.scale, ROCK_LAYER.turn_deg, level)
            share = _rock_share(n, material.steep_deg, ragged + 1.5 * (1.0 - first.shade))
            color = dr.lerp(color, colored(material.steep_color, rock), share)
            slopes = _mixed_slopes(slopes, rock, share)
        color *= dr.gather(mi.Float, self.values["smoothness"], level)
        return color, bent_normal(n, projection.gradient(*slopes), material.bump)

    def _first_layer(self, projection: Projection, level: Any) -> Sample:
        """Return the first layer of the pattern; of a floor of pieces, piece by piece."""
        material, texture = self._material, self._first
        assert texture is not None
        size = material.texture_scale
        if not laid_pieces.has_pieces(material.texture):
            return texture.on(projection, size, 0.0, level)
        u, v = projection.u / size, projection.v / size
        piece = laid_pieces.laid(material.texture, u, v, level, self.values)
        found = texture.at(piece.u, piece.v, 0.0, level)
        warmth = dr.clip(found.warmth + piece.warmth, -1.0, 1.0)
        return Sample(found.shade * piece.tone, warmth, found.slope_u, found.slope_v)

    def _covered(self, si: Any, color: Any, normal: Any) -> tuple[Any, Any]:
        """Return colour and normal of land, with its cover, which is uneven at all sizes."""
        cover = _told(mi.Color3f(si.shape.eval_attribute_3(COVER_COLOR, si)), LOST_COLOR)
        share = _told(si.shape.eval_attribute_1(COVER_SHARE, si), 1.0)
        projection = box_projection(si.p, mi.Normal3f(0, 1, 0), mi.Float(0))
        tone: Any = mi.Float(1.0)
        slopes = mi.Float(0), mi.Float(0)
        grown = _smoothstep((cover.y / dr.maximum(cover.x, 1e-3) - BARE) * (1.0 / (GROWN - BARE)))
        contrast = COVER_CONTRAST * dr.lerp(BARE_CONTRAST, 1.0, grown)
        for layer in COVER_LAYERS:
            level = mip_level(si, 2.0 * layer.scale, self.values[PIXEL_WIDTH])
            uneven = self._uneven.on(projection, layer.scale, layer.turn_deg, level)
            shown = dr.clip((REPEATED - mi.Float(level)) / FADING_LEVELS, 0.0, 1.0)
            tone *= 1.0 + shown * contrast * (uneven.shade - 0.5)
            slopes = slopes[0] + shown * uneven.slope_u, slopes[1] + shown * uneven.slope_v
        gradient = projection.gradient(*slopes)
        covered = bent_normal(si.sh_frame.n, gradient, COVER_RELIEF)
        return dr.lerp(color, cover * tone, share), dr.lerp(normal, covered, share)

    def _patch_share(self, si: Any, projection: Projection, patches: DeviceTexture) -> Any:
        """Return the share of the second colour: patches of two incommensurable sizes."""
        share = mi.Float(0.5)
        for layer in (PATCHES, LARGE_PATCHES):
            size = self._material.texture_scale * layer.scale
            # The map has half as many texels as a tile.
            level = mip_level(si, 2.0 * size, self.values[PIXEL_WIDTH])
            patch = patches.on(projection, size, layer.turn_deg, level)
            share += PATCH_CONTRAST * (patch.shade - 0.5)
        return dr.clip(share, 0.0, 1.0)


class PlainShader:
    """Shades a surface without pattern in its material's colour, or that of a texture of Mitsuba.

    A texture of one colour, which no mesh holds, would be unknown to a frozen kernel.
    """

    def __init__(self, material: Material, texture: Any = None) -> None:
        self._color, self._texture = _linear(material.color), texture
        self.values: dict[str, Any] = {}

    def __call__(self, si: Any) -> tuple[Any, Any]:
        """Return colour and normal at surface interactions."""
        if self._texture is None:
            color = dr.clip(mi.Color3f(*self._color), MIN_REFLECTANCE, MAX_REFLECTANCE)
            return color, si.sh_frame.n
        return _told(self._texture.eval(si), LOST_COLOR), si.sh_frame.n


class PaintedShader:
    """Shades a body without pattern in its material's colour and what covers it."""

    def __init__(self, material: Material) -> None:
        self._color = material.color
        # Opaque, so that another lens does not compile the kernel again.
        self.values: dict[str, Any] = {PIXEL_WIDTH: dr.opaque(mi.Float, 1e-3)}

    def __call__(self, si: Any) -> tuple[Any, Any]:
        """Return colour and normal at surface interactions."""
        cover, share = _cover_at(si)
        color = dr.lerp(mi.Color3f(*_linear(self._color)), cover, share)
        return dr.clip(color, MIN_REFLECTANCE, MAX_REFLECTANCE), si.sh_frame.n


class BodyShader:
    """Shades a body, whose pattern moves with it."""

    def __init__(self, material: Material, *, has_cover: bool = False) -> None:
        self._material, self._has_cover = material, has_cover
        # Opaque, so that another lens does not compile the kernel again.
        self.values: dict[str, Any] = {PIXEL_WIDTH: dr.opaque(mi.Float, 1e-3)}
        self._first = device_texture(pattern_mipmap(material.texture), self.values, "first")
        self._patches = self._creases = None
        if material.color2 is not None:
            self._patches = device_texture(patch_mipmap(), self.values, "patches")
        if material.texture == CREASED:
            self._creases = device_texture(crease_mipmap(), self.values, "creases")

    def __call__(self, si: Any) -> tuple[Any, Any]:
        """Return colour and normal at surface interactions."""
        material, n = self._material, si.sh_frame.n
        uv = si.uv / material.texture_scale
        level = mip_level(si, material.texture_scale, self.values[PIXEL_WIDTH])
        first = self._first.at(uv.x, uv.y, 0.0, level)
        color = colored(material.color, first)
        if self._patches is not None and material.color2 is not None:
            span, turn_deg = BODY_PATCHES.scale, BODY_PATCHES.turn_deg
            patch = self._patches.at(uv.x / span, uv.y / span, turn_deg, None)
            # One layer is enough for a body, which is smaller than a few tiles.
            color = dr.lerp(color, colored(material.color2, first), patch.shade)
        if self._has_cover:
            cover, share = _cover_at(si)
            color = dr.lerp(color, patterned(cover, first), share)
        if material.bump == 0:
            return dr.clip(color, MIN_REFLECTANCE, MAX_REFLECTANCE), n
        gradient = material.bump * _uv_gradient(si, first)
        if self._creases is not None:
            uv = si.uv / CREASE_TILE
            level = mip_level(si, CREASE_TILE, self.values[PIXEL_WIDTH])
            gradient += CREASE_SLOPE * _uv_gradient(si, self._creases.at(uv.x, uv.y, 0.0, level))
        normal = bent_normal(n, gradient, 1.0)
        return dr.clip(color, MIN_REFLECTANCE, MAX_REFLECTANCE), normal


def _cover_at(si: Any) -> tuple[Any, Any]:
    """Return the colour of what covers a surface, and its share."""
    cover = _told(mi.Color3f(si.shape.eval_attribute_3(COVER_COLOR, si)), LOST_COLOR)
    return cover, _told(si.shape.eval_attribute_1(COVER_SHARE, si), 0.0)


def _told(value: Any, otherwise: float) -> Any:
    """Return a value between vertices, or another where it is lost.

    Where in a needle of a triangle a ray has met it may be lost to rounding: then the value is not
    a number, and a guide of the denoiser that is none spoils a whole pixel.
    """
    return dr.select(dr.isfinite(value), value, otherwise)


def _uv_gradient(si: Any, sample: Sample) -> Any:
    """Return the gradient in the world of a relief that lies by texture coordinates."""
    along, across = si.dp_du, si.dp_dv
    # Texture coordinates are metres, so that both are about one metre long.
    return mi.Vector3f(
        sample.slope_u * along / dr.maximum(dr.squared_norm(along), 1e-8)
        + sample.slope_v * across / dr.maximum(dr.squared_norm(across), 1e-8)
    )


def colored(color: tuple[float, float, float], sample: Sample) -> Any:
    """Return an sRGB colour under a pattern as linear `mi.Color3f`."""
    return patterned(_linear(color), sample)


def patterned(color: Any, sample: Sample) -> Any:
    """Return three linear values under a pattern as `mi.Color3f`."""
    parts = [
        dr.fma(sample.warmth, warm * c, c) * sample.shade
        for c, warm in zip(color, WARMTH, strict=True)
    ]
    return mi.Color3f(*parts)


def _linear(color: tuple[float, float, float]) -> list[float]:
    return [float(c) for c in linear(color)]


def _by_height(material: Material, color: Any, sample: Sample, height: Any) -> Any:
    """Return the colour of ground with those of hollows and crests."""
    if material.hollow_color is not None:
        share = _centered_step((material.hollow_height - height) * (1.0 / SOFT_HEIGHT))
        color = dr.lerp(color, colored(material.hollow_color, sample), share)
    if material.crest_color is not None:
        share = _centered_step((height - material.crest_height) * (1.0 / SOFT_HEIGHT))
        color = dr.lerp(color, colored(material.crest_color, sample), share)
    return color


def _centered_step(x: Any) -> Any:
    """Return a smoothstep from 0 at -1 to 1 at 1."""
    return _smoothstep(0.5 + 0.5 * x)


def _smoothstep(t: Any) -> Any:
    t = dr.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _mixed_slopes(slopes: tuple[Any, Any], other: Sample, share: Any) -> tuple[Any, Any]:
    """Return slopes mixed with those of another layer, at constant variance."""
    # Two independent reliefs would smooth each other where they mix.
    scale = dr.rsqrt(share * share + (1.0 - share) * (1.0 - share))
    u, v = (
        dr.lerp(a, b, share) for a, b in zip(slopes, (other.slope_u, other.slope_v), strict=True)
    )
    return u * scale, v * scale


def _rock_share(n: Any, steep_deg: float, ragged: Any) -> Any:
    """Return the share of bare rock at a normal."""
    low, high = (
        float(np.cos(np.radians(np.clip(steep_deg + side, 0.0, 90.0))))
        for side in (SOFT_SLOPE_DEG, -SOFT_SLOPE_DEG)
    )
    return _smoothstep((high - dr.abs(n.y)) * (1.0 / (high - low)) + 0.25 * ragged)


def bent_normal(n: Any, gradient: Any, bump: float) -> Any:
    """Return the normal of a relief with a gradient in the world, not normalized."""
    along = gradient - n * dr.dot(n, gradient)
    return mi.Normal3f(n - bump * along)


def hatched(si: Any, color: Any) -> Any:
    """Return the colour of ground, hatched where its attribute `WARNED` says so."""
    share = si.shape.eval_attribute_1(WARNED, si)
    inside = _smoothstep((share - 0.42) * (1.0 / 0.16))
    rim = _smoothstep(1.0 - dr.abs(share - 0.5) * (1.0 / 0.16))
    across = (si.p.x + si.p.z + 0.5 * si.p.y) * (1.0 / HATCHING.spacing)
    line = _smoothstep(1.5 - 5.0 * dr.abs(across - dr.floor(across) - 0.5))
    tint = inside * (HATCHING.tint + dr.maximum(HATCHING.line * line, HATCHING.rim * rim))
    return dr.lerp(color, mi.Color3f(*(float(c) for c in linear(HATCHING.color))), tint)
