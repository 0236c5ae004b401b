"""Dance: subtasks of hands in beats, for either controller.

Source: Matarić, Zordan and Mason 1998, chapter 4.

Each subtask is described once, in angles of joints where that is natural and by a place where
that is; both controllers read the same subtasks, as far as each can.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from pipeline.spec.model_base import (
    ConfigModel,
    Fault,
    Length,
    LengthOrZero,
    MaterialName,
    Name,
    Number,
    Positive,
    fault_error,
    raise_faults,
)
from pipeline.spec.suggestions import hint

BODY_PLACES = (
    *("shoulder_l", "shoulder_r", "head_back", "head_back_l", "head_back_r", "head_top"),
    *("nape", "chest", "belly"),
    *("ribs_l", "ribs_r", "low_ribs_l", "low_ribs_r", "hip_l", "hip_r"),
)
"""Places on the dancer's body that a hand can touch."""

ARM_JOINTS = (
    *("shoulder_flexion", "shoulder_abduction", "shoulder_rotation", "elbow_flexion"),
    *("wrist_pronation", "wrist_flexion", "wrist_deviation"),
)
"""Joints of the arm of a subtask."""

TRUNK_JOINTS = (
    *("waist_rotation", "waist_flexion", "waist_bend"),
    *("neck_rotation", "neck_flexion", "neck_bend"),
)

JOINT_KEYS = tuple(f"{joint}_deg" for joint in (*ARM_JOINTS, *TRUNK_JOINTS))

Angle = Annotated[Number, Field(ge=-200, le=200)]
Step = Annotated[Number, Field(ge=-3, le=3)]
Position = tuple[Step, Step, Step]
Beats = Annotated[Positive, Field(le=256)]
Seconds = Annotated[Number, Field(ge=0.05, le=60)]
Hand = Literal["r", "l"]
Controller = Literal["force-field", "joint-torque"]


def _known_joints(angles: dict[str, float]) -> dict[str, float]:
    for key in angles:
        if key not in JOINT_KEYS:
            raise fault_error(f"no joint is called so, {hint(key, JOINT_KEYS)}", key, at_key=True)
    return angles


Angles = Annotated[dict[str, Angle], AfterValidator(_known_joints)]


def _name_or_position(value: object) -> str:
    return "a name" if isinstance(value, str) else "a position"


Where = Annotated[
    Annotated[Name, Tag("a name")] | Annotated[Position, Tag("a position")],
    Discriminator(_name_or_position),
]
"""A place by its name, or [forward, up, right] of a person of 1.72 m, and in proportion [m]."""


class Drum(ConfigModel):
    """A round drum before the dancer, struck from above."""

    at: Position = Field(
        description="The middle of its top, [forward, up, right] of where the dancer stands [m]."
    )
    radius: Length = Field(0.15, description="Its radius [m].")
    height: Length = Field(0.2, description="Its height [m].")
    material: MaterialName = Field("leather", description="What it is made of, by name.")


class Subtask(ConfigModel):
    """A movement of one hand."""

    name: str = Field("", max_length=80, description="What it is called in reports.")
    hand: Hand = Field("r", description="Which hand does it: r or l.")
    touch: Name | None = Field(
        None, description="A place on one's own body, or a drum, that the hand comes to touch."
    )
    reach: Position | None = Field(
        None,
        description="Where the hand goes, [forward, up, right] of where a person of 1.72 m "
        "stands, and in proportion [m].",
    )
    trace: Annotated[tuple[Position, ...], Field(min_length=2, max_length=200)] | None = Field(
        None, description="Places that the hand goes through one after the other without a stop."
    )
    joints: Angles = Field(
        {},
        description="Angles of joints, such as elbow_flexion_deg; of the hand's own arm, the waist "
        "or the neck. Alone they are the goal; beside a place they say how the arm is held.",
    )
    via: Annotated[tuple[Where, ...], Field(max_length=50)] = Field(
        (), description="Places that the hand goes through on its way, by name or position."
    )
    lift: LengthOrZero = Field(
        0.0, description="How far it rises off what it touches before it comes down on it [m]."
    )
    beats: Beats = Field(1.0, description="How long it takes, in beats; the next follows it.")
    on: Annotated[tuple[Beats, ...], Field(min_length=1, max_length=500)] | None = Field(
        None,
        description="Beats of the bar, from 1, on which the hand arrives; `beats` is then the "
        "longest time of its way, and the order of the subtasks does not matter.",
    )
    controller: Controller | None = Field(
        None, description="Controller of this subtask; that of the dancer if left out."
    )

    @model_validator(mode="after")
    def _has_one_goal(self) -> Self:
        given = [key for key in ("touch", "reach", "trace") if getattr(self, key) is not None]
        faults = [
            Fault((key,), f"conflicts with {given[0]}; remove one", at_key=True)
            for key in given[1:]
        ]
        if not given and not self.joints:
            faults.append(Fault((), "has no goal; write touch, reach, trace or joints"))
        if self.lift and self.touch is None:
            faults.append(Fault(("lift",), "needs touch; remove this", at_key=True))
        raise_faults(faults)
        return self

    @property
    def is_of_joints(self) -> bool:
        """Whether its goal is said in angles."""
        return self.touch is None and self.reach is None and self.trace is None


class Dance(ConfigModel):
    """Subtasks in their order, repeated."""

    tempo_bpm: Annotated[Number, Field(ge=10, le=480)] = Field(
        100.0, description="Beats a minute, unless the dancer gives its own."
    )
    bar: Beats | None = Field(
        None, description="How many beats one time through it takes; as its subtasks need."
    )
    drums: dict[Name, Drum] = Field({}, description="What stands before the dancer, by name.")
    ready: dict[Hand, Position] = Field(
        {},
        description="Where hands are before the first beat, {r: [forward, up, right], l: [...]}; "
        "they hang if left out [m].",
    )
    subtasks: Annotated[tuple[Subtask, ...], Field(min_length=1, max_length=2000)] = Field(
        description="What hands do, in this order."
    )
    durations: dict[Name, tuple[Seconds | None, ...]] = Field(
        {},
        description="Times that somebody took over each subtask, by name [s]; null for what was "
        "not done.",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        raise_faults(
            [*self._faults_of_places(), *self._faults_of_beats(), *self._faults_of_durations()]
        )
        return self

    @property
    def length(self) -> float:
        """Beats of one time through."""
        if self.bar is not None:
            return self.bar
        own = sum(task.beats for task in self.subtasks if task.on is None)
        latest = max((beat for task in self.subtasks for beat in task.on or ()), default=0.0)
        return max(own, latest)

    def _faults_of_places(self) -> Iterator[Fault]:
        known = (*BODY_PLACES, *self.drums)
        for drum in self.drums:
            if drum in BODY_PLACES:
                message = f"'{drum}' is a place on the body; call it otherwise"
                yield Fault(("drums", drum), message, at_key=True)
        for i, task in enumerate(self.subtasks):
            named = [(("touch",), task.touch)]
            named += [(("via", k), place) for k, place in enumerate(task.via)]  # type: ignore[misc]
            for path, name in named:
                if isinstance(name, str) and name not in known:
                    message = f"no place is called '{name}', {hint(name, known)}"
                    yield Fault(("subtasks", i, *path), message)

    def _faults_of_beats(self) -> Iterator[Fault]:
        for i, task in enumerate(self.subtasks):
            for k, beat in enumerate(task.on or ()):
                if not 1.0 <= beat < self.length + 1.0:
                    message = f"the bar has beats 1 to {self.length:g}; {beat:g} is none of them"
                    yield Fault(("subtasks", i, "on", k), message)
        own = sum(task.beats for task in self.subtasks if task.on is None)
        if own > self.length + 1e-9:
            message = f"its subtasks take {own:g} beats, and a bar has {self.length:g}"
            yield Fault(("bar",), message)

    def _faults_of_durations(self) -> Iterator[Fault]:
        for name, times in self.durations.items():
            if len(times) != len(self.subtasks):
                message = f"has {len(times)} times for {len(self.subtasks)} subtasks"
                yield Fault(("durations", name), message)
