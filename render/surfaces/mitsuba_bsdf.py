"""Nested surfaces: patterns as Mitsuba's own textures, blends and bumps.

For the scalar variant, where a look in Python (see `bsdf_plugins`) would be called for
every single point. It shows the same patterns in the same colours, except that it lays
them by the texture coordinates of the mesh.
"""

from __future__ import annotations

from typing import Any, Literal

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render import coat
from render.color import linear
from render.config import Material
from render.plain import flat, plain
from render.shares import CREST, HOLLOW, STEEP
from render.surfaces.patterns import BARE, BRIGHTEST, PATCHES, REGULAR, SECOND, WARMTH
from render.textures import patches, tile

Plugin = dict[str, Any]

Surface = Literal["ground", "body", "bare"]
"""What a pattern is laid on; nothing is laid on what is bare."""


def nested(words: Material, surface: Surface) -> Plugin:
    """Return the BSDF of a surface with a pattern as a dictionary for `mi.load_dict`."""
    on_body = surface == "body"
    made = _pattern(words, words.texture, words.color, (1.0, 0.0))
    if words.color2 is not None:
        lie = (1.0, 0.0) if on_body or words.texture in REGULAR else SECOND
        second = _pattern(words, words.texture, words.color2, lie)
        span, turn = coat.PATCHES if on_body else PATCHES
        weight = _bitmap(patches()[..., None], words.texture_scale * span, turn)
        made = blend(weight, made, second)
    over = [
        (HOLLOW, words.hollow_color, words.texture, (1.0, 0.0)),
        (CREST, words.crest_color, words.texture, (1.0, 0.0)),
        (STEEP, words.steep_color, "rock", BARE),
    ]
    for name, color, texture, lie in over:
        if color is not None and not on_body:
            layer = _pattern(words, texture, color, lie)
            made = blend({"type": "mesh_attribute", "name": name}, made, layer)
    return _bump(words, made) if words.bump > 0 else made


def blend(weight: Plugin, below: Plugin, above: Plugin) -> Plugin:
    """Return `above` over `below` by a weight."""
    return {"type": "blendbsdf", "weight": weight, "below": below, "above": above}


def tinted(attribute: str, tint: float, below: Plugin, color: tuple[float, float, float]) -> Plugin:
    """Return a surface that is tinted where a mesh attribute says so."""
    uniform = {"type": "uniform", "value": tint}
    warned = blend(uniform, below, {"type": "diffuse", "reflectance": flat(color)})
    return blend({"type": "mesh_attribute", "name": attribute}, below, warned)


def _pattern(
    words: Material, name: str, color: tuple[float, float, float], lie: tuple[float, float]
) -> Plugin:
    larger, turn_deg = lie
    drawn = tile(name)
    tint = np.array(WARMTH, np.float32)
    albedo = linear(color) * drawn.shade[..., None] * (1 + drawn.warmth[..., None] * tint)
    shown = _bitmap(albedo.clip(0.003, BRIGHTEST), words.texture_scale * larger, turn_deg)
    return plain(words, shown)


def _bump(words: Material, surface: Plugin) -> Plugin:
    drawn = tile(words.texture)
    # The relief grows with the tile, which keeps its slopes.
    relief = drawn.relief[..., None] * (words.texture_scale / drawn.size)
    return {
        "type": "bumpmap",
        "scale": words.bump,
        "relief": _bitmap(relief, words.texture_scale, 0.0),
        "surface": surface,
    }


def _bitmap(pixels: NDArray[np.floating], size: float, turn_deg: float) -> Plugin:
    """Return a texture that repeats after `size` metres, turned about its corner."""
    T = mi.ScalarTransform3f
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(pixels, np.float32)),
        "raw": True,
        "wrap_mode": "repeat",
        "to_uv": T().rotate(turn_deg).scale([1 / size, 1 / size]),
    }
