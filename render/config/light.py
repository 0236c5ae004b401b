"""Light: a sun with its sky by day and night, a studio or a panorama; and lamps.

`render.lights.sun_position` computes where the sun is placed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from render.config.base import Color, Point, PresetModel, RenderConfig, Unit, known_name
from render.config.weather import Weather

_CLOUDS: dict[str, dict[str, Any]] = {
    "clear": {},
    "fair": {"cumulus": 0.34, "cirrus": 0.3},
    "cumulus": {"cumulus": 0.55, "cirrus": 0.1},
    "cirrus": {"cirrus": 0.7},
    "broken": {"cumulus": 0.85, "overcast": 0.1},
    "overcast": {"overcast": 1.0},
}


class Clouds(PresetModel):
    """Clouds of three kinds, 0 to 1 each."""

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = _CLOUDS

    cumulus: Unit = Field(0.0, description="Heaps with flat bases: 0.4 are a few, 1 hides most.")
    cirrus: Unit = Field(0.0, description="Thin veils of ice, high above.")
    overcast: Unit = Field(0.0, description="A grey layer; 1 hides sky and sun.")
    shadows: Unit = Field(
        0.55, description="Share of the key light that heaps keep from the ground below them."
    )

    @model_validator(mode="before")
    @classmethod
    def _of_number(cls, value: object) -> object:
        """Return the clouds of a number: heaps up to a half, and more and more of a grey layer."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            return value
        if not 0 <= value <= 1:
            raise ValueError(f"clouds are a name or a number from 0 to 1, not {value:g}")
        return {"cumulus": min(1.6 * value, 0.8), "overcast": max(2 * value - 1, 0.0)}

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Let the JSON schema accept a number, too."""
        found = super().__get_pydantic_json_schema__(schema, handler)
        number = {"type": "number", "minimum": 0, "maximum": 1}
        return {**found, "anyOf": [*found["anyOf"], number]}


class Sun(RenderConfig):
    """The sun, placed by hour, day and latitude, and the air that it shines through."""

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
        1.0, ge=0.5, le=20, description="Angular diameter of the sun; the real one has 0.53."
    )
    clouds: Clouds = Field(
        default_factory=lambda: Clouds.model_validate("fair"),
        description="A name, a number (0 is a clear sky, 1 an overcast one without sun) or values.",
    )


class Moon(RenderConfig):
    """The moon, which lights the night from a chosen direction."""

    heading_deg: float = Field(
        -55.0, ge=-360, le=360, description="Heading towards the moon; 0 is +X."
    )
    elevation_deg: float = Field(38.0, ge=2, le=90, description="Height above the horizon.")
    phase: Unit = Field(1.0, description="0 is new and gives no light, 1 is full.")
    softness_deg: float = Field(
        1.2, ge=0.5, le=20, description="Angular diameter; the real one has 0.52."
    )


class Studio(RenderConfig):
    """A key light, a fill light and a rim light, large and soft, in front of a backdrop."""

    heading_deg: float = Field(
        -50.0, ge=-360, le=360, description="Heading towards the key light; 0 is +X."
    )
    elevation_deg: float = Field(42.0, ge=0, le=90, description="Elevation of the key light.")
    softness_deg: float = Field(26.0, ge=4, le=120, description="Diameter of the key light.")
    fill: Unit = Field(0.3, description="Light from the side opposite the key light.")
    rim: Unit = Field(0.5, description="Light from behind, which outlines the edges.")
    backdrop: Color = Field((0.58, 0.6, 0.63), description="Colour of the backdrop.")


class Hdr(RenderConfig):
    """A panorama of all directions, which lights the scene."""

    file: Annotated[str, Field(min_length=1)] = Field(
        description="EXR or HDR file, twice as wide as high, beside the scene."
    )
    turn_deg: float = Field(0.0, ge=-360, le=360, description="Turns the panorama about +Y.")
    strength: float = Field(
        1.0, ge=0, le=1000, description="1 is exposed automatically, 2 is twice as bright."
    )


class Spot(RenderConfig):
    """The cone of a spotlight."""

    toward: Point = Field(description="Point that it shines at, in the frame of `at`.")
    angle_deg: float = Field(40.0, ge=1, le=170, description="Width of the cone.")
    softness: Unit = Field(0.3, description="Share of the cone that its soft edge takes up.")


class Lamp(RenderConfig):
    """A lamp: a small sphere that shines all around, or a spotlight."""

    at: Point = Field((0.0, 2.5, 0.0), description="Position in the frame of its parent [m].")
    parent: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        None, description="Part that carries it, such as walker.hand_r; the world if left out."
    )
    brightness: float = Field(
        4.0,
        ge=0,
        le=1e5,
        description="1 shows a grey card as middle grey one metre away, 4 two metres away.",
    )
    temperature_k: float = Field(
        2700.0, ge=1000, le=20000, description="Its colour: 1900 a candle, 2700 a bulb, 6500 white."
    )
    color: Color | None = Field(None, description="Its colour, instead of a temperature.")
    radius: Annotated[float, Field(ge=0, le=10)] | None = Field(
        None,
        description="Radius of the visible sphere, which softens shadows; 0.05 by default, "
        "0 is invisible.",
    )
    spot: Spot | None = Field(None, description="Makes it an invisible spotlight.")

    @model_validator(mode="after")
    def _check_spot(self) -> Self:
        if self.spot is not None and self.radius:
            raise ValueError("`radius` conflicts with `spot`; remove one")
        if self.spot is not None and self.spot.toward == self.at:
            raise ValueError("`spot.toward` equals `at`; move one of them")
        return self

    @property
    def visible_radius(self) -> float:
        """Radius of the visible sphere [m], 0 for an invisible lamp."""
        if self.spot is not None:
            return 0.0
        return 0.05 if self.radius is None else self.radius


_PRESETS: dict[str, dict[str, Any]] = {
    "day": {"sun": {"hour": 16.5, "turbidity": 2.5}},
    "noon": {"sun": {"hour": 12.5}},
    "golden hour": {"sun": {"hour": 18.6, "turbidity": 3.0, "softness_deg": 1.4}},
    "dawn": {"sun": {"hour": 3.95, "turbidity": 3.0}},
    "dusk": {"sun": {"hour": 20.2, "turbidity": 3.0}},
    "night": {"sun": {"hour": 0.0}, "moon": {}},
    "overcast": {"sun": {"hour": 13.0, "clouds": "overcast"}},
    "studio": {"studio": {}},
}
_ENVIRONMENTS = {"sun", "studio", "hdr"}


HAZES = {"none": 0.0, "light": 0.2, "hazy": 0.32, "mist": 0.5, "fog": 0.8}
"""Strengths of haze that have a word."""


def _haze_of_word(value: object) -> object:
    return HAZES[known_name(value, HAZES, "haze")] if isinstance(value, str) else value


Haze = Annotated[
    Unit,
    BeforeValidator(_haze_of_word, json_schema_input_type=Unit | Literal[tuple(HAZES)]),
]


class Light(PresetModel):
    """The light of a scene: a preset, a sun, a studio or a panorama; and lamps."""

    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = _PRESETS

    sun: Sun | None = Field(None, description="The sun and its sky; at night, with the moon.")
    studio: Studio | None = Field(None, description="A photographer's studio.")
    hdr: Hdr | None = Field(None, description="A panorama of a place.")
    moon: Moon | None = Field(None, description="The moon, visible while the sun is down.")
    stars: Unit | None = Field(None, description="Brightness of the stars; 0.5 by default.")
    haze: Haze | None = Field(
        None,
        description="Haze, 0 to 1 or a word: 0 is none, 1 fog; by weather and hour if left out.",
    )
    weather: Weather = Field(
        default_factory=lambda: Weather.model_validate("breeze"),
        description="Wind, rain and snow: a name or values.",
    )

    lamps: tuple[Lamp, ...] = Field(
        (), max_length=64, description="Lamps; without other keys of `light` it is night."
    )

    @model_validator(mode="before")
    @classmethod
    def _default_preset(cls, value: object) -> object:
        if not isinstance(value, Mapping) or value.get("preset") is not None:
            return value
        if value.keys() & _ENVIRONMENTS:
            return value
        # Moon, stars or lamps without a sky mean the night.
        dark = any(value.get(key) not in (None, (), []) for key in ("moon", "stars", "lamps"))
        return {**value, "preset": "night" if dark else "day"}

    @model_validator(mode="after")
    def _check_environment(self) -> Self:
        if [self.sun, self.studio, self.hdr].count(None) != 2:
            raise ValueError("give one of `sun`, `studio` and `hdr`")
        if self.sun is None and (self.moon is not None or self.stars is not None):
            raise ValueError("`moon` and `stars` need a sun; write `sun: {hour: 0}`")
        if self.sun is None and self.weather.falls:
            raise ValueError("rain and snow need a sky; write `sun: {hour: 13}`")
        if self.studio is not None and self.haze:
            raise ValueError("`haze` needs a sky; take it away from the studio")
        return self

    @property
    def cloud_shadows(self) -> float:
        """Share of the key light that is lost in the shadow of a cloud; 0 without such clouds."""
        if self.sun is None or self.sun.clouds.cumulus == 0.0:
            return 0.0
        return self.sun.clouds.shadows

    def without_cloud_shadows(self) -> Light:
        """Return the light with clouds that cast no shadows, as Mitsuba's own tracer has it."""
        if self.sun is None:
            return self
        clouds = self.sun.clouds.model_copy(update={"shadows": 0.0})
        return self.model_copy(update={"sun": self.sun.model_copy(update={"clouds": clouds})})

    @property
    def changes(self) -> bool:
        """Whether the light depends on the time, besides the places of its lamps."""
        return self._clouds_drift or self.weather.falls

    @property
    def _clouds_drift(self) -> bool:
        clouds = None if self.sun is None else self.sun.clouds
        return clouds is not None and clouds.cumulus > 0.0 and self.weather.wind > 0.0

    @property
    def is_wide(self) -> bool:
        """Whether the key light casts soft shadows, as a studio's always does."""
        return self.studio is not None


LIGHTS: dict[str, Light] = {name: Light.model_validate(name) for name in _PRESETS}


def light(value: str | Mapping[str, Any] | Light) -> Light:
    """Return the light of a value in a scene, written out in full.

    Raises:
        ValueError: no preset has this name (the message holds the nearest one), or a
            value is out of range.
    """
    if isinstance(value, str):
        return LIGHTS[known_name(value, LIGHTS, "light")]
    return Light.model_validate(value)
