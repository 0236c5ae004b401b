"""Materials: how a surface looks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field

from render.words.base import Color, PresetWords, Unit, known_name

Texture = Literal["none", "soil", "sand", "grass", "snow", "rock", "wood", "mottle"]

_PRESETS: dict[str, dict[str, Any]] = {
    # Creatures.
    "green chitin": {"color": "#46691f", "roughness": 0.33, "clearcoat": 0.9, "metallic": 0.35},
    "brown chitin": {"color": "#5a3217", "roughness": 0.4, "clearcoat": 0.8, "metallic": 0.15},
    "black chitin": {"color": "#1b1a1d", "roughness": 0.35, "clearcoat": 1.0, "metallic": 0.2},
    "red chitin": {"color": "#94201a", "roughness": 0.38, "clearcoat": 0.9, "metallic": 0.15},
    "blue chitin": {"color": "#1f4a85", "roughness": 0.36, "clearcoat": 0.9, "metallic": 0.35},
    "amber chitin": {"color": "#b8741c", "roughness": 0.38, "clearcoat": 0.8, "metallic": 0.15},
    "bone": {"color": "#ddd0b4", "roughness": 0.45, "clearcoat": 0.2},
    "skin": {"color": "#c98f73", "roughness": 0.5, "clearcoat": 0.1},
    "fur": {"color": "#8a6542", "roughness": 0.9},
    "chestnut fur": {"color": "#6e3a1c", "roughness": 0.62, "clearcoat": 0.1},
    "sand fur": {"color": "#b88d58", "roughness": 0.85},
    "grey fur": {"color": "#77716a", "roughness": 0.85},
    "black fur": {"color": "#1d1917", "roughness": 0.7},
    "feathers": {"color": "#2b2725", "roughness": 0.8},
    "horn": {"color": "#3a322a", "roughness": 0.45, "clearcoat": 0.2},
    "leather": {"color": "#4a2f1f", "roughness": 0.5, "clearcoat": 0.1},
    "red cloth": {"color": "#9c2f2b", "roughness": 0.95},
    "blue cloth": {"color": "#2c4a73", "roughness": 0.95},
    "eye": {"color": "#08080a", "roughness": 0.08, "clearcoat": 1.0},
    # Things.
    "wood": {
        "color": "#9a6b3f",
        "color2": "#6e4526",
        "roughness": 0.55,
        "texture": "wood",
        "texture_scale": 0.5,
    },
    "clay": {"color": "#b0643f", "roughness": 0.85},
    "brick": {"color": "#98482f", "roughness": 0.9},
    "brass": {"color": "#d9a94a", "roughness": 0.28, "metallic": 1.0},
    "copper": {"color": "#c8744f", "roughness": 0.3, "metallic": 1.0},
    "steel": {"color": "#b4b8bd", "roughness": 0.25, "metallic": 1.0},
    "rubber": {"color": "#262628", "roughness": 0.75},
    "red rubber": {"color": "#b2261f", "roughness": 0.5, "clearcoat": 0.15},
    "white plaster": {"color": "#dcd9d2", "roughness": 0.9},
    "grey plaster": {"color": "#8b8a87", "roughness": 0.9},
    "red plastic": {"color": "#b3231c", "roughness": 0.3, "clearcoat": 0.5},
    "blue plastic": {"color": "#22569c", "roughness": 0.3, "clearcoat": 0.5},
    "yellow plastic": {"color": "#d9a818", "roughness": 0.3, "clearcoat": 0.5},
    "flame": {"color": "#ff7417", "roughness": 1.0, "glow": 2.5},
    "smoke": {"color": "#a3a19d", "roughness": 1.0},
    "water": {"color": "#a9c4d4", "roughness": 0.08, "clearcoat": 1.0},
    "leaf": {"color": "#637d2b", "roughness": 0.65, "clearcoat": 0.1},
    # Ground.
    "dry soil": {
        "color": "#8c7156",
        "color2": "#ab9678",
        "roughness": 0.95,
        "texture": "soil",
        "texture_scale": 2.6,
        "bump": 1.0,
        "steep_color": "#85766a",
    },
    "grass": {
        "color": "#5d6b3a",
        "color2": "#87834e",
        "roughness": 0.9,
        "texture": "grass",
        "texture_scale": 1.9,
        "bump": 1.0,
        "steep_color": "#7d7264",
    },
    "moss": {
        "color": "#4d5f25",
        "color2": "#6b7038",
        "roughness": 0.95,
        "texture": "grass",
        "texture_scale": 1.1,
        "bump": 0.8,
        "steep_color": "#6d6a64",
    },
    "sand": {
        "color": "#cfae7b",
        "color2": "#dcc193",
        "roughness": 0.9,
        "texture": "sand",
        "texture_scale": 2.2,
        "bump": 0.8,
        "steep_color": "#b78f5f",
    },
    "snow": {
        "color": "#e9edf2",
        "color2": "#dfe6ef",
        "roughness": 0.7,
        "texture": "snow",
        "texture_scale": 2.4,
        "bump": 0.6,
        "steep_color": "#706d6c",
        "steep_deg": 40,
    },
    "rock": {
        "color": "#85796c",
        "color2": "#9c9184",
        "roughness": 0.85,
        "texture": "rock",
        "texture_scale": 2.9,
        "bump": 1.2,
    },
}


class Material(PresetWords):
    """How a surface looks: the name of a preset, an adjusted preset, or all words.

    A texture needs a surface with texture coordinates, such as terrain; elsewhere the
    surface shows `color`.
    """

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = _PRESETS

    color: Color = Field((0.5, 0.5, 0.5), description="Base colour, '#rrggbb' or [r, g, b] sRGB.")
    roughness: Unit = Field(0.5, description="0 is a mirror, 1 is chalk.")
    metallic: Unit = Field(0.0, description="0 is a dielectric, 1 is bare metal.")
    clearcoat: Unit = Field(0.0, description="Weight of a clear, glossy coat.")
    glow: float = Field(
        0.0,
        ge=0,
        le=1e4,
        description="Light of its colour that it gives off; about 10 is what the sun lights.",
    )
    texture: Texture = Field("none", description="Pattern laid over the base colour.")
    texture_scale: float = Field(
        2.0, ge=0.01, le=1000, description="Length [m] after which the pattern starts again."
    )
    color2: Color | None = Field(None, description="Colour that the texture mixes in, in patches.")
    bump: float = Field(0.0, ge=0, le=4, description="Relief of the texture; 1 is natural.")
    steep_color: Color | None = Field(
        None, description="Colour of bare rock where a textured surface is steep."
    )
    steep_deg: float = Field(
        33.0, ge=1, le=89, description="Slope [degrees] about which the rock shows."
    )


MATERIALS: dict[str, Material] = {name: Material.model_validate(name) for name in _PRESETS}


def material(word: str | Mapping[str, Any] | Material) -> Material:
    """Return the material that a word in a scene stands for, written out in full.

    Raises:
        ValueError: no preset has this name (the message holds the nearest one), or a
            value is out of range.
    """
    if isinstance(word, str):
        return MATERIALS[known_name(word, MATERIALS, "material")]
    return Material.model_validate(word)
