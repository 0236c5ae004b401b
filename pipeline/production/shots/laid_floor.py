"""Laid floor: how a floor is made of a material: boards of wood, slabs of stone, tiles.

A wide floor in one piece has no scale: nobody sees how large it is, nor how far away.
"""

from __future__ import annotations

from collections.abc import Mapping

from render.config import Material

PIECES: Mapping[str, tuple[str, float]] = {
    "wood": ("planks", 4.0),
    "plaster": ("slabs", 1.2),
    "tiles": ("tiles", 1.0),
}
"""Pattern of a floor by the texture of its material, and the factor on the texture's scale."""

GREYED, GREY, DARK_GREY = 0.45, (0.60, 0.56, 0.50), (0.45, 0.41, 0.36)
"""Share of grey in boards outdoors, and its colours, sRGB."""


QUARRIED, SAND, ASH = 0.5, (0.60, 0.545, 0.455), (0.475, 0.45, 0.415)
"""Share of stone in slabs outdoors, and its colours, sRGB."""

BLEACHED, BLEACH, LIME = 0.42, (0.70, 0.62, 0.53), (0.58, 0.49, 0.41)
"""Share of what sun and lime leave on tiles outdoors, and its colours, sRGB."""


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
    if not outdoors:
        return made
    if pattern == "planks":
        return _blended(made, GREYED, GREY, DARK_GREY)
    if pattern == "slabs":
        return _blended(made, QUARRIED, SAND, ASH)
    return _blended(made, BLEACHED, BLEACH, LIME)


def _blended(
    pieces: Material,
    share: float,
    light: tuple[float, float, float],
    dark: tuple[float, float, float],
) -> Material:
    """Return pieces that have lain in sun and rain: duller, and with a share of other colours."""
    first, second = (
        tuple((1.0 - share) * c + share * g for c, g in zip(color, other, strict=True))
        for color, other in ((pieces.color, light), (pieces.color2 or pieces.color, dark))
    )
    roughness = max(pieces.roughness, 0.75)
    return pieces.model_copy(
        update={"color": first, "color2": second, "roughness": roughness, "clearcoat": 0.0}
    )
