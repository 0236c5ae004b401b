"""Keyframes of props and of poses: values at times, and their interpolation (Sims, ch. 3.1)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal, Protocol, Self

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.spec.model_base import (
    ConfigModel,
    Coordinate,
    Fault,
    Integer,
    Name,
    Number,
    Positive,
    raise_faults,
)
from render.config.base import EASE_DESCRIPTION, HELD_EASE_DESCRIPTION, TURN_DESCRIPTION, Ease

__all__ = [
    "EASE_DESCRIPTION",
    "TURN_DESCRIPTION",
    "Ease",
    "Keyframe",
    "SmoothEase",
    "faults_of_order",
]

SmoothEase = Literal["spline", "linear", "in", "out", "in-out"]
"""Eases without jumps, as joints need them."""

Time = Annotated[Number, Field(ge=0, le=1e6)]
Angle = Annotated[Number, Field(ge=-36_000, le=36_000)]
Factor = Annotated[Positive, Field(le=1000)]
Rate = Annotated[Number, Field(ge=-36_000, le=36_000)]
Place = tuple[Coordinate, Coordinate, Coordinate]
Turn = tuple[Angle, Angle, Angle]
Factors = tuple[Factor, Factor, Factor]
Rates = tuple[Rate, Rate, Rate]

VALUES = ("position", "rotation_deg", "scale")
"""Keys of a keyframe: nine degrees of freedom."""


def _number_or_three(value: Any) -> str:
    return "three" if isinstance(value, list | tuple) else "one"


Scale = Annotated[
    Annotated[Factor, Tag("one")] | Annotated[Factors, Tag("three")],
    Discriminator(_number_or_three),
]


class Tangent(ConfigModel):
    """Tangent of a spline at a keyframe."""

    position: Rates | None = Field(None, description="[m/s].")
    rotation_deg: Rates | None = Field(None, description="Of each of the three angles [degrees/s].")
    scale: Rates | None = Field(None, description="[1/s].")


class Keyframe(ConfigModel):
    """Pose of a prop at one time, relative to its parent or the world."""

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
        given = [key for key in VALUES if getattr(self, key) is not None]
        if not given:
            raise_faults([Fault((), "should say a position, a rotation_deg or a scale")])
        if self.tangent is not None:
            raise_faults(
                Fault(("tangent", key), f"needs the {key} of this keyframe", at_key=True)
                for key in VALUES
                if getattr(self.tangent, key) is not None and key not in given
            )
        return self

    @property
    def factors(self) -> tuple[float, float, float] | None:
        """Its scale along each axis, None if it has none."""
        if isinstance(self.scale, tuple):
            return self.scale
        return None if self.scale is None else (self.scale, self.scale, self.scale)


class Timed(Protocol):
    """A key at a time."""

    @property
    def at(self) -> float:
        """When [s]."""
        ...


class Eased(Timed, Protocol):
    """A key with its ease and tangent."""

    @property
    def ease(self) -> Ease:
        """Interpolation towards it."""
        ...

    @property
    def tangent(self) -> object | None:
        """Tangent of the spline there, None if chosen."""
        ...


def faults_of_order(keys: Sequence[Timed], name: str) -> Iterator[Fault]:
    """Find keys earlier than the key before them."""
    for i in range(1, len(keys)):
        if keys[i].at < keys[i - 1].at:
            message = f"comes before the one above it, at {keys[i - 1].at:g}; write them in order"
            yield Fault((name, i, "at"), message)


def faults_of_tangents(keys: Sequence[Eased], name: str) -> Iterator[Fault]:
    """Find tangents at keys without a spline."""
    for i, key in enumerate(keys):
        after = keys[i + 1].ease if i + 1 < len(keys) else "hold"
        before = key.ease if i else "hold"
        if key.tangent is not None and "spline" not in (before, after):
            message = "needs a spline before or after this key; remove this"
            yield Fault((name, i, "tangent"), message, at_key=True)


Frame = Literal["feet", "body", "world"]

GOALS = ("reach", "aim", "turn_deg")
"""Goals of the end of a limb, or of one of its nodes."""


class BodyKey(ConfigModel):
    """Displacement of the body from its walking or standing pose."""

    move: Place = Field(
        (0.0, 0.0, 0.0), description="Forward, up and to the right of its heading [m]."
    )
    turn_deg: Turn = Field(
        (0.0, 0.0, 0.0), description=f"About its forward x, up y and right z: {TURN_DESCRIPTION}."
    )


class PoseKey(ConfigModel):
    """Goals at one time; the motion between keys follows splines."""

    at: Time = Field(description="Time of the pose [s].")
    limb: Name | None = Field(
        None, description="The limb whose tip is asked for, such as arm_r1, l2 or head."
    )
    node: Name | None = Field(
        None, description="Instead of a limb: the node of its drawing that is asked for."
    )
    reach: Place | None = Field(None, description="Where the tip or node is to be [m].")
    aim: Place | None = Field(
        None, description="Where the link that ends there is to point, as a direction."
    )
    turn_deg: Turn | None = Field(
        None, description=f"How that link is turned from the way it was drawn: {TURN_DESCRIPTION}."
    )
    frame: Frame = Field(
        "feet",
        description="What reach, aim and turn_deg are relative to: feet (the ground below the "
        "body, x ahead, y up, z to the right), body, or world.",
    )
    priority: Annotated[Integer, Field(ge=1, le=9)] | None = Field(
        None,
        description="1 comes first; what comes later gets what the joints have left. 1 for "
        "limbs and nodes, 2 for joints, if left out.",
    )
    weight: Annotated[Positive, Field(le=1000)] = Field(
        1.0, description="Share in a compromise with what else has this priority."
    )
    avoid: tuple[Name, ...] | None = Field(
        None,
        description="What the links of the limb keep clear of as far as its goals let them: names "
        "of props that stand or move by keyframes, and ground; [] is nothing. If left out as for "
        "the keys before, and of the first all of them.",
    )
    dexterity: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.0,
        description="How much of the freedom that the goals leave keeps the limb able to move its "
        "tip in all directions, instead of near its own pose; as for the keys before if left out.",
    )
    joints: dict[Name, Number] | None = Field(
        None,
        min_length=1,
        description="Values by joint: elbow_r_deg turns the joint at the node elbow_r, "
        "hip_l_pitch_deg one of several there [degrees]; without _deg one that slides [m].",
    )
    body: BodyKey | None = Field(None, description="Where the body is to be.")
    release: Name | None = Field(
        None, description="A limb, node, joint or `body` that goes back to what it did by itself."
    )
    blend: Annotated[Number, Field(ge=0, le=1000)] = Field(
        0.5,
        description="How long the first key takes over from what was done before, ending at `at`, "
        "and how long a release takes, beginning there [s].",
    )
    ease: SmoothEase = Field("spline", description=f"{EASE_DESCRIPTION}.")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = []
        asked = [key for key in GOALS if getattr(self, key) is not None]
        named = [key for key in ("limb", "node") if getattr(self, key) is not None]
        if len(named) == 2:
            faults.append(Fault(("node",), "give either limb or node, not both", at_key=True))
        if asked and not named:
            faults.append(Fault((asked[0],), "needs limb or node", at_key=True))
        if named and not asked:
            faults.append(Fault((named[0],), f"needs a goal: {' or '.join(GOALS)}"))
        if self.aim is not None and self.turn_deg is not None:
            faults.append(Fault(("aim",), "give either aim or turn_deg, not both", at_key=True))
        if self.aim == (0.0, 0.0, 0.0):
            faults.append(Fault(("aim",), "has no direction; write one such as [0, -1, 0]"))
        if not (asked or named or self.joints or self.body or self.release):
            faults.append(Fault((), "should have limb, node, joints, body or release"))
        raise_faults(faults)
        return self
