"""Materials as Mitsuba's BSDFs.

Ground is made of two layers of one pattern, the second larger, turned and in the
second colour, mixed by slow patches, so that no tile is seen again beside itself;
where the surface is steep, rock lies bare.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.color import linear
from render.textures import patches, tile
from render.words import Material

STEEP = "vertex_steep"
"""Mesh attribute: share of bare rock at a vertex, 0 to 1."""

TINTED = "face_tinted"
"""Mesh attribute: 1 on faces that are shown in the colour of a warning, else 0."""

WARNING, TINT = (0.85, 0.12, 0.06), 0.55
"""The colour of a warning, sRGB, and its share of a tinted surface."""

_PATCH_TILES = 9.0
"""The map of patches spans this many tiles of the pattern."""


def bsdf(words: Material, textured: bool, tinted: bool = False) -> dict[str, Any]:
    """Return the BSDF of a material as a dictionary for `mi.load_dict`.

    Args:
        words: the material, written out in full.
        textured: whether the surface has texture coordinates.
        tinted: whether it carries the attribute `TINTED`.
    """
    surface = _surface(words, textured)
    if tinted:
        warned = _blend(
            {"type": "uniform", "value": TINT}, surface, _principled(words, _flat(WARNING))
        )
        surface = _blend({"type": "mesh_attribute", "name": TINTED}, surface, warned)
    return {"type": "twosided", "bsdf": surface}


def glowing(words: Material) -> dict[str, Any]:
    """Return the emitter of a material that gives off light."""
    radiance = [float(words.glow * c) for c in linear(words.color)]
    return {"type": "area", "radiance": {"type": "rgb", "value": radiance}}


def _surface(words: Material, textured: bool) -> dict[str, Any]:
    if words.texture == "none" or not textured:
        return _principled(words, _flat(words.color))
    surface = _pattern(words, words.texture, words.color, 1.0, 0.0)
    if words.color2 is not None:
        second = _pattern(words, words.texture, words.color2, 1.37, 37.0)
        surface = _blend(_patch_map(words), surface, second)
    if words.steep_color is not None:
        rock = _pattern(words, "rock", words.steep_color, 1.13, 11.0)
        surface = _blend({"type": "mesh_attribute", "name": STEEP}, surface, rock)
    if words.bump > 0:
        surface = _bump(words, surface)
    return surface


def shows_rock(words: Material) -> bool:
    """Whether meshes of this material carry the attribute `STEEP`."""
    return words.texture != "none" and words.steep_color is not None


def _principled(words: Material, color: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "principled",
        "base_color": color,
        "roughness": max(words.roughness, 0.03),
        "metallic": words.metallic,
        "specular": 0.5,
        "clearcoat": words.clearcoat,
        "clearcoat_gloss": 0.93,
    }


def _flat(color: tuple[float, float, float]) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(c) for c in linear(color)]}


def _blend(weight: dict[str, Any], below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    return {"type": "blendbsdf", "weight": weight, "below": below, "above": above}


def _pattern(
    words: Material, name: str, color: tuple[float, float, float], larger: float, turn_deg: float
) -> dict[str, Any]:
    drawn = tile(name)
    tint = np.array([0.13, 0.0, -0.16], np.float32)
    albedo = linear(color) * drawn.shade[..., None] * (1 + drawn.warmth[..., None] * tint)
    # Above 0.9 a surface would light itself through its many reflections.
    return _principled(
        words, _bitmap(albedo.clip(0.003, 0.9), words.texture_scale * larger, turn_deg)
    )


def _patch_map(words: Material) -> dict[str, Any]:
    return _bitmap(patches()[..., None], words.texture_scale * _PATCH_TILES, 19.0)


def _bump(words: Material, surface: dict[str, Any]) -> dict[str, Any]:
    drawn = tile(words.texture)
    # The relief grows with the tile, which keeps its slopes.
    relief = drawn.relief[..., None] * (words.texture_scale / drawn.size)
    return {
        "type": "bumpmap",
        "scale": words.bump,
        "relief": _bitmap(relief, words.texture_scale, 0.0),
        "surface": surface,
    }


def _bitmap(pixels: NDArray[np.floating], size: float, turn_deg: float) -> dict[str, Any]:
    """Return a texture that repeats after `size` metres, turned about its corner."""
    T = mi.ScalarTransform3f
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(pixels, np.float32)),
        "raw": True,
        "wrap_mode": "repeat",
        "to_uv": T().rotate(turn_deg).scale([1 / size, 1 / size]),
    }
