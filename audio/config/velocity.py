"""Configuration of velocities: curves from the strength of an event."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from audio.config import AudioConfig

DEFAULT_SLOWEST, DEFAULT_FASTEST = 0.05, 3.0
"""Speeds between which a linear or power curve runs by default [m/s]."""

_KEYS_OF_CURVE = {
    "physical": {"exponent", "slowest", "fastest"},
    "linear": {"slowest", "fastest", "softest", "loudest", "distance"},
    "power": {"exponent", "slowest", "fastest", "softest", "loudest", "distance"},
    "fixed": {"loudest", "distance"},
}


class Velocity(AudioConfig):
    """Curve from the strength of an event to the MIDI velocity of its note."""

    curve: Literal["physical", "linear", "power", "fixed"] = Field(
        "physical",
        description="'physical' follows speed, mass and distance; 'linear' and 'power' go from "
        "softest to loudest as the speed goes from slowest to fastest; 'fixed' is always loudest.",
    )
    exponent: float | None = Field(
        None,
        gt=0,
        le=4,
        description="Exponent of the speed: for physical that of the amplitude, 0.7 by default; "
        "for power that of the velocity, 0.5 by default.",
    )
    slowest: float | None = Field(
        None, gt=0, le=1000, description="Lower speeds are raised to this [m/s]."
    )
    fastest: float | None = Field(
        None, gt=0, le=1000, description="Higher speeds are lowered to this [m/s]."
    )
    softest: int = Field(20, ge=1, le=127, description="Velocity at the slowest, 1 to 127.")
    loudest: int = Field(112, ge=1, le=127, description="Velocity at the fastest, 1 to 127.")
    distance: bool = Field(
        True,
        description="Whether linear, power and fixed velocities hold at 4 m and are softer "
        "farther away; False to make them independent of distance.",
    )

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        fields = type(self).model_fields
        # A file that spells out the defaults in full is valid.
        unused = sorted(
            key
            for key in self.model_fields_set - _KEYS_OF_CURVE[self.curve] - {"curve"}
            if getattr(self, key) != fields[key].default
        )
        if unused:
            keys = ", ".join(sorted(_KEYS_OF_CURVE[self.curve]))
            raise ValueError(f"the curve {self.curve!r} has no {unused[0]!r}; it has {keys}")
        if self.curve in ("linear", "power"):
            slowest, fastest = self.slowest or DEFAULT_SLOWEST, self.fastest or DEFAULT_FASTEST
        else:
            slowest, fastest = self.slowest or 0.0, self.fastest or 1000.0
        if slowest >= fastest:
            raise ValueError(f"slowest, {slowest:g} m/s, is to be below fastest, {fastest:g} m/s")
        return self


def _expand_velocity(value: Any) -> Any:
    """Expand 90 to a fixed velocity of 90."""
    if isinstance(value, int) and not isinstance(value, bool):
        return {"curve": "fixed", "loudest": value}
    return value


VelocityOrNumber = Annotated[
    Velocity,
    BeforeValidator(
        _expand_velocity,
        json_schema_input_type=Annotated[int, Field(ge=1, le=127)] | Velocity,
    ),
]
