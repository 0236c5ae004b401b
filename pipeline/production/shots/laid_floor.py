"""Laid floor: how a floor is made of a material: boards of wood, slabs of concrete.

A wide floor in one piece has no scale: nobody sees how large it is, nor how far away.
"""

from __future__ import annotations

from collections.abc import Mapping

from render.config import Material

PIECES: Mapping[str, tuple[str, float]] = {"wood": ("planks", 4.0), "plaster": ("slabs", 4.8)}
"""Pattern of a floor by the texture of its material, and the factor on the texture's scale."""

GREYED, GREY, DARK_GREY = 0.45, (0.60, 0.56, 0.50), (0.45, 0.41, 0.36)
"""Share of grey in boards outdoors, and its colours, sRGB."""


def floor_name(material: str) -> str:
    """Return the name of the floor that is laid of a material."""
    return f"{material}, laid"


def laid(material: Material, *, outdoors: bool) -> Material | None:
    """Return the material of a floor that is laid of pieces, None where it is in one piece.

    Args:
        material: that it is made of.
        outdoors: in a studio only wood has joints.
    """
    if material.texture not in (PIECES if outdoors else ("wood",)):
        return None
    pattern, factor = PIECES[material.texture]
    made = material.model_copy(
        update={"texture": pattern, "texture_scale": material.texture_scale * factor}
    )
    return _weathered(made) if outdoors and pattern == "planks" else made


def _weathered(boards: Material) -> Material:
    """Return boards that have lain in sun and rain: greyer and duller."""
    first, second = (
        tuple((1.0 - GREYED) * c + GREYED * g for c, g in zip(color, grey, strict=True))
        for color, grey in ((boards.color, GREY), (boards.color2 or boards.color, DARK_GREY))
    )
    roughness = max(boards.roughness, 0.75)
    return boards.model_copy(
        update={"color": first, "color2": second, "roughness": roughness, "clearcoat": 0.0}
    )
