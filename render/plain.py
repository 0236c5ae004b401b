"""Plain surfaces: how light leaves one point, whatever the pattern gives as its colour."""

from __future__ import annotations

from typing import Any

from render.color import linear
from render.config import Material

ROUGH = 0.7
"""From this roughness on a bare dielectric scatters evenly, which costs and flickers least."""


def is_rough(words: Material) -> bool:
    """Whether a material scatters evenly: rough, and neither metal nor coated."""
    shines = words.metallic or words.clearcoat or words.sheen or words.transmission
    return words.roughness >= ROUGH and not shines


def plain(words: Material, color: Any) -> dict[str, Any]:
    """Return the BSDF of a material with its colour as a dictionary for `mi.load_dict`."""
    if is_rough(words):
        return {"type": "diffuse", "reflectance": color}
    return {
        "type": "principled",
        "base_color": color,
        "roughness": max(words.roughness, 0.03),
        "metallic": words.metallic,
        "specular": 0.5,
        "clearcoat": words.clearcoat,
        "clearcoat_gloss": 0.93,
        "sheen": words.sheen,
        "sheen_tint": 0.6,
    }


def clear(words: Material) -> dict[str, Any]:
    """Return the BSDF of a material that light goes through; it has two sides by itself."""
    tinted = {"int_ior": words.ior, "specular_transmittance": flat(words.color)}
    glass: dict[str, Any] = {"type": "dielectric", **tinted}
    if words.roughness > 0.03:
        glass = {"type": "roughdielectric", "alpha": words.roughness**2, **tinted}
    if words.transmission >= 1.0:
        return glass
    opaque = {"type": "twosided", "bsdf": plain(words, flat(words.color))}
    return {"type": "blendbsdf", "weight": words.transmission, "below": opaque, "above": glass}


def flat(color: tuple[float, float, float]) -> dict[str, Any]:
    """Return a colour in sRGB as a texture."""
    return {"type": "rgb", "value": [float(c) for c in linear(color)]}
