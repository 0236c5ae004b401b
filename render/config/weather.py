"""Weather: how the wind drives the clouds, and what falls from them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from render.config.base import PresetModel, Unit

GROUND_SHARE = 1 / 3
"""Wind near the ground, as a share of that at the clouds."""

_WEATHER: dict[str, dict[str, Any]] = {
    "calm": {"wind": 0.0},
    "breeze": {},
    "after rain": {"wet": 0.6},
    "drizzle": {"rain": 0.25},
    "rain": {"rain": 0.6},
    "storm": {"rain": 1.0, "wind": 18.0},
    "flurries": {"snow": 0.25},
    "snow": {"snow": 0.6},
    "blizzard": {"snow": 1.0, "wind": 16.0},
}


class Weather(PresetModel):
    """Wind, rain and snow; both may fall at once."""

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = _WEATHER

    rain: Unit = Field(0.0, description="0.25 is drizzle, 1 a downpour; it wets the ground.")
    wet: Unit = Field(
        0.0,
        description="How wet ground and things are without rain: 0.6 is after rain, with puddles.",
    )
    snow: Unit = Field(0.0, description="0.25 are single flakes; it whitens level ground.")
    wind: float = Field(
        8.0,
        ge=0,
        le=60,
        description="Speed of the clouds [m/s]; a third of it drives rain and snow.",
    )
    wind_heading_deg: float = Field(
        25.0, ge=-360, le=360, description="Heading that the wind blows to; 0 is +X."
    )

    @property
    def wetness(self) -> float:
        """How wet ground and things are, as the amount of rain that wets them so, 0 to 1."""
        return max(self.rain, self.wet)

    @property
    def ground_wind(self) -> tuple[float, float]:
        """Velocity of the wind near the ground, along x and z [m/s]."""
        heading = math.radians(self.wind_heading_deg)
        speed = GROUND_SHARE * self.wind
        return speed * math.cos(heading), -speed * math.sin(heading)

    @property
    def falls(self) -> bool:
        """Whether rain or snow falls."""
        return self.rain > 0.0 or self.snow > 0.0
