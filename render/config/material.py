"""Materials: how a surface looks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field

from render.config.base import Color, PresetWords, Unit, known_name
from render.config.creature_materials import CREATURES
from render.config.ground_materials import GROUNDS
from render.config.thing_materials import THINGS

Texture = Literal[
    "none",
    "soil",
    "sand",
    "grass",
    "snow",
    "rock",
    "gravel",
    "mud",
    "asphalt",
    "ice",
    "tiles",
    "checker",
    "wood",
    "planks",
    "mottle",
    "shell",
    "fur",
    "plumage",
    "pores",
    "weave",
    "scratches",
    "brushed",
    "plaster",
    "clay",
    "marble",
]

PALETTE: dict[str, dict[str, Any]] = {**CREATURES, **THINGS, **GROUNDS}
"""All named materials."""


class Material(PresetWords):
    """How a surface looks: the name of a preset, an adjusted preset, or all words.

    On the ground a texture is laid from above, or from the side where it is steep; on
    bodies and limbs it runs along them and goes with them.
    """

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = PALETTE

    color: Color = Field((0.5, 0.5, 0.5), description="Base colour, '#rrggbb' or [r, g, b] sRGB.")
    roughness: Unit = Field(0.5, description="0 is a mirror, 1 is chalk.")
    metallic: Unit = Field(0.0, description="0 is a dielectric, 1 is bare metal.")
    clearcoat: Unit = Field(0.0, description="Weight of a clear, glossy coat.")
    sheen: Unit = Field(0.0, description="Weight of a soft gloss at the rim, as of velvet.")
    transmission: Unit = Field(
        0.0, description="Share of the light that goes through, as in glass."
    )
    ior: float = Field(1.5, ge=1.01, le=3, description="Index of refraction of what is clear.")
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
    crest_color: Color | None = Field(
        None,
        description="Colour of textured ground above `crest_height`, such as dry crests or snow.",
    )
    crest_height: float = Field(1.0, description="Height [m] from which crests show their colour.")
    hollow_color: Color | None = Field(
        None, description="Colour of textured ground below `hollow_height`, such as damp soil."
    )
    hollow_height: float = Field(0.0, description="Height [m] up to which hollows show theirs.")


MATERIALS: dict[str, Material] = {name: Material.model_validate(name) for name in PALETTE}


def material(word: str | Mapping[str, Any] | Material) -> Material:
    """Return the material that a word in a scene stands for, written out in full.

    Raises:
        ValueError: no preset has this name (the message holds the nearest one), or a
            value is out of range.
    """
    if isinstance(word, str):
        return MATERIALS[known_name(word, MATERIALS, "material")]
    return Material.model_validate(word)
