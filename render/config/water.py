"""Water: the words in which authors describe still or moving water over a terrain."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from render.config.base import Angle, Color, PresetModel, Unit, known_name

WAVES = {"none": 0.0, "calm": 0.15, "ripples": 0.3, "breeze": 0.5, "rough": 0.85}
"""Strengths of waves that have a word."""


def _waves_of_word(value: object) -> object:
    return WAVES[known_name(value, WAVES, "waves")] if isinstance(value, str) else value


Waves = Annotated[
    Unit,
    BeforeValidator(_waves_of_word, json_schema_input_type=Unit | Literal[tuple(WAVES)]),
]

_PRESETS: dict[str, dict[str, Any]] = {
    "pond": {"waves": "calm", "clarity": 1.6, "color": "#3c4a24"},
    "lake": {"waves": "ripples", "clarity": 5.0, "color": "#24565a"},
    "river": {"waves": "breeze", "clarity": 2.2, "color": "#4d5a3c"},
    "sea": {"waves": "breeze", "clarity": 9.0, "color": "#1c5568", "surf": 0.85},
    "lagoon": {"waves": "ripples", "clarity": 16.0, "color": "#2c8f96"},
}


class Water(PresetModel):
    """Water that stands at one height over a terrain and the land around it."""

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = _PRESETS

    level: float = Field(
        0.0, ge=-1000, le=1000, description="Height of its surface in the world [m]."
    )
    waves: Waves = Field(
        0.3, description="Strength of the waves, 0 to 1 or a word; they are a few decimetres high."
    )
    heading_deg: Angle = Field(
        20.0, description="Heading in which the waves travel; 0 is +X [degrees]."
    )
    surf: Unit = Field(
        0.0, description="How white waves break where the bottom rises to a shore, 0 to 1."
    )
    clarity: float = Field(
        5.0,
        ge=0.05,
        le=200,
        description="Distance under water at which a tenth of the light is left [m].",
    )
    color: Color = Field(
        (0.14, 0.34, 0.35), description="Colour of deep water; what it lacks is absorbed sooner."
    )
