"""Titles: words over the picture, when they are shown and how they look."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from render.config.base import Color, PresetModel

TitlePlace = Literal["middle", "top", "bottom", "lower left", "lower right"]

FontName = Literal["serif", "sans"]

_PRESETS: dict[str, dict[str, Any]] = {
    "title": {},
    "caption": {"place": "bottom", "size": 0.045, "font": "sans", "duration": 3.0, "fade": 0.4},
    "name": {"place": "lower left", "size": 0.042, "font": "sans", "duration": 3.0, "fade": 0.4},
    "credits": {"size": 0.045, "duration": 6.0, "fade": 0.6, "roll": True},
}

MAX_TITLES = 100


class Title(PresetModel):
    """Words over the picture: a title, a caption, a name or end credits."""

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = _PRESETS

    text: str = Field(
        "",
        max_length=4000,
        description="The words, a line for each line; the scene's title if left out, and for what "
        "rolls its title and its cast.",
    )
    start: Annotated[float, Field(ge=0, le=1e6)] | None = Field(
        None, description="When it appears [s]; at once, and what rolls at the end, if left out."
    )
    duration: Annotated[float, Field(gt=0, le=3600)] = Field(
        3.5, description="How long it is shown [s]."
    )
    fade: Annotated[float, Field(ge=0, le=30)] = Field(
        0.8, description="How long it takes to appear, and to vanish [s]."
    )
    place: TitlePlace = Field("middle", description="Where it stands.")
    size: Annotated[float, Field(ge=0.01, le=0.5)] = Field(
        0.10, description="Height of a line, in the height of the frame."
    )
    font: FontName = Field("serif", description="Kind of letters.")
    color: Color = Field((1.0, 0.98, 0.94), description="Colour, '#rrggbb' or [r, g, b] sRGB.")
    shadow: Annotated[float, Field(ge=0, le=1)] = Field(
        0.65, description="Darkness of a soft shadow behind it, by which it is legible anywhere."
    )
    roll: bool = Field(False, description="Whether it rolls through the frame from below.")
