"""Materials: colour, reflection and texture of a surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from render.config.base import Color, PresetModel, Unit, known_name
from render.config.material_palette import PALETTE

Texture = Literal[
    "none",
    "soil",
    "sand",
    "grass",
    "moss",
    "snow",
    "rock",
    "gravel",
    "mud",
    "asphalt",
    "ice",
    "waves",
    "tiles",
    "checker",
    "slabs",
    "wood",
    "planks",
    "mottle",
    "shell",
    "carapace",
    "fur",
    "plumage",
    "pores",
    "wrinkles",
    "scales",
    "weave",
    "scratches",
    "brushed",
    "plaster",
    "clay",
    "marble",
]

DIFFUSE_ROUGHNESS = 0.7
"""Roughness from which a bare dielectric is diffuse, which is fastest and flickers least."""


class Material(PresetModel):
    """The look of a surface: the name of a preset, an adjusted preset, or all values.

    On the ground a texture is projected from above, or from the side where it is steep; on
    bodies and limbs it runs along them and moves with them.
    """

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = PALETTE

    color: Color = Field((0.5, 0.5, 0.5), description="Base colour, '#rrggbb' or [r, g, b] sRGB.")
    roughness: Unit = Field(0.5, description="0 is a mirror, 1 is chalk.")
    metallic: Unit = Field(0.0, description="0 is a dielectric, 1 is bare metal.")
    clearcoat: Unit = Field(0.0, description="Weight of a clear, glossy coat.")
    sheen: Unit = Field(
        0.0,
        description="Weight of a soft gloss at the rim, as of velvet; of what is translucent, of a "
        "bright rim before a light, as of hair.",
    )
    subsurface: Unit = Field(
        0.0,
        description="How far light that scatters below the surface, as in skin, softens the edge "
        "of its shade: red most.",
    )
    transmission: Unit = Field(
        0.0, description="Share of the light that goes through, as in glass."
    )
    translucency: Unit = Field(
        0.0,
        description="Share of the scattered light that leaves on the other side of a thin, dull "
        "sheet, such as a leaf, paper or cloth.",
    )
    ior: float = Field(1.5, ge=1.01, le=3, description="Index of refraction of a clear material.")
    glow: float = Field(
        0.0,
        ge=0,
        le=1e4,
        description="Emitted light of its colour; a sunlit surface has about 10.",
    )
    texture: Texture = Field("none", description="Pattern over the base colour.")
    texture_scale: float = Field(
        2.0, ge=0.01, le=1000, description="Length [m] after which the pattern repeats."
    )
    color2: Color | None = Field(None, description="Second colour, mixed in by patches.")
    bump: float = Field(0.0, ge=0, le=4, description="Relief of the texture; 1 is natural.")
    steep_color: Color | None = Field(
        None, description="Colour of bare rock where a textured surface is steep."
    )
    steep_deg: float = Field(
        33.0, ge=1, le=89, description="Slope [degrees] at which the rock appears."
    )
    crest_color: Color | None = Field(
        None,
        description="Colour of textured ground above `crest_height`, such as dry crests or snow.",
    )
    crest_height: float = Field(1.0, description="Height [m] above which crests show their colour.")
    hollow_color: Color | None = Field(
        None, description="Colour of textured ground below `hollow_height`, such as damp soil."
    )
    hollow_height: float = Field(0.0, description="Height [m] below which hollows show theirs.")

    @model_validator(mode="after")
    def _translucent_is_dull(self) -> Material:
        shines = self.metallic or self.clearcoat or self.transmission
        shines = shines or self.subsurface
        if self.translucency and (shines or self.roughness < DIFFUSE_ROUGHNESS):
            raise ValueError(
                f"translucency needs a dull surface: roughness of at least {DIFFUSE_ROUGHNESS:g}, "
                "and no metallic, clearcoat, subsurface or transmission"
            )
        return self


MATERIALS: dict[str, Material] = {name: Material.model_validate(name) for name in PALETTE}


def material(value: str | Mapping[str, Any] | Material) -> Material:
    """Return the material of a value in a scene, written out in full.

    Raises:
        ValueError: no preset has this name (the message holds the nearest one), or a
            value is out of range.
    """
    if isinstance(value, str):
        return MATERIALS[known_name(value, MATERIALS, "material")]
    return Material.model_validate(value)
