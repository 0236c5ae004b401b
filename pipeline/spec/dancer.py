"""Dancer: a simulated torso on planted feet, what it dances and what moves it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from audio.config.sound import Sound
from pipeline.spec.costume import Costume, HairLook
from pipeline.spec.dance import ARM_JOINTS, TRUNK_JOINTS, Controller, Seconds
from pipeline.spec.keyframes import PoseKey
from pipeline.spec.model_base import (
    ConfigModel,
    Coordinate,
    DanceName,
    Fault,
    Integer,
    Name,
    Number,
    PathSegment,
    raise_faults,
)
from pipeline.spec.performer import MAX_KEYFRAMES, Performer
from pipeline.spec.script import Instruction, Perform
from pipeline.spec.suggestions import hint

Tempo = Annotated[Number, Field(ge=10, le=480)]
Factor = Annotated[Number, Field(ge=0.05, le=20)]


class Build(ConfigModel):
    """How a dancer is made."""

    build: Literal["adult", "child"] = Field("adult", description="adult or child.")
    height: Annotated[Number, Field(ge=0.6, le=3.0)] | None = Field(
        None, description="How tall it is; as its build has it [m]."
    )
    mass: Annotated[Number, Field(ge=5, le=500)] | None = Field(
        None, description="What it weighs; as its height and build have it [kg]."
    )


def _build_form(value: object) -> str:
    return "a word" if isinstance(value, str) else "Build"


BuildOrName = Annotated[
    Annotated[Literal["torso", "adult", "child"], Tag("a word")] | Annotated[Build, Tag("Build")],
    Discriminator(_build_form),
]


class Arms(ConfigModel):
    """A controller for each arm."""

    r: Controller = Field("joint-torque", description="Of the right arm.")
    l: Controller = Field("joint-torque", description="Of the left arm.")  # noqa: E741 - the side


def _controller_form(value: object) -> str:
    return "Arms" if isinstance(value, Mapping | Arms) else "a word"


Controllers = Annotated[
    Annotated[Controller, Tag("a word")] | Annotated[Arms, Tag("Arms")],
    Discriminator(_controller_form),
]


class Gains(ConfigModel):
    """How hard controllers work, as factors on what suits a person of this size."""

    stiffness: Factor = Field(1.0, description="Of the servos, on errors of angles.")
    damping: Factor = Field(1.0, description="Of the servos, on errors of their speeds.")
    drag: Factor = Field(1.0, description="Of the fields: c, on errors of the hand's velocity.")
    rate: Factor = Field(
        1.0, description="Of the fields: speed of a hand by its distance from their point."
    )


def _durations_form(value: object) -> str:
    if isinstance(value, str):
        return "a name"
    return "times" if isinstance(value, list | tuple) else "a time"


Durations = Annotated[
    Annotated[Name, Tag("a name")]
    | Annotated[Seconds, Tag("a time")]
    | Annotated[tuple[Seconds | None, ...], Tag("times")],
    Discriminator(_durations_form),
]


class DanceSettings(ConfigModel):
    """Dance, controllers and tempo of a dancer; all its keys but the block `dancer`."""

    dance: DanceName = Field(
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
    bars: Annotated[Integer, Field(ge=1, le=100_000)] | None = Field(
        None, description="How often it dances it; until the end of the film if left out."
    )
    start: Annotated[Number, Field(ge=0, le=1e6)] = Field(
        0.5, description="Time of the first beat [s]."
    )
    beat: Annotated[Number, Field(ge=1, le=1e6)] | None = Field(
        None,
        description="The beat of the score, from 1, that its first beat falls on, instead of "
        "start: it is then locked to the score, and has the tempo of sound.tempo_bpm, or one that "
        "goes into it or that it goes into.",
    )
    sway_deg: Annotated[Number, Field(ge=0, le=15)] = Field(
        0.0,
        description="How far its waist sways to and fro with the beat [degrees]; hips too.",
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
    steps_a_second: Annotated[Integer, Field(ge=240, le=10_000)] = Field(
        1000, description="Steps of its dynamics a second, at least."
    )

    @model_validator(mode="after")
    def _fits_by_itself(self) -> Self:
        # A scene that is written out in full has the ordinary start as well.
        if self.beat is not None and self.start != type(self).model_fields["start"].default:
            message = "conflicts with beat; remove one"
            raise_faults([Fault(("start",), message, at_key=True)])
        if self.combine == "winner" and self.controller == "joint-torque":
            raise_faults(
                [Fault(("combine",), "needs a force-field controller; remove this", at_key=True)]
            )
        return self


ARMS = {"arm_r": "r", "hand_r": "r", "arm_l": "l", "hand_l": "l"}
"""Sides of the limbs and nodes of a dancer that are posed."""

TRUNK = "trunk"
"""Name of waist and neck in a release."""

POSED_JOINTS = (
    *(f"{j.replace('_', f'_{side}_', 1)}_deg" for side in "rl" for j in ARM_JOINTS),
    *(f"{joint}_deg" for joint in TRUNK_JOINTS),
)
"""Joints of a dancer, as pose keys name them."""


def _faults_of_pose(keys: Sequence[PoseKey], hangs: bool) -> Iterator[Fault]:
    """Find limbs and joints that a dancer lacks, and goals that they cannot have.

    Args:
        keys: its pose.
        hangs: whether it has a parent.
    """
    for k, key in enumerate(keys):
        faults = [*_faults_of_limbs(key), *_faults_of_joints(key)]
        if key.frame == "world" and hangs:
            message = "conflicts with parent; write feet or body"
            faults.append(Fault(("frame",), message))
        yield from (fault.below("pose", k) for fault in faults)


def _faults_of_limbs(key: PoseKey) -> Iterator[Fault]:
    for name in ("aim", "turn_deg", "body", "priority", "weight", "ease"):
        # A scene that is written out in full has the defaults as well.
        if getattr(key, name) != PoseKey.model_fields[name].default:
            message = "a dancer's pose has reach, joints or release only; remove this"
            yield Fault((name,), message, at_key=True)
    for name in ("limb", "node"):
        limb = getattr(key, name)
        if limb is not None and limb not in ARMS:
            yield Fault((name,), f"only the arms of a dancer are posed, {hint(limb, ARMS)}")
    if key.release is None:
        return
    released = (*ARMS, TRUNK)
    if key.release not in released:
        message = f"nothing of a dancer is called '{key.release}', {hint(key.release, released)}"
        yield Fault(("release",), message)
    elif key.reach is not None or key.joints:
        message = "conflicts with reach and joints; write it in another key"
        yield Fault(("release",), message, at_key=True)


def _faults_of_joints(key: PoseKey) -> Iterator[Fault]:
    """Find unknown joints, and joints of the other arm than the one that reaches."""
    arm = ARMS.get(key.limb or key.node or "")
    for joint in key.joints or ():
        if joint not in POSED_JOINTS:
            message = f"no joint of a dancer is called so, {hint(joint, POSED_JOINTS)}"
            yield Fault(("joints", joint), message, at_key=True)
        elif arm is not None and side_of(joint) not in (arm, ""):
            message = "belongs to the other arm than the one that reaches; write a key of its own"
            yield Fault(("joints", joint), message, at_key=True)


def side_of(joint: str) -> str:
    """Return the side of a posed joint, "" for waist and neck."""
    parts = joint.split("_")
    return parts[1] if parts[1] in ("r", "l") else ""


class Dancer(Performer, DanceSettings):
    """A simulated torso that dances."""

    dancer: BuildOrName = Field(
        description="torso, adult or child; or how it is made, {build: adult, height: 1.8}."
    )
    costume: Costume | None = Field(
        None,
        description="What it wears; by the seed if left out, and all different while there are "
        "enough costumes.",
    )
    hair: HairLook | None = Field(
        None, description="Hair on its head; by its name and the seed if left out."
    )
    at: tuple[Coordinate, Coordinate] = Field(
        (0.0, 0.0), description="Where it stands, [x, z] on the ground [m]."
    )
    pose: Annotated[tuple[PoseKey, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
        (),
        description="Where hands and joints are to be at certain times, instead of dancing with "
        "that arm until it is released; waist and neck are released as trunk.",
    )

    @model_validator(mode="after")
    def _can_be_posed(self) -> Self:
        raise_faults([*_faults_of_pose(self.pose, self.parent is not None)])
        return self

    @property
    def kind_name(self) -> str:
        """Name of a member that is given none."""
        return "dancer"


TEMPO_TOLERANCE = 1e-9
"""Relative difference of two tempos' ratio from a whole number that is rounding."""


def with_score_times(member: Dancer, sound: Sound) -> Dancer:
    """Return a dancer with the tempo and the start that the score gives it.

    Args:
        member: the dancer; without `beat` it stays as it is.
        sound: sound of the scene.
    """
    if member.beat is None:
        return member
    start, _ = beat_at(member.beat, sound)
    return member.model_copy(
        update={"tempo_bpm": member.tempo_bpm or sound.beats_per_minute, "start": start}
    )


def beat_at(beat: float, sound: Sound) -> tuple[float, float]:
    """Return the time of a beat of the score, counted from 1, and the length of beats [s]."""
    length = 60.0 / sound.beats_per_minute
    return sound.beat_origin + (beat - 1.0) * length, length


def faults_of_beats(
    cast: Sequence[object],
    sound: Sound,
    instructions: Iterable[tuple[tuple[PathSegment, ...], Instruction]],
) -> Iterator[Fault]:
    """Find dancers whose tempo does not fit that of the score, and beats before the film."""
    for i, member in enumerate(cast):
        if not isinstance(member, Dancer) or member.beat is None:
            continue
        tempos: list[tuple[tuple[PathSegment, ...], float | None]] = [
            (("cast", i, "tempo_bpm"), member.tempo_bpm)
        ]
        for path, instruction in instructions:
            if isinstance(instruction.do, Perform) and instruction.who == member.name:
                tempos.append(((*path, "do", "tempo_bpm"), instruction.do.tempo_bpm))
        score = sound.beats_per_minute
        if any(change.tempo_bpm is not None for change in sound.tempo_map):
            message = "needs a score of one tempo; write start, or remove tempos of sound.tempo_map"
            yield Fault(("cast", i, "beat"), message, at_key=True)
        for place, own in tempos:
            if own is not None and not _is_multiple(own, score):
                message = (
                    f"{own:g} beats a minute do not fit beat {member.beat:g} of a score at "
                    f"{score:g}; remove this to dance at {score:g}, or write {0.5 * score:g} or "
                    f"{2 * score:g}"
                )
                yield Fault(place, message)
        start, _ = beat_at(member.beat, sound)
        if start < 0.0:
            message = f"beat {member.beat:g} of the score is at {start:.4g} s, before the film"
            yield Fault(("cast", i, "beat"), message)


def _is_multiple(tempo: float, other: float) -> bool:
    """Return whether beats of the slower tempo fall on beats of the faster."""
    ratio = max(tempo, other) / min(tempo, other)
    return math.isclose(ratio, round(ratio), rel_tol=TEMPO_TOLERANCE)
