"""Dancer: a simulated torso on legs that stand still, what it dances and what moves it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.spec.dance import Controller, Seconds
from pipeline.spec.faults import Fault, refuse
from pipeline.spec.values import Name, Number, Whole, Words

Tempo = Annotated[Number, Field(ge=10, le=480)]
Factor = Annotated[Number, Field(ge=0.05, le=20)]


class Build(Words):
    """How a dancer is made."""

    build: Literal["adult", "child"] = Field("adult", description="adult or child.")
    height: Annotated[Number, Field(ge=0.6, le=3.0)] | None = Field(
        None, description="How tall it is; as its build has it [m]."
    )
    mass: Annotated[Number, Field(ge=5, le=500)] | None = Field(
        None, description="What it weighs; as its height and build have it [kg]."
    )


def _build_form(words: object) -> str:
    return "a word" if isinstance(words, str) else "Build"


BuildOrName = Annotated[
    Annotated[Literal["torso", "adult", "child"], Tag("a word")] | Annotated[Build, Tag("Build")],
    Discriminator(_build_form),
]


class Arms(Words):
    """A controller for each arm."""

    r: Controller = Field("joint-torque", description="Of the right arm.")
    l: Controller = Field("joint-torque", description="Of the left arm.")  # noqa: E741 - the side


def _controller_form(words: object) -> str:
    return "Arms" if isinstance(words, Mapping | Arms) else "a word"


Controllers = Annotated[
    Annotated[Controller, Tag("a word")] | Annotated[Arms, Tag("Arms")],
    Discriminator(_controller_form),
]


class Gains(Words):
    """How hard controllers work, as factors on what suits a person of this size."""

    stiffness: Factor = Field(1.0, description="Of the servos, on errors of angles.")
    damping: Factor = Field(1.0, description="Of the servos, on errors of their speeds.")
    drag: Factor = Field(1.0, description="Of the fields: c, on errors of the hand's velocity.")
    rate: Factor = Field(
        1.0, description="Of the fields: how fast a hand goes by how far it is from their point."
    )


def _durations_form(words: object) -> str:
    if isinstance(words, str):
        return "a name"
    return "times" if isinstance(words, list | tuple) else "a time"


Durations = Annotated[
    Annotated[Name, Tag("a name")]
    | Annotated[Seconds, Tag("a time")]
    | Annotated[tuple[Seconds | None, ...], Tag("times")],
    Discriminator(_durations_form),
]


class DancerWords(Words):
    """What a dancer does and how; all but the block that says that it is one."""

    dance: Name = Field(
        "macarena",
        description="What it dances: from this file, from a file of that name beside it or in "
        "dances/ beside it, or from the shipped library.",
    )
    controller: Controllers = Field(
        "joint-torque",
        description="What moves its arms: joint-torque, force-field, or one for each arm, "
        "{r: force-field, l: joint-torque}.",
    )
    tempo_bpm: Tempo | None = Field(
        None, description="Beats a minute; as the dance has it. Hands arrive on the beats."
    )
    durations: Durations | None = Field(
        None,
        description="How long each subtask takes, one after the other without a beat: seconds for "
        "all, a list, or the name of times that the dance has, such as human. With tempo_bpm, how "
        "long hands are on their way to the beat.",
    )
    bars: Annotated[Whole, Field(ge=1, le=100_000)] | None = Field(
        None, description="How often it dances it; until the end of the film if left out."
    )
    start: Annotated[Number, Field(ge=0, le=1e6)] = Field(
        0.5, description="When the first beat is [s]."
    )
    beat: Annotated[Number, Field(ge=1, le=1e6)] | None = Field(
        None,
        description="The beat of the score, from 1, that its first beat falls on, instead of "
        "start: it is then locked to the score, and has the tempo of sound.tempo_bpm, or one that "
        "goes into it or that it goes into.",
    )
    sway_deg: Annotated[Number, Field(ge=0, le=15)] = Field(
        0.0, description="How far its waist sways to and fro with the beat [degrees]."
    )
    gaze: bool = Field(True, description="Whether its head turns to where its hand goes.")
    combine: Literal["sum", "winner"] = Field(
        "sum",
        description="How fields that act at once combine: their weighted sum, or the strongest.",
    )
    compensate_gravity: bool = Field(
        True,
        description="Whether the weight of the arms is held up; a field is zero at its point, "
        "where arms would sag without it.",
    )
    gains: Gains = Field(Gains(), description="How hard the controllers work.")
    steps_a_second: Annotated[Whole, Field(ge=240, le=10_000)] = Field(
        1000, description="Steps of its dynamics a second, at least."
    )

    @model_validator(mode="after")
    def _fits_by_itself(self) -> Self:
        # A scene that is written out in full has the ordinary start as well.
        if self.beat is not None and self.start != type(self).model_fields["start"].default:
            message = "beat says when it begins; take one of the two away"
            refuse([Fault(("start",), message, at_key=True)])
        if self.combine == "winner" and self.controller == "joint-torque":
            refuse([Fault(("combine",), "joint torques are no fields; take it away", at_key=True)])
        return self
