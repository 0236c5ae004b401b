"""Prop: a thing that moves only as its author says, by keyframes, on a parent, or in a hand."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.faults import fault
from pipeline.spec.keyframes import Time
from pipeline.spec.values import Length, LengthOrZero, Whole, Words


class BoxShape(Words):
    """A box about its middle."""

    shape: Literal["box"] = Field(description="A box.")
    size: tuple[Length, Length, Length] = Field(
        (0.3, 0.3, 0.3), description="Its extent along x, y and z [m]."
    )


class BallShape(Words):
    """A ball about its middle."""

    shape: Literal["ball"] = Field(description="A ball.")
    radius: Length = Field(0.2, description="Its radius [m].")


class CylinderShape(Words):
    """An upright cylinder about its middle."""

    shape: Literal["cylinder"] = Field(description="An upright cylinder.")
    radius: Length = Field(0.2, description="Its radius [m].")
    height: Length = Field(0.4, description="Its height [m].")


class ConeShape(Words):
    """An upright cone, or a part of one, about the middle of its height."""

    shape: Literal["cone"] = Field(description="An upright cone, or a part of one.")
    radius: Length = Field(0.2, description="Its radius below [m].")
    top: LengthOrZero = Field(0.0, description="Its radius above [m].")
    height: Length = Field(0.4, description="Its height [m].")


class GearShape(Words):
    """A gear wheel about its middle, its axis upright."""

    shape: Literal["gear"] = Field(description="A gear wheel, its axis upright.")
    teeth: Annotated[Whole, Field(ge=5, le=120)] = Field(12, description="How many teeth.")
    radius: Length = Field(
        0.2,
        description="Of its pitch circle [m]; two gears mesh at the sum of their radii, if these "
        "are as their teeth.",
    )
    height: Length = Field(0.05, description="Its thickness [m].")


Shape = Annotated[
    BoxShape | BallShape | CylinderShape | ConeShape | GearShape, Field(discriminator="shape")
]


class Hold(Words):
    """Somebody has the prop in a hand: it goes with that link, as it was when it was taken."""

    by: str = Field(
        min_length=1,
        max_length=200,
        description="Who holds it with what, such as arm.hand: a performer and a node of its "
        "drawing or a link.",
    )
    at: Time = Field(description="When it is taken [s].")
    until: Time | None = Field(
        None, description="When it is let go, and stays where it is [s]; never if left out."
    )

    @model_validator(mode="after")
    def _ends_later(self) -> Self:
        if self.until is not None and self.until <= self.at:
            raise fault(f"should be later than it is taken, at {self.at:g}", "until")
        return self
