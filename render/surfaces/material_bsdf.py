"""Materials as Mitsuba's BSDFs.

A pattern is looked at once a point (`render.surfaces.patterns`); in the scalar variant, where that
would be slow, it is made of Mitsuba's own textures (`render.surfaces.mitsuba_bsdf`).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mitsuba as mi

from render.coat import Coat
from render.color import linear
from render.config import Material
from render.footprints import Prints
from render.glossy import glossy
from render.hatching import TINT, TINTED, WARNING
from render.plain import clear, flat, is_rough, plain
from render.surfaces.bsdf_plugins import rough
from render.surfaces.mitsuba_bsdf import Surface, nested, tinted
from render.surfaces.patterns import Ground

__all__ = ["TINTED", "Surface", "bsdf", "glowing", "has_shares"]


def bsdf(
    words: Material, surface: Surface, warned: bool = False, prints: Prints | None = None
) -> Any:
    """Return the BSDF of a material, `mi.BSDF`.

    Args:
        words: the material, written out in full.
        surface: what a pattern is laid on: ground, a body, or nothing that could bear one.
        warned: whether the surface carries the attribute `TINTED`.
        prints: what is pressed into ground; the scalar variant leaves it out.
    """
    if words.transmission > 0:
        return mi.load_dict(clear(words))
    has_pattern = surface != "bare" and words.texture != "none"
    if not (has_pattern or warned or prints) or _is_scalar():
        made = nested(words, surface) if has_pattern else plain(words, flat(words.color))
        if warned:
            made = tinted(TINTED, TINT, made, WARNING)
        return mi.load_dict({"type": "twosided", "bsdf": made})
    look = _look(words if has_pattern else words.model_copy(update=_BARE), surface, warned, prints)
    if is_rough(words):
        return rough(look, look.values)
    return glossy(words, look, look.values)


def _look(words: Material, surface: Surface, warned: bool, prints: Prints | None) -> Ground | Coat:
    if surface == "body" and words.texture != "none":
        return Coat(words)
    return Ground(words, warned, prints)


def glowing(words: Material) -> dict[str, Any]:
    """Return the emitter of a material that gives off light."""
    radiance = [float(words.glow * c) for c in linear(words.color)]
    return {"type": "area", "radiance": {"type": "rgb", "value": radiance}}


def has_shares(words: Material, surface: Surface) -> bool:
    """Whether meshes of this material carry the attributes of `render.shares`."""
    return _is_scalar() and surface == "ground" and words.texture != "none"


_BARE = {
    "texture": "none",
    "color2": None,
    "steep_color": None,
    "crest_color": None,
    "hollow_color": None,
    "bump": 0.0,
}
"""Words of a surface without any pattern."""


def light_paths(materials: Iterable[Material]) -> int:
    """Return how many more bounces a light path may take through what is clear."""
    # In and out of one solid, and what it mirrors inside once.
    return 3 if any(words.transmission > 0 for words in materials) else 0


def needs_coordinates(words: Material, surface: Surface) -> bool:
    """Whether meshes of this material carry texture coordinates."""
    # A look lays ground by its place in the world.
    return words.texture != "none" and (surface == "body" or _is_scalar())


def _is_scalar() -> bool:
    return str(mi.variant()).startswith("scalar")
