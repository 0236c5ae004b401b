"""Driving: props that are moved by velocity or by force (Sims, chapters 3.1.2 and 3.1.3)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Self

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.keyframes import Rates, Time, faults_of_order
from pipeline.spec.values import Number, Words
from render.config.base import EASE_DESCRIPTION, Ease

Speed = Annotated[Number, Field(ge=-1000, le=1000)]
Velocity = tuple[Speed, Speed, Speed]

Push = Annotated[Number, Field(ge=-1e9, le=1e9)]
Pushes = tuple[Push, Push, Push]

MOST_KEYS = 10_000
"""Keys of one motion."""

DRIVEN_EASE = f"{EASE_DESCRIPTION}, hold keeps the value before until then."


class VelocityKey(Words):
    """How fast a prop goes and turns at one time."""

    at: Time = Field(description="When [s].")
    linear: Velocity | None = Field(None, description="Its velocity [x, y, z] [m/s].")
    spin_deg: Rates | None = Field(
        None, description="How it turns, about x, y and z of its parent or the world [degrees/s]."
    )
    ease: Ease = Field("linear", description=DRIVEN_EASE)

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.linear is None and self.spin_deg is None:
            refuse([Fault((), "should say a velocity as linear, a spin_deg, or both")])
        return self


def _form(words: Any) -> str:
    if isinstance(words, list | tuple) and words and not isinstance(words[0], int | float):
        return "keys"
    return "one"


VelocityWords = Annotated[
    Annotated[Velocity, Tag("one")]
    | Annotated[tuple[VelocityKey, ...], Field(min_length=1, max_length=MOST_KEYS), Tag("keys")],
    Discriminator(_form),
]
"""One velocity [m/s], or velocities at certain times."""


class ForceKey(Words):
    """What pushes and turns a prop at one time."""

    at: Time = Field(description="When [s].")
    force: Pushes | None = Field(None, description="At its middle, [x, y, z] [N].")
    torque: Pushes | None = Field(None, description="About x, y and z [N m].")
    ease: Ease = Field("linear", description=DRIVEN_EASE)

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.force is None and self.torque is None:
            refuse([Fault((), "should say a force, a torque, or both")])
        return self


class ForceWords(Words):
    """What pushes a prop: it meets nothing, and goes as its mass lets it."""

    force: Pushes | None = Field(None, description="At its middle, all the time [N].")
    torque: Pushes | None = Field(None, description="About x, y and z, all the time [N m].")
    keys: Annotated[tuple[ForceKey, ...], Field(max_length=MOST_KEYS)] = Field(
        (), description="Instead: forces and torques at certain times."
    )
    mass: Annotated[Number, Field(gt=0, le=1e9)] | None = Field(
        None, description="[kg]; by its shape and density if left out."
    )
    density: Annotated[Number, Field(gt=0, le=30_000)] = Field(600.0, description="[kg/m³].")
    gravity: bool = Field(False, description="Whether its weight pulls it down as well.")
    drag: Annotated[Number, Field(ge=0, le=1e6)] = Field(
        0.0, description="Force that holds it back, for each metre a second [N s/m]."
    )
    turning_drag: Annotated[Number, Field(ge=0, le=1e6)] = Field(
        0.0, description="Torque that holds it back, for each radian a second [N m s]."
    )
    velocity: Velocity = Field((0.0, 0.0, 0.0), description="At the begin [m/s].")
    spin_deg: Rates = Field((0.0, 0.0, 0.0), description="At the begin [degrees/s].")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        yield from faults_of_order(self.keys, "keys")
        for word in ("force", "torque"):
            if self.keys and getattr(self, word) is not None:
                yield Fault((word,), "give it in the keys, or take the keys away", at_key=True)
