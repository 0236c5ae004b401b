"""The BSDF and the emitter of a material.

Patterns are evaluated once per point by a Python shader (`patterns`); in the scalar variant,
where that would be slow, they are made of Mitsuba's own textures (`mitsuba_bsdf`).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mitsuba as mi

from render.color import linear
from render.config import Material
from render.footprints import FootprintRaster
from render.ground_wear import GroundWear
from render.surfaces.bsdf_plugins import diffuse_bsdf, glossy_bsdf, thin_bsdf
from render.surfaces.mitsuba_bsdf import (
    Surface,
    covered_bsdf,
    is_diffuse,
    opaque_bsdf,
    patterned_bsdf,
    rgb_texture,
    thin_plugin,
    transmissive_bsdf,
    vertex_colors,
    warned_bsdf,
)
from render.surfaces.patterns import BodyShader, GroundShader, PaintedShader, PlainShader

_NO_PATTERN = {
    "texture": "none",
    "color2": None,
    "steep_color": None,
    "crest_color": None,
    "hollow_color": None,
    "bump": 0.0,
}
"""Values of a material without pattern."""


def material_bsdf(
    material: Material,
    surface: Surface,
    is_warned: bool = False,
    footprints: FootprintRaster | None = None,
    *,
    has_colors: bool = False,
    has_cover: bool = False,
    wear: GroundWear | None = None,
) -> Any:
    """Return the BSDF of a material, `mi.BSDF`.

    Args:
        material: written out in full.
        surface: what a pattern is laid on.
        is_warned: whether the surface has the attribute `patterns.WARNED`.
        footprints: in the ground; the scalar variant leaves them out.
        has_colors: whether the surface has the attribute `mitsuba_bsdf.VERTEX_COLOR`, which then
            is its base colour.
        has_cover: whether the surface has the attributes `patterns.COVER_COLOR` and `COVER_SHARE`.
        wear: bare soil on the ground; the scalar variant leaves it out.
    """
    if material.transmission > 0:
        return mi.load_dict(transmissive_bsdf(material))
    has_pattern = surface != "bare" and material.texture != "none"
    plain = vertex_colors() if has_colors else rgb_texture(material.color)
    is_thin = material.translucency > 0
    is_body = surface != "ground"
    is_ground = is_warned or footprints is not None or wear is not None
    is_ground |= has_cover and not is_body
    if not (has_pattern or is_ground or is_thin or has_cover) or _is_scalar():
        if is_thin and not has_pattern:
            return mi.load_dict(thin_plugin(material, plain))
        made = patterned_bsdf(material, surface) if has_pattern else opaque_bsdf(material, plain)
        made = covered_bsdf(made) if has_cover else made
        made = warned_bsdf(made) if is_warned else made
        return mi.load_dict({"type": "twosided", "bsdf": made})
    shader: BodyShader | GroundShader | PaintedShader | PlainShader
    if has_cover and is_body and not has_pattern and not is_warned:
        shader = PaintedShader(material)
    elif has_colors or not (has_pattern or is_ground):
        shader = PlainShader(material, mi.load_dict(plain) if has_colors else None)
    elif has_pattern and surface == "body":
        shader = BodyShader(material, has_cover=has_cover)
    else:
        shown = material if has_pattern else material.model_copy(update=_NO_PATTERN)
        shader = GroundShader(shown, is_warned, footprints, has_cover=has_cover, wear=wear)
    if is_thin:
        return thin_bsdf(shader, shader.values, material.translucency, material.sheen)
    if is_diffuse(material):
        return diffuse_bsdf(shader, shader.values)
    return glossy_bsdf(material, shader, shader.values)


def area_emitter(material: Material) -> dict[str, Any]:
    """Return the emitter of a glowing material."""
    radiance = [float(material.glow * c) for c in linear(material.color)]
    return {"type": "area", "radiance": {"type": "rgb", "value": radiance}}


def needs_vertex_shares(material: Material, surface: Surface) -> bool:
    """Whether meshes of this material have the attributes of `mitsuba_bsdf.vertex_shares`."""
    return _is_scalar() and surface == "ground" and material.texture != "none"


def needs_coordinates(material: Material, surface: Surface) -> bool:
    """Whether meshes of this material have texture coordinates."""
    # A ground shader projects by the position in the world.
    return material.texture != "none" and (surface == "body" or _is_scalar())


def extra_bounces(materials: Iterable[Material]) -> int:
    """Return the additional bounces that light paths through transmissive materials need."""
    # In and out of one solid, and one reflection inside.
    return 3 if any(material.transmission > 0 for material in materials) else 0


def _is_scalar() -> bool:
    return str(mi.variant()).startswith("scalar")
