"""Laid floor: how a floor is made of a material: boards of wood, slabs of concrete.

A wide floor in one piece has no scale: nobody sees how large it is, nor how far away.
"""

from __future__ import annotations

from collections.abc import Mapping

from render.config import Material

PIECES: Mapping[str, tuple[str, float]] = {"wood": ("planks", 4.0), "plaster": ("slabs", 4.8)}
"""Pattern of a floor by the texture of its material, and the factor on the texture's scale."""


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
    return material.model_copy(
        update={"texture": pattern, "texture_scale": material.texture_scale * factor}
    )
