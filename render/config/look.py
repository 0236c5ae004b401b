"""Look: how developed frames are graded, by the name of a look or with values of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from render.config.base import PresetModel, Unit

Gain = Annotated[float, Field(ge=0, le=4)]
Gains = tuple[Gain, Gain, Gain]
Offset = Annotated[float, Field(ge=-0.5, le=0.5)]
Offsets = tuple[Offset, Offset, Offset]
Power = Annotated[float, Field(ge=0.2, le=5)]
Powers = tuple[Power, Power, Power]

_LENS = {"vignette": 0.22, "bloom": 0.3, "shadows": 0.6}

_PRESETS: dict[str, dict[str, Any]] = {
    "plain": {},
    # Shadows a little cooler than lights, as between sky and sun.
    "natural": {
        **_LENS,
        "slope": (1.012, 1.0, 0.982),
        "offset": (-0.006, -0.001, 0.006),
        "saturation": 0.96,
    },
    "warm": {
        **_LENS,
        "slope": (1.05, 1.0, 0.90),
        "offset": (0.004, 0.0, -0.006),
        "power": (0.97, 1.0, 1.06),
        "saturation": 0.98,
    },
    "cold": {
        **_LENS,
        "slope": (0.93, 0.99, 1.05),
        "offset": (-0.008, 0.0, 0.012),
        "power": (1.06, 1.0, 0.95),
        "saturation": 0.9,
    },
    "vivid": {**_LENS, "contrast": 1.1, "saturation": 1.32},
    "bleach": {
        **_LENS,
        "shadows": 0.2,
        "contrast": 1.3,
        "saturation": 0.5,
        "slope": (1.01, 1.0, 0.98),
    },
    "faded": {
        **_LENS,
        "contrast": 0.9,
        "saturation": 0.8,
        "black": 0.07,
        "white": 0.96,
        "slope": (1.02, 1.0, 0.96),
    },
    "noir": {"contrast": 1.25, "saturation": 0.0, "vignette": 0.5, "bloom": 0.45},
    "dream": {
        "contrast": 0.92,
        "saturation": 0.94,
        "black": 0.03,
        "slope": (1.03, 1.0, 0.99),
        "vignette": 0.3,
        "bloom": 1.0,
        "shadows": 0.7,
    },
}


class Look(PresetModel):
    """A look: values of the frame c become (slope c + offset) ^ power, then saturated."""

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = _PRESETS

    contrast: float = Field(
        1.0, ge=0.3, le=3, description="Contrast about middle grey, before the rest."
    )
    slope: Gains = Field((1.0, 1.0, 1.0), description="Factor of red, green, blue.")
    offset: Offsets = Field((0.0, 0.0, 0.0), description="Added to red, green, blue.")
    power: Powers = Field((1.0, 1.0, 1.0), description="Power of each; above 1 is darker.")
    saturation: float = Field(1.0, ge=0, le=3, description="0 is black and white.")
    black: float = Field(0.0, ge=0, le=0.4, description="Value that black is shown with.")
    white: float = Field(1.0, ge=0.5, le=1, description="Value that white is shown with.")
    shadows: Unit = Field(
        0.0, description="How far shade is opened, where contrast was added for the highlights."
    )
    vignette: Unit = Field(0.0, description="How much darker the corners are; 1 is black.")
    bloom: Unit = Field(0.0, description="Glow around what is very bright.")

    @model_validator(mode="before")
    @classmethod
    def _default_preset(cls, value: object) -> object:
        if not isinstance(value, Mapping) or value.get("preset") is not None:
            return value
        return {**_PRESETS["natural"], **value}

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        if self.black >= self.white:
            raise ValueError(f"`black` {self.black:g} is not below `white` {self.white:g}")
        return self


PLAIN = Look.model_validate("plain")
"""The look that changes nothing."""
