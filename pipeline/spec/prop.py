"""Prop: a thing moved by keyframes, velocity, force, a parent, hands or gravity (Sims, ch. 3.1)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self, TypeGuard

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.spec.body import HOLLOW, faults_of_hollow
from pipeline.spec.hold import Hold, faults_of_holds
from pipeline.spec.keyframes import Keyframe, Rates, Time, Turn, faults_of_order, faults_of_tangents
from pipeline.spec.model_base import (
    ConfigModel,
    Fault,
    Integer,
    Length,
    LengthOrZero,
    Number,
    Positive,
    raise_faults,
)
from pipeline.spec.performer import MAX_KEYFRAMES, At, Performer, Velocity
from render.config.base import EASE_DESCRIPTION, TURN_DESCRIPTION, Ease


class BoxShape(ConfigModel):
    """A box about its middle."""

    shape: Literal["box"] = Field(description="A box.")
    size: tuple[Length, Length, Length] = Field(
        (0.3, 0.3, 0.3), description="Its extent along x, y and z [m]."
    )
    hollow: Length | None = Field(None, description=HOLLOW)

    @model_validator(mode="after")
    def _check_wall(self) -> Self:
        raise_faults(faults_of_hollow(self.hollow, min(self.size)))
        return self


class BallShape(ConfigModel):
    """A ball about its middle."""

    shape: Literal["ball"] = Field(description="A ball.")
    radius: Length = Field(0.2, description="Its radius [m].")
    hollow: Length | None = Field(None, description=HOLLOW)

    @model_validator(mode="after")
    def _check_wall(self) -> Self:
        raise_faults(faults_of_hollow(self.hollow, 2.0 * self.radius))
        return self


class CylinderShape(ConfigModel):
    """An upright cylinder about its middle."""

    shape: Literal["cylinder"] = Field(description="An upright cylinder.")
    radius: Length = Field(0.2, description="Its radius [m].")
    height: Length = Field(0.4, description="Its height [m].")
    hollow: Length | None = Field(None, description=HOLLOW)

    @model_validator(mode="after")
    def _check_wall(self) -> Self:
        raise_faults(faults_of_hollow(self.hollow, min(2.0 * self.radius, self.height)))
        return self


class ConeShape(ConfigModel):
    """An upright cone, or a part of one, about the middle of its height."""

    shape: Literal["cone"] = Field(description="An upright cone, or a part of one.")
    radius: Length = Field(0.2, description="Its radius below [m].")
    top: LengthOrZero = Field(0.0, description="Its radius above [m].")
    height: Length = Field(0.4, description="Its height [m].")


class GearShape(ConfigModel):
    """A gear wheel about its middle, its axis upright."""

    shape: Literal["gear"] = Field(description="A gear wheel, its axis upright.")
    teeth: Annotated[Integer, Field(ge=5, le=120)] = Field(12, description="How many teeth.")
    radius: Length = Field(
        0.2,
        description="Of its pitch circle [m]; two gears mesh at the sum of their radii, if these "
        "are as their teeth.",
    )
    height: Length = Field(0.05, description="Its thickness [m].")


Shape = Annotated[
    BoxShape | BallShape | CylinderShape | ConeShape | GearShape, Field(discriminator="shape")
]


class PropHold(Hold):
    """Somebody has the prop in a hand for a while."""

    then: Literal["stay", "fall"] = Field(
        "stay", description="What it does when it is released: stay where it is, or fall."
    )


Push = Annotated[Number, Field(ge=-1e9, le=1e9)]
Pushes = tuple[Push, Push, Push]

DRIVEN_EASE = f"{EASE_DESCRIPTION}, hold keeps the value before until then."


class VelocityKey(ConfigModel):
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
            raise_faults([Fault((), "should say a velocity as linear, a spin_deg, or both")])
        return self


def _velocity_form(value: Any) -> str:
    if isinstance(value, list | tuple) and value and not isinstance(value[0], int | float):
        return "keys"
    return "one"


PropVelocity = Annotated[
    Annotated[Velocity, Tag("one")]
    | Annotated[
        tuple[VelocityKey, ...], Field(min_length=1, max_length=MAX_KEYFRAMES), Tag("keys")
    ],
    Discriminator(_velocity_form),
]
"""One velocity [m/s], or velocities at certain times."""


class ForceKey(ConfigModel):
    """What pushes and turns a prop at one time."""

    at: Time = Field(description="When [s].")
    force: Pushes | None = Field(None, description="At its middle, [x, y, z] [N].")
    torque: Pushes | None = Field(None, description="About x, y and z [N m].")
    ease: Ease = Field("linear", description=DRIVEN_EASE)

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.force is None and self.torque is None:
            raise_faults([Fault((), "should say a force, a torque, or both")])
        return self


class ForceMotion(ConfigModel):
    """Forces on a prop, which moves by its mass and collides with nothing."""

    force: Pushes | None = Field(None, description="At its middle, all the time [N].")
    torque: Pushes | None = Field(None, description="About x, y and z, all the time [N m].")
    keys: Annotated[tuple[ForceKey, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
        (), description="Instead: forces and torques at certain times."
    )
    mass: Annotated[Positive, Field(le=1e9)] | None = Field(
        None, description="[kg]; by its shape and density if left out."
    )
    density: Annotated[Positive, Field(le=30_000)] = Field(600.0, description="[kg/m³].")
    gravity: bool = Field(False, description="Whether its weight pulls it down as well.")
    drag: Annotated[Number, Field(ge=0, le=1e6)] = Field(
        0.0, description="Force that holds it back, for each metre a second [N s/m]."
    )
    turning_drag: Annotated[Number, Field(ge=0, le=1e6)] = Field(
        0.0, description="Torque that holds it back, for each radian a second [N m s]."
    )
    velocity: Velocity = Field((0.0, 0.0, 0.0), description="At the start [m/s].")
    spin_deg: Rates = Field((0.0, 0.0, 0.0), description="At the start [degrees/s].")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        raise_faults(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        yield from faults_of_order(self.keys, "keys")
        for key in ("force", "torque"):
            if self.keys and getattr(self, key) is not None:
                yield Fault((key,), "conflicts with keys; write it there", at_key=True)


def _keyed(velocity: PropVelocity | None) -> TypeGuard[tuple[VelocityKey, ...]]:
    return velocity is not None and isinstance(velocity[0], VelocityKey)


class Prop(Performer):
    """A thing that moves as its keys say, until hands take it or it falls."""

    prop: Shape = Field(description="Its shape.")
    at: At = Field(
        (0.0, 0.0),
        description="Where its middle is, [x, y, z]; [x, z] puts it on the ground, or on the "
        "origin of its parent [m].",
    )
    rotation_deg: Turn = Field(
        (0.0, 0.0, 0.0), description=f"How it is turned, before its heading: {TURN_DESCRIPTION}."
    )
    keyframes: Annotated[tuple[Keyframe, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
        (),
        description="Where it is at certain times; they replace at, rotation_deg and heading_deg.",
    )
    repeat: bool = Field(
        False,
        description="Whether the keyframes begin again when the last is reached, which should "
        "then be as the first; a rotation may be whole turns on.",
    )
    velocity: PropVelocity | None = Field(
        None,
        description="Velocity from its position at the start, [x, y, z], or a list of "
        "velocities at certain times; relative to its parent or the world [m/s].",
    )
    spin_deg: Rates | None = Field(
        None,
        description="How it turns all the time, about x, y and z of its parent or the world "
        "[degrees/s].",
    )
    force: ForceMotion | None = Field(
        None, description="What pushes and turns it, as its mass lets it."
    )
    held: Annotated[tuple[PropHold, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
        (), description="Hands that hold it, and when; its own motion ends with the first."
    )
    falls: Time | None = Field(
        None,
        description="From then on it falls freely, with the velocity that it has, and collides "
        "with the terrain, bodies and props [s].",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = [
            *faults_of_order(self.keyframes, "keyframes"),
            *faults_of_tangents(self.keyframes, "keyframes"),
            *self._faults_of_moving(),
            *faults_of_holds(self.held),
            *self._faults_of_falling(),
        ]
        raise_faults(faults)
        return self

    def _faults_of_moving(self) -> Iterator[Fault]:
        ways = [key for key in ("keyframes", "velocity", "force") if getattr(self, key)]
        for key in ways[1:]:
            message = f"conflicts with {ways[0]}; remove one"
            yield Fault((key,), message, at_key=True)
        if self.repeat and not (self.keyframes and self.keyframes[-1].at > self.keyframes[0].at):
            yield Fault(("repeat",), "needs two keyframes at different times", at_key=True)
        if self.spin_deg is not None and ways not in ([], ["velocity"]):
            message = f"conflicts with {ways[0]}; write the rotation there"
            yield Fault(("spin_deg",), message, at_key=True)
        elif self.spin_deg is not None and _keyed(self.velocity):
            message = "conflicts with the keys of velocity; write it there"
            yield Fault(("spin_deg",), message, at_key=True)
        if _keyed(self.velocity):
            yield from faults_of_order(self.velocity, "velocity")

    def _faults_of_falling(self) -> Iterator[Fault]:
        if not self.is_scaled:
            return
        message = "conflicts with the scale of keyframes; a thing that falls has one size"
        if self.falls is not None:
            yield Fault(("falls",), message, at_key=True)
        for i, hold in enumerate(self.held):
            if hold.then == "fall":
                yield Fault(("held", i, "then"), message)

    @property
    def is_scaled(self) -> bool:
        """Whether keyframes change its size."""
        return any(key.scale is not None for key in self.keyframes)

    @property
    def may_fall(self) -> bool:
        """Whether it falls at some time as the scene says."""
        return self.falls is not None or any(hold.then == "fall" for hold in self.held)

    @property
    def kind_name(self) -> str:
        """Name of a member that is given none."""
        return self.prop.shape
