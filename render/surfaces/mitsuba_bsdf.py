"""BSDFs from Mitsuba's own plugins, as dictionaries for `mi.load_dict`.

Besides plain surfaces these are patterns for the scalar variant, where a shader in Python would
be called for every single point: nested textures, blends and bumps show the same patterns in the
same colours, laid by the texture coordinates of the mesh.
"""

from __future__ import annotations

from typing import Any, Literal

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.color import linear
from render.config import Material
from render.config.material import DIFFUSE_ROUGHNESS
from render.surfaces.patterns import (
    COVER_COLOR,
    COVER_SHARE,
    HATCHING,
    LINED_PATTERNS,
    MAX_REFLECTANCE,
    MIN_REFLECTANCE,
    SOFT_HEIGHT,
    SOFT_SLOPE_DEG,
    WARMTH,
    WARNED,
)
from render.textures import patches, tile
from render.textures.layers import (
    BODY_PATCHES,
    FIRST_LAYER,
    PATCHES,
    ROCK_LAYER,
    SECOND_LAYER,
    Layer,
)

Plugin = dict[str, Any]

Surface = Literal["ground", "body", "bare"]
"""What a pattern is laid on; a bare surface has none."""

STEEP, CREST, HOLLOW = "vertex_steep", "vertex_crest", "vertex_hollow"
"""Mesh attributes: shares of bare rock, of crests and of hollows, 0 to 1."""


VERTEX_COLOR = "vertex_color"
"""Mesh attribute: linear base colour."""


def is_diffuse(material: Material) -> bool:
    """Whether a material is purely diffuse: rough, and neither metal nor coated."""
    shines = material.metallic or material.clearcoat or material.sheen or material.transmission
    shines = shines or material.subsurface
    return material.roughness >= DIFFUSE_ROUGHNESS and not shines


def opaque_bsdf(material: Material, color: Any) -> Plugin:
    """Return the BSDF of an opaque material with its colour as a texture."""
    if is_diffuse(material):
        return {"type": "diffuse", "reflectance": color}
    return {
        "type": "principled",
        "base_color": color,
        "roughness": max(material.roughness, 0.03),
        "metallic": material.metallic,
        "specular": 0.5,
        "clearcoat": material.clearcoat,
        "clearcoat_gloss": 0.93,
        "sheen": material.sheen,
        "sheen_tint": 0.6,
    }


def transmissive_bsdf(material: Material) -> Plugin:
    """Return the two-sided BSDF of a transmissive material."""
    tinted = {"int_ior": material.ior, "specular_transmittance": rgb_texture(material.color)}
    glass: Plugin = {"type": "dielectric", **tinted}
    if material.roughness > 0.03:
        glass = {"type": "roughdielectric", "alpha": material.roughness**2, **tinted}
    if material.transmission >= 1.0:
        return glass
    opaque = {"type": "twosided", "bsdf": opaque_bsdf(material, rgb_texture(material.color))}
    return _blend(material.transmission, opaque, glass)


def rgb_texture(color: tuple[float, float, float]) -> Plugin:
    """Return an sRGB colour as a texture."""
    return {"type": "rgb", "value": [float(c) for c in linear(color)]}


def vertex_colors() -> Plugin:
    """Return the colours of the vertices of a mesh as a texture."""
    return {"type": "mesh_attribute", "name": VERTEX_COLOR}


def thin_plugin(material: Material, color: Any) -> Plugin:
    """Return Mitsuba's nearest BSDF to a thin diffuse sheet, which scatters a little less evenly.

    The other variants have `bsdf_plugins.thin_bsdf`.
    """
    return {
        "type": "principledthin",
        "base_color": color,
        "roughness": 1.0,
        "spec_trans": 0.0,
        "diff_trans": 2.0 * material.translucency,
        "eta": 1.1,
    }


def patterned_bsdf(material: Material, surface: Surface) -> Plugin:
    """Return the BSDF of a surface with a pattern."""
    on_body = surface == "body"
    made = _layer(material, material.texture, material.color, FIRST_LAYER)
    if material.color2 is not None:
        shares_layer = on_body or material.texture in LINED_PATTERNS
        layout = FIRST_LAYER if shares_layer else SECOND_LAYER
        second = _layer(material, material.texture, material.color2, layout)
        map_layout = BODY_PATCHES if on_body else PATCHES
        size = material.texture_scale * map_layout.scale
        weight = _bitmap(patches()[..., None], size, map_layout.turn_deg)
        made = _blend(weight, made, second)
    overlays = [
        (HOLLOW, material.hollow_color, material.texture, FIRST_LAYER),
        (CREST, material.crest_color, material.texture, FIRST_LAYER),
        (STEEP, material.steep_color, "rock", ROCK_LAYER),
    ]
    for name, color, texture, layout in overlays:
        if color is not None and not on_body:
            layer = _layer(material, texture, color, layout)
            made = _blend({"type": "mesh_attribute", "name": name}, made, layer)
    return _bump(material, made) if material.bump > 0 else made


def warned_bsdf(below: Plugin) -> Plugin:
    """Return a surface tinted in the warning colour where its attribute `WARNED` says so."""
    tint = {"type": "uniform", "value": HATCHING.tint}
    warning = {"type": "diffuse", "reflectance": rgb_texture(HATCHING.color)}
    attribute = {"type": "mesh_attribute", "name": WARNED}
    return _blend(attribute, below, _blend(tint, below, warning))


def covered_bsdf(below: Plugin) -> Plugin:
    """Return a surface that the colour of its attributes covers where their share says so."""
    color = {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": COVER_COLOR}}
    return _blend({"type": "mesh_attribute", "name": COVER_SHARE}, below, color)


def _blend(weight: Plugin | float, below: Plugin, above: Plugin) -> Plugin:
    return {"type": "blendbsdf", "weight": weight, "below": below, "above": above}


def _layer(
    material: Material, pattern: str, color: tuple[float, float, float], layout: Layer
) -> Plugin:
    drawn = tile(pattern)
    tint = np.array(WARMTH, np.float32)
    albedo = linear(color) * drawn.shade[..., None] * (1 + drawn.warmth[..., None] * tint)
    albedo = albedo.clip(MIN_REFLECTANCE, MAX_REFLECTANCE)
    texture = _bitmap(albedo, material.texture_scale * layout.scale, layout.turn_deg)
    return opaque_bsdf(material, texture)


def _bump(material: Material, surface: Plugin) -> Plugin:
    drawn = tile(material.texture)
    # The relief grows with the tile, which keeps its slopes.
    relief = drawn.relief[..., None] * (material.texture_scale / drawn.size)
    return {
        "type": "bumpmap",
        "scale": material.bump,
        "relief": _bitmap(relief, material.texture_scale, 0.0),
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


def share_names(material: Material | None) -> list[str]:
    """Return the mesh attributes that a patterned ground needs."""
    if material is None:
        return []
    colors = {
        CREST: material.crest_color,
        HOLLOW: material.hollow_color,
        STEEP: material.steep_color,
    }
    return [name for name, color in colors.items() if color is not None]


def vertex_shares(
    material: Material, vertices: NDArray[np.float32], normals: NDArray[np.float32]
) -> dict[str, NDArray[np.float32]]:
    """Return the mesh attributes of a ground by slope and height, with ragged borders.

    Args:
        material: of the ground.
        vertices: (V, 3) [m].
        normals: (V, 3).
    """
    x, y, z = vertices.T
    # Incommensurable waves, never seen to repeat.
    ragged = np.sin(5.1 * x + 1.7 * z + 2.3 * y) + np.sin(3.3 * z - 4.4 * x + 1.1)
    ragged += np.sin(9.7 * x + 8.3 * z) * np.sin(7.9 * z - 6.1 * y)
    slope = np.degrees(np.arccos(np.clip(np.abs(normals[:, 1]), 0, 1))) + 2.5 * ragged
    height = y + 0.1 * SOFT_HEIGHT * ragged
    distances = {
        STEEP: (slope - material.steep_deg) / SOFT_SLOPE_DEG,
        CREST: (height - material.crest_height) / SOFT_HEIGHT,
        HOLLOW: (material.hollow_height - height) / SOFT_HEIGHT,
    }
    return {name: _centered_step(distances[name]) for name in share_names(material)}


def _centered_step(x: NDArray[np.floating]) -> NDArray[np.float32]:
    t = (0.5 + 0.5 * x).clip(0, 1)
    return np.asarray(t * t * (3 - 2 * t), np.float32)
