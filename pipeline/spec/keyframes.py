"""Keyframes: values at certain times, and how to go from one to the next (Sims, chapter 3.1.1)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal, Protocol, Self

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.values import Coordinate, Number, Words
from render.config.base import (
    EASE_DESCRIPTION,
    HELD_EASE_DESCRIPTION,
    TURN_DESCRIPTION,
    Ease,
)

__all__ = [
    "EASE_DESCRIPTION",
    "TURN_DESCRIPTION",
    "Ease",
    "Keyframe",
    "SmoothEase",
    "faults_of_order",
]

SmoothEase = Literal["spline", "linear", "in", "out", "in-out"]
"""The eases of what must not jump, such as joints."""

Time = Annotated[Number, Field(ge=0, le=1e6)]
Angle = Annotated[Number, Field(ge=-36_000, le=36_000)]
Factor = Annotated[Number, Field(gt=0, le=1000)]
Rate = Annotated[Number, Field(ge=-36_000, le=36_000)]
Place = tuple[Coordinate, Coordinate, Coordinate]
Turn = tuple[Angle, Angle, Angle]
Factors = tuple[Factor, Factor, Factor]
Rates = tuple[Rate, Rate, Rate]

VALUES = ("position", "rotation_deg", "scale")
"""What a keyframe may say: nine degrees of freedom."""


def _number_or_three(words: Any) -> str:
    return "three" if isinstance(words, list | tuple) else "one"


Scale = Annotated[
    Annotated[Factor, Tag("one")] | Annotated[Factors, Tag("three")],
    Discriminator(_number_or_three),
]


class Tangent(Words):
    """How fast a spline goes through a keyframe, where that is not left to the spline."""

    position: Rates | None = Field(None, description="[m/s].")
    rotation_deg: Rates | None = Field(None, description="Of each of the three angles [degrees/s].")
    scale: Rates | None = Field(None, description="[1/s].")


class Keyframe(Words):
    """Where a prop is at one time, relative to its parent or the world."""

    at: Time = Field(description="When [s].")
    position: Place | None = Field(None, description="Where its origin is, [x, y, z] [m].")
    rotation_deg: Turn | None = Field(
        None,
        description=f"How it is turned: {TURN_DESCRIPTION}. More than 360 is more than one turn.",
    )
    scale: Scale | None = Field(
        None,
        description="Factor on its own lengths, one or one for each of its axes; its children "
        "keep theirs.",
    )
    ease: Ease = Field("spline", description=HELD_EASE_DESCRIPTION)
    tangent: Tangent | None = Field(
        None,
        description="How fast a spline goes through here; found from the keys beside it "
        "if left out, 0 at the first and the last.",
    )

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        said = [word for word in VALUES if getattr(self, word) is not None]
        if not said:
            refuse([Fault((), "should say a position, a rotation_deg or a scale")])
        if self.tangent is not None:
            refuse(
                Fault(("tangent", word), f"needs the {word} that it goes through", at_key=True)
                for word in VALUES
                if getattr(self.tangent, word) is not None and word not in said
            )
        return self

    @property
    def factors(self) -> tuple[float, float, float] | None:
        """Its scale along each axis, if it says one."""
        if isinstance(self.scale, tuple):
            return self.scale
        return None if self.scale is None else (self.scale, self.scale, self.scale)


class Timed(Protocol):
    """Anything that stands at a time."""

    @property
    def at(self) -> float:
        """When [s]."""
        ...


class Eased(Timed, Protocol):
    """Anything that stands at a time, is come to and may say how fast it is gone through."""

    @property
    def ease(self) -> Ease:
        """How it is come to."""
        ...

    @property
    def tangent(self) -> object | None:
        """How fast it is gone through, if that is said."""
        ...


def faults_of_order(keys: Sequence[Timed], name: str) -> Iterator[Fault]:
    """Find keys that stand before the one that is written before them."""
    for i in range(1, len(keys)):
        if keys[i].at < keys[i - 1].at:
            message = f"comes before the one above it, at {keys[i - 1].at:g}; write them in order"
            yield Fault((name, i, "at"), message)


def faults_of_tangents(keys: Sequence[Eased], name: str) -> Iterator[Fault]:
    """Find tangents at keys that no spline goes through."""
    for i, key in enumerate(keys):
        after = keys[i + 1].ease if i + 1 < len(keys) else "hold"
        before = key.ease if i else "hold"
        if key.tangent is not None and "spline" not in (before, after):
            message = "only a spline has a tangent, and none comes here or leaves from here"
            yield Fault((name, i, "tangent"), message, at_key=True)
