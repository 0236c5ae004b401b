"""Sound thresholds: what counts as a sound, for every cause (Sims 1987, ch. 13).

A lasting sound has two thresholds (hysteresis), one to start and a lower one to end, and two
times: its least duration, and the longest pause within it. A signal near a threshold then makes
one sound or none, never many.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from audio.acoustic_materials import FAMILIES
from audio.config.sound import Sound
from pipeline.spec.model_base import ConfigModel, Fault, Number, Positive, fault_error, raise_faults
from pipeline.spec.suggestions import hint

Speed = Annotated[Number, Field(ge=0, le=1000)]
Rate = Annotated[Positive, Field(le=100_000)]
Seconds = Annotated[Number, Field(ge=0, le=60)]
Pattern = Annotated[str, Field(min_length=1)]


def _known_families(factors: dict[str, float]) -> dict[str, float]:
    for name in factors:
        if name not in FAMILIES:
            raise fault_error(
                f"unknown kind of material, {hint(name, FAMILIES)}", name, at_key=True
            )
    return factors


Factors = Annotated[dict[str, Annotated[Positive, Field(le=1000)]], AfterValidator(_known_families)]


class Cause(ConfigModel):
    """Settings of every cause."""

    heard: bool = Field(True, description="False for no sounds of this cause.")
    who: Pattern = Field("*", description="Names of the performers; `*` stands for any letters.")


class ImpactCause(Cause):
    """A cause that is over at once."""

    above: Speed = Field(0.0, description="Least speed that is heard [m/s].")
    pause: Seconds = Field(
        0.0, description="The same two are not heard again sooner than this [s]."
    )


class SustainedCause(Cause):
    """A cause that lasts for a while."""

    least: Seconds = Field(0.1, description="Least duration that is heard [s].")
    pause: Seconds = Field(0.1, description="A shorter pause than this does not end it [s].")


class MotionCause(SustainedCause):
    """A cause that lasts as long as something is fast."""

    above: Speed = Field(description="Speed that begins it [m/s].")
    below: Speed | None = Field(
        None, description="Speed under which it ends; half of `above` if not given [m/s]."
    )

    @model_validator(mode="after")
    def _ends_below(self) -> Self:
        raise_faults(_faults_of_ends(self.ends, self.above, "below", "above"))
        return self

    @property
    def ends(self) -> float:
        """Speed under which it ends [m/s]."""
        return 0.5 * self.above if self.below is None else self.below


class JointMotionCause(SustainedCause):
    """A cause that lasts as long as a joint bends."""

    above_deg_s: Rate = Field(description="Rate of bending above which it begins [degrees/s].")
    below_deg_s: Rate | None = Field(
        None,
        description="Rate under which it ends; half of `above_deg_s` if not given [degrees/s].",
    )
    materials: Factors = Field(
        {"metal": 1.0, "plastic": 1.0, "rubber": 1.0},
        description="Kinds of materials whose joints are heard at all, each with a factor on both "
        "rates: with `chitin: 60` an insect's knees are heard where they bend very fast.",
    )

    @model_validator(mode="after")
    def _ends_below(self) -> Self:
        raise_faults(
            _faults_of_ends(self.ends_deg_s, self.above_deg_s, "below_deg_s", "above_deg_s")
        )
        return self

    @property
    def ends_deg_s(self) -> float:
        """Rate under which it ends [degrees/s]."""
        return 0.5 * self.above_deg_s if self.below_deg_s is None else self.below_deg_s


def _faults_of_ends(below: float, above: float, *keys: str) -> Sequence[Fault]:
    """Find an end threshold above the start threshold."""
    if below <= above:
        return ()
    message = f"should not be more than {keys[1]}, which is {above:g}; is {below:g}"
    return (Fault((keys[0],), message),)


class Footfall(ImpactCause):
    """Feet that come down."""

    above: Speed = Field(0.005, description="Least speed of approach that is heard [m/s].")


class Scuff(ImpactCause):
    """Feet that drag."""


class Collision(ImpactCause):
    """Bodies that strike the terrain or one another."""

    pause: Seconds = Field(
        0.04, description="The same two are not heard again sooner than this [s]."
    )


class Roll(MotionCause):
    """Balls that roll."""

    least: Seconds = Field(0.05, description="Least duration that is heard [s].")
    above: Speed = Field(0.1, description="Speed along the ground that begins it [m/s].")


class Slide(Roll):
    """Bodies that slide."""


class Squeak(JointMotionCause):
    """Joints that bend."""

    above_deg_s: Rate = Field(
        8.0, description="Rate of bending above which a joint squeaks [degrees/s]."
    )


class Squawk(JointMotionCause):
    """Joints that jerk; a joint that squawks does not squeak."""

    above_deg_s: Rate = Field(
        360.0, description="Rate of bending above which a joint squawks [degrees/s]."
    )
    materials: Factors = Field(
        {"metal": 1.0, "plastic": 1.0, "rubber": 1.0},
        description="Kinds of materials whose joints squawk, each with a factor on both rates.",
    )
    least: Seconds = Field(0.04, description="Least duration that is heard [s].")


class Swoosh(MotionCause):
    """Props and bodies that speed through the air."""

    above: Speed = Field(9.0, description="Speed through the air that begins it [m/s].")
    sizes_s: Speed = Field(
        8.0,
        description="Least speed, in its own lengths a second. For large bodies it raises "
        "`above` and `below`.",
    )


class Whistle(MotionCause):
    """Thin props and bodies that sing in the air."""

    above: Speed = Field(12.0, description="Speed through the air that begins it [m/s].")
    least_hz: Rate = Field(
        150.0,
        description="Least tone that is heard [Hz]: a fifth of the speed over the thickness.",
    )


class Boing(Cause):
    """Creatures that push themselves off the ground."""

    above: Speed = Field(1.2, description="Least speed upward of the body, at its greatest [m/s].")
    pause: Seconds = Field(0.2, description="None is heard again sooner than this [s].")


class Wings(MotionCause):
    """Flocks and swarms in flight."""

    above: Speed = Field(0.3, description="Mean speed of the members that begins it [m/s].")
    pause: Seconds = Field(0.3, description="A shorter pause than this does not end it [s].")


class NearCause(Cause):
    """A cause that is heard near the camera alone."""

    within: Annotated[Positive, Field(le=1000)] = Field(
        8.0, description="Distance from the camera beyond which it is not heard [m]."
    )


class Rustle(MotionCause, NearCause):
    """Clothes of limbs that move; heard only if it is asked for."""

    heard: bool = Field(False, description="True to hear clothes.")
    above: Speed = Field(
        0.5, description="Speed of the limbs against the trunk that begins it [m/s]."
    )
    pause: Seconds = Field(0.3, description="A shorter pause than this does not end it [s].")


class Breath(NearCause):
    """Creatures and people that breathe; heard only if it is asked for."""

    heard: bool = Field(False, description="True to hear breathing.")
    per_minute: Annotated[Positive, Field(le=600)] | None = Field(
        None, description="Breaths a minute at rest; chosen by mass if left out."
    )
    strides: Annotated[Number, Field(ge=0.25, le=100)] = Field(
        2.0, description="Cycles of the gait in one breath, where that is quicker than at rest."
    )


class VocalCause(ImpactCause):
    """A sound that a person makes."""


class Cry(VocalCause):
    """Cries of people, for pain or for fear."""

    above: Speed = Field(
        0.0,
        description="Least strength that is heard [m/s]: 1 is a whimper, 5 a scream.",
    )
    pause: Seconds = Field(0.8, description="The same one is not heard again sooner than this [s].")


class Hug(VocalCause):
    """Hugs, when the arms close around somebody."""

    above: Speed = Field(0.0, description="Least speed of the arms that is heard [m/s].")
    pause: Seconds = Field(0.8, description="The same one is not heard again sooner than this [s].")


class Laugh(VocalCause):
    """Laughs of people at play."""

    above: Speed = Field(0.0, description="Least strength that is heard [m/s]; that of most is 1.")
    pause: Seconds = Field(2.0, description="The same one is not heard again sooner than this [s].")


class Gasp(VocalCause):
    """Gasps of people who take fright."""

    above: Speed = Field(0.0, description="Least strength that is heard [m/s]: 1, and 2 in panic.")
    pause: Seconds = Field(0.8, description="The same one is not heard again sooner than this [s].")


class Call(Cause):
    """Creatures that call, each in the voice of its mood; heard only if it is asked for."""

    heard: bool = Field(False, description="True to hear calls.")
    every: Annotated[Positive, Field(le=3600)] = Field(
        6.0, description="Time from one call to the next, on average [s]."
    )


class Detect(ConfigModel):
    """Detection thresholds of each cause."""

    footfall: Footfall = Field(Footfall(), description="Thresholds of steps.")
    scuff: Scuff = Field(Scuff(), description="Thresholds of feet that drag.")
    collision: Collision = Field(Collision(), description="Thresholds of strikes.")
    roll: Roll = Field(Roll(), description="Thresholds of balls that roll.")
    slide: Slide = Field(Slide(), description="Thresholds of bodies that slide.")
    squeak: Squeak = Field(Squeak(), description="Thresholds of joints that bend.")
    squawk: Squawk = Field(Squawk(), description="Thresholds of joints that jerk.")
    swoosh: Swoosh = Field(Swoosh(), description="Thresholds of bodies that speed through the air.")
    whistle: Whistle = Field(
        Whistle(), description="Thresholds of thin bodies that sing in the air."
    )
    wings: Wings = Field(Wings(), description="Thresholds of flocks and swarms in flight.")
    rustle: Rustle = Field(Rustle(), description="Whether clothes are heard, and from where.")
    boing: Boing = Field(Boing(), description="Thresholds of push-offs.")
    breath: Breath = Field(Breath(), description="Whether breathing is heard.")
    cry: Cry = Field(Cry(), description="Thresholds of cries.")
    hug: Hug = Field(Hug(), description="Thresholds of hugs.")
    laugh: Laugh = Field(Laugh(), description="Thresholds of laughs.")
    gasp: Gasp = Field(Gasp(), description="Thresholds of gasps.")
    call: Call = Field(Call(), description="Whether creatures call, and how often.")


class SceneSound(Sound):
    """The sound of a scene, with the thresholds of its detection."""

    detect: Detect = Field(Detect(), description="Causes that are heard, with their thresholds.")
