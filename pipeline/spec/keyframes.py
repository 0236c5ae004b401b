"""Keyframes: values at certain times, and how to go from one to the next (Sims, chapter 3.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Literal, Protocol, Self

from pydantic import Field, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.values import Coordinate, Number, Words

Ease = Literal["spline", "linear", "in", "out", "in-out"]
"""How a value comes to a keyframe from the one before."""

EASE = (
    "How it comes here from the keyframe before: spline goes through without a halt, in starts "
    "from rest, out comes to rest, in-out does both, linear does neither."
)

Time = Annotated[Number, Field(ge=0, le=1e6)]
Angle = Annotated[Number, Field(ge=-36_000, le=36_000)]
Place = tuple[Coordinate, Coordinate, Coordinate]
Turn = tuple[Angle, Angle, Angle]

TURN = "about z, then x, then y, so that y turns it about the vertical [degrees]"
"""What the three numbers of every `turn_deg` and `rotation_deg` mean."""


class Keyframe(Words):
    """Where a prop is at one time, relative to its parent or the world."""

    at: Time = Field(description="When [s].")
    position: Place | None = Field(None, description="Where its origin is, [x, y, z] [m].")
    rotation_deg: Turn | None = Field(None, description=f"How it is turned: {TURN}.")
    ease: Ease = Field("spline", description=EASE)

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.position is None and self.rotation_deg is None:
            refuse([Fault((), "should say a position, a rotation_deg, or both")])
        return self


class Timed(Protocol):
    """Anything that stands at a time."""

    @property
    def at(self) -> float:
        """When [s]."""
        ...


def faults_of_order(keys: Sequence[Timed], name: str) -> Iterator[Fault]:
    """Find keys that stand before the one that is written before them."""
    for i in range(1, len(keys)):
        if keys[i].at < keys[i - 1].at:
            message = f"comes before the one above it, at {keys[i - 1].at:g}; write them in order"
            yield Fault((name, i, "at"), message)
