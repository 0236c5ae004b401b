"""Lamps: lights that stand in the scene or are carried through it."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from render.config.base import Color, Point, Unit, Words


class Spot(Words):
    """The cone of a lamp that shines one way."""

    toward: Point = Field(description="Point that it shines at, in the frame of the lamp's place.")
    angle_deg: float = Field(40.0, ge=1, le=170, description="Width of the cone.")
    softness: Unit = Field(0.3, description="How much of the cone its edge takes up.")


class Lamp(Words):
    """A lamp: a small ball that shines all around, or a spot."""

    at: Point = Field((0.0, 2.5, 0.0), description="Its place, in the frame of its parent [m].")
    parent: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        None, description="Who carries it, such as walker or walker.hand_r; the world if left out."
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
        description="Of the ball that is seen, which makes shadows soft; 0.05 unless said, "
        "0 is not seen.",
    )
    spot: Spot | None = Field(None, description="Lets it shine one way only; it is not seen then.")

    @model_validator(mode="after")
    def _shines(self) -> Self:
        if self.spot is not None and self.radius:
            raise ValueError("a spot has no radius; take radius or spot away")
        if self.spot is not None and self.spot.toward == self.at:
            raise ValueError("a spot cannot shine at its own place; move at or spot.toward")
        return self

    @property
    def ball(self) -> float:
        """Radius of what is seen of it [m], 0 for nothing."""
        if self.spot is not None:
            return 0.0
        return 0.05 if self.radius is None else self.radius
