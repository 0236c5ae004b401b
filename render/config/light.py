"""Light: a sun with its sky by day and night, a studio or a picture of a place; and lamps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from render.config.base import Color, PresetWords, Unit, Words, known_name
from render.config.lamp import Lamp


class Sun(Words):
    """Where the sun stands, by hour, day and latitude, and the air that it shines through."""

    hour: float = Field(
        16.5, ge=0, le=24, description="Solar time: 12 is noon, 0 and 24 are midnight."
    )
    day: int = Field(172, ge=1, le=366, description="Day of the year; 172 is midsummer.")
    latitude_deg: float = Field(48.0, ge=-90, le=90, description="North is positive.")
    north_deg: float = Field(
        160.0, ge=-360, le=360, description="Heading of north: 0 is +X, 90 is -Z."
    )
    turbidity: float = Field(2.5, ge=1, le=10, description="Haze: 2 is alpine, 6 is dusty.")
    softness_deg: float = Field(
        1.0, ge=0.5, le=20, description="Width of the sun's disc; the real one has 0.53."
    )
    clouds: Unit = Field(0.0, description="0 is a clear sky, 1 an overcast one without sun.")

    @property
    def direction(self) -> tuple[float, float, float]:
        """Unit vector to the sun in the world (Y up), from declination and hour angle.

        Source: J. Meeus, Astronomical Algorithms, 1998, eq. 13.5 and 13.6; the
        declination is Cooper's fit, good to half a degree.
        """
        declination = math.radians(23.45) * math.sin(2 * math.pi * (284 + self.day) / 365)
        turn = math.radians(15 * (self.hour - 12))
        latitude = math.radians(self.latitude_deg)
        up = math.sin(latitude) * math.sin(declination)
        up += math.cos(latitude) * math.cos(declination) * math.cos(turn)
        north = math.cos(latitude) * math.sin(declination)
        north -= math.sin(latitude) * math.cos(declination) * math.cos(turn)
        east = -math.cos(declination) * math.sin(turn)
        # A heading h looks along (cos h, 0, -sin h); east lies a quarter turn to the right.
        heading = math.radians(self.north_deg)
        x = north * math.cos(heading) + east * math.sin(heading)
        z = -north * math.sin(heading) + east * math.cos(heading)
        return x, up, z

    @property
    def elevation_deg(self) -> float:
        """Height of the sun above the horizon [degrees]."""
        return math.degrees(math.asin(max(-1.0, min(1.0, self.direction[1]))))


class Moon(Words):
    """The moon, which lights the night; it stands where it is wanted."""

    heading_deg: float = Field(
        -55.0, ge=-360, le=360, description="Heading towards the moon; 0 is +X."
    )
    elevation_deg: float = Field(38.0, ge=2, le=90, description="Height above the horizon.")
    phase: Unit = Field(1.0, description="0 is new and gives no light, 1 is full.")
    softness_deg: float = Field(
        1.2, ge=0.5, le=20, description="Width of its disc; the real one has 0.52."
    )


class Studio(Words):
    """A key light, a fill light and a rim light, large and soft, before a backdrop."""

    heading_deg: float = Field(
        -50.0, ge=-360, le=360, description="Heading towards the key light; 0 is +X."
    )
    elevation_deg: float = Field(42.0, ge=0, le=90, description="Height of the key light.")
    softness_deg: float = Field(26.0, ge=4, le=120, description="Width of the key light.")
    fill: Unit = Field(0.3, description="Light from the side opposite the key light.")
    rim: Unit = Field(0.5, description="Light from behind, which draws the edges.")
    backdrop: Color = Field((0.58, 0.6, 0.63), description="Colour of the backdrop.")


class Hdr(Words):
    """A picture of all directions around a place, which lights the scene."""

    file: Annotated[str, Field(min_length=1)] = Field(
        description="EXR or HDR file, twice as wide as high, beside the scene."
    )
    turn_deg: float = Field(0.0, ge=-360, le=360, description="Turns the place about +Y.")
    strength: float = Field(
        1.0, ge=0, le=1000, description="1 is exposed by itself, 2 is twice as bright."
    )


_PRESETS: dict[str, dict[str, Any]] = {
    "day": {"sun": {"hour": 16.5, "turbidity": 2.5}},
    "noon": {"sun": {"hour": 12.5}},
    "golden hour": {"sun": {"hour": 18.6, "turbidity": 3.0, "softness_deg": 1.4}},
    "dawn": {"sun": {"hour": 3.95, "turbidity": 3.0}},
    "dusk": {"sun": {"hour": 20.2, "turbidity": 3.0}},
    "night": {"sun": {"hour": 0.0}, "moon": {}},
    "overcast": {"sun": {"hour": 13.0, "clouds": 1.0}},
    "studio": {"studio": {}},
}
_SKIES = {"sun", "studio", "hdr"}


class Light(PresetWords):
    """What lights the scene: a preset or an adjusted one, a sun, a studio, a picture; and lamps."""

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = _PRESETS

    sun: Sun | None = Field(None, description="The sun and its sky; at night, with the moon.")
    studio: Studio | None = Field(None, description="A photographer's studio.")
    hdr: Hdr | None = Field(None, description="A picture of the light of a place.")
    moon: Moon | None = Field(None, description="The moon, seen while the sun is down.")
    stars: Unit | None = Field(None, description="How bright stars are at night; 0.5 unless said.")

    lamps: tuple[Lamp, ...] = Field(
        (), max_length=64, description="Lamps; with no other word of light they shine at night."
    )

    @model_validator(mode="before")
    @classmethod
    def _default(cls, value: object) -> object:
        if not isinstance(value, Mapping) or value.get("preset") is not None:
            return value
        if value.keys() & _SKIES:
            return value
        # Who asks for moon, stars or lamps and for no sky means the night.
        dark = any(value.get(word) not in (None, (), []) for word in ("moon", "stars", "lamps"))
        return {**value, "preset": "night" if dark else "day"}

    @model_validator(mode="after")
    def _one(self) -> Self:
        if [self.sun, self.studio, self.hdr].count(None) != 2:
            raise ValueError("give one of sun, studio and hdr")
        if self.sun is None and (self.moon is not None or self.stars is not None):
            raise ValueError("moon and stars stand in the sky of a sun: give sun: {hour: 0}")
        return self

    @property
    def is_wide(self) -> bool:
        """Whether the key light is so wide that its shadows are soft, as a studio's always are."""
        return self.studio is not None


LIGHTS: dict[str, Light] = {name: Light.model_validate(name) for name in _PRESETS}


def light(word: str | Mapping[str, Any] | Light) -> Light:
    """Return the light that a word in a scene stands for, written out in full.

    Raises:
        ValueError: no preset has this name (the message holds the nearest one), or a
            value is out of range.
    """
    if isinstance(word, str):
        return LIGHTS[known_name(word, LIGHTS, "light")]
    return Light.model_validate(word)
