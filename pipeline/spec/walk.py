"""Walk: gait, speed and path of a walking figure (Sims, chapters 9 and 10)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from pipeline.spec.model_base import (
    ConfigModel,
    Fault,
    Length,
    LengthOrZero,
    Name,
    Number,
    Phase,
    Point,
    Positive,
    fault_error,
    raise_faults,
)

STRIDE_TOLERANCE = 1e-6
"""Relative difference between stride and speed * cycle that is rounding."""


class GaitPhases(ConfigModel):
    """A gait written out: when each foot goes up and comes down within the cycle."""

    up: dict[Name, Phase] = Field(
        min_length=1, description="Foot-up phase by leg, 0 to 1 of the cycle."
    )
    down: dict[Name, Phase] = Field(
        min_length=1, description="Foot-down phase by leg, 0 to 1 of the cycle."
    )

    @model_validator(mode="after")
    def _same_legs(self) -> Self:
        lacking = [
            Fault((side,), f"lacks leg '{leg}', which {other} has", at_key=True)
            for side, other in (("up", "down"), ("down", "up"))
            for leg in getattr(self, other)
            if leg not in getattr(self, side)
        ]
        idle = [
            Fault(("down", leg), "must differ from the foot-up phase")
            for leg, phase in self.down.items()
            if self.up.get(leg) == phase
        ]
        raise_faults(lacking + idle)
        return self


AUTO: Literal["auto"] = "auto"
"""Name of the gait that changes with the speed, and of the speed that suits the gait."""

GaitName = Literal[
    "auto",
    "trot",
    "wave",
    "tripod",
    "ripple",
    "walk",
    "amble",
    "pace",
    "canter",
    "transverse gallop",
    "rotary gallop",
    "bound",
    "run",
    "hop",
    "skip",
]


LEG_REQUIREMENTS: Mapping[str, str] = {
    "tripod": "6 legs",
    "ripple": "more than 4 legs",
    "walk": "one pair of legs or two",
    "amble": "two pairs of legs",
    "pace": "two pairs of legs",
    "canter": "two pairs of legs",
    "transverse gallop": "two pairs of legs",
    "rotary gallop": "two pairs of legs",
    "bound": "two pairs of legs",
    "run": "one pair of legs",
    "hop": "one leg or one pair",
    "skip": "one pair of legs",
}
"""Legs that a gait needs; the others suit any legs."""


def _form_of_gait(value: Any) -> str | None:
    if isinstance(value, str):
        return "a gait by name"
    return "a gait written out" if isinstance(value, Mapping | GaitPhases) else None


Gait = Annotated[
    Annotated[GaitName, Tag("a gait by name")] | Annotated[GaitPhases, Tag("a gait written out")],
    Discriminator(_form_of_gait),
]


GAIT = (
    "A gait by name, or foot-up and foot-down phases. `auto` changes with the speed as that of "
    "animals does; `trot` and `wave` suit any legs; the others are for as many legs as the animals "
    "have that go so."
)


class Manner(ConfigModel):
    """Gait and posture of a walking figure; keys left out are chosen to suit its legs."""

    gait: Gait = Field(AUTO, description=GAIT)
    legs: Annotated[tuple[Name, ...], Field(min_length=1, max_length=1000)] | None = Field(
        None, description="The legs that carry it; the others are held up. All if left out."
    )
    duty: Annotated[Number, Field(ge=0.05, le=0.95)] | None = Field(
        None,
        description="Part of the cycle that each foot is down; its swing is lengthened or "
        "shortened around its middle. If left out it falls as speed rises, as that of animals "
        "does; with a `stride` or `cycle`, it is the gait's own.",
    )
    cycle: Annotated[Positive, Field(le=1000)] | None = Field(
        None, description="Duration of one gait cycle [s]."
    )
    speed: Annotated[
        Annotated[Positive, Field(le=1000)] | None,
        BeforeValidator(
            lambda speed: None if speed == AUTO else speed,
            json_schema_input_type=Annotated[Positive, Field(le=1000)] | Literal["auto"] | None,
        ),
    ] = Field(
        None,
        description="Speed of the body over the ground; if left out or `auto`, the one at which an "
        "animal of this size is comfortable in the gait [m/s].",
    )
    stride: Length | None = Field(
        None, description="Length of one gait cycle over the ground, speed * cycle [m]."
    )
    body_bob: LengthOrZero | None = Field(
        None, description="Amplitude of the vertical bob of the body within a cycle [m]."
    )
    body_height: Length | None = Field(None, description="Height of the body above the ground [m].")
    step_height: LengthOrZero | None = Field(
        None, description="How high a foot clears the ground between two footholds [m]."
    )
    swing: Literal["spline", "passive", "least-effort"] = Field(
        "spline",
        description="How feet swing from one foothold to the next: along a plain arch, as legs "
        "do that fall forward by themselves and are only placed at the end, or on the way that "
        "takes the joints the least work.",
    )

    @model_validator(mode="after")
    def _stride_agrees(self) -> Self:
        if self.cycle is None or self.speed is None or self.stride is None:
            return self
        product = self.speed * self.cycle
        if abs(self.stride - product) > STRIDE_TOLERANCE * max(self.stride, product):
            message = (
                f"stride = speed * cycle, but {self.speed:g} * {self.cycle:g} = {product:.9g}, "
                f"not {self.stride:g}; leave one of the three out, or take stride: {product:.9g}, "
                f"speed: {self.stride / self.cycle:.9g} or cycle: {self.stride / self.speed:.9g}"
            )
            raise fault_error(message, "stride")
        return self


class Walk(Manner):
    """Gait and path of a walking figure."""

    path: Annotated[tuple[Point, ...], Field(max_length=1000)] = Field(
        (),
        description="Waypoints [x, z] that it goes through, one after the other, from where it "
        "starts; without any it goes straight ahead [m].",
    )
    repeat: Literal["once", "loop", "back and forth"] = Field(
        "once",
        description="What comes after the last waypoint: it stops, goes to its start and on, or "
        "turns and comes back the same way.",
    )

    @model_validator(mode="after")
    def _path_leads_somewhere(self) -> Self:
        faults = [
            Fault(("path", i), "repeats the place before it; write another")
            for i in range(1, len(self.path))
            if self.path[i] == self.path[i - 1]
        ]
        if self.repeat != "once" and not self.path:
            faults.append(Fault(("repeat",), "needs a path that is repeated", at_key=True))
        raise_faults(faults)
        return self
