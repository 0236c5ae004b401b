"""Materials as Mitsuba's BSDFs.

A pattern is looked at once a point (`render.ground`); in the scalar variant, where that
would be slow, it is made of Mitsuba's own textures (`render.nested`).
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from render.color import linear
from render.glossy import glossy
from render.ground import TINT, TINTED, WARNING, Ground
from render.nested import STEEP, nested, tinted
from render.plain import flat, is_rough, plain
from render.rough import rough
from render.words import Material

__all__ = ["STEEP", "TINTED", "bsdf", "glowing", "shows_rock"]


def bsdf(words: Material, textured: bool, warned: bool = False) -> Any:
    """Return the BSDF of a material, `mi.BSDF`.

    Args:
        words: the material, written out in full.
        textured: whether the surface is ground that a pattern is laid on.
        warned: whether it carries the attribute `TINTED`.
    """
    has_pattern = textured and words.texture != "none"
    if not (has_pattern or warned) or _is_scalar():
        surface = nested(words) if has_pattern else plain(words, flat(words.color))
        if warned:
            surface = tinted(TINTED, TINT, surface, WARNING)
        return mi.load_dict({"type": "twosided", "bsdf": surface})
    look = Ground(words if has_pattern else words.model_copy(update=_BARE), warned)
    if is_rough(words):
        return rough(look, look.values)
    return glossy(words, look, look.values)


def glowing(words: Material) -> dict[str, Any]:
    """Return the emitter of a material that gives off light."""
    radiance = [float(words.glow * c) for c in linear(words.color)]
    return {"type": "area", "radiance": {"type": "rgb", "value": radiance}}


def shows_rock(words: Material) -> bool:
    """Whether meshes of this material carry the attribute `STEEP`."""
    return _is_scalar() and words.texture != "none" and words.steep_color is not None


_BARE = {"texture": "none", "color2": None, "steep_color": None, "bump": 0.0}
"""Words of a surface without any pattern."""


def _is_scalar() -> bool:
    return str(mi.variant()).startswith("scalar")
