"""Configuration of notes: pitches, phrases, velocities and quantisation."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainValidator,
    field_validator,
    model_validator,
)
from pydantic.config import JsonDict

from audio.config import AudioConfig, checked_by
from audio.harmony import parse_chord, parse_note, parse_steps
from audio.names import nearest_name, normalized_name

# --- pitches ---

PITCH_RULES = ("by size", "by foot", "by part")
_RULE_WITH_FIRST_NOTE = re.compile(r"(by foot|by part) from (.+)")


def _parse_pitch(pitch: object) -> int | str:
    allowed = (
        f"a MIDI number 0 to 127, a note such as C4, or one of: {', '.join(PITCH_RULES)}, "
        "or 'by foot from C3'"
    )
    if isinstance(pitch, int) and not isinstance(pitch, bool) and 0 <= pitch <= 127:
        return pitch
    if not isinstance(pitch, str):
        raise ValueError(f"a pitch is {allowed}; got {pitch!r}")
    if normalized_name(pitch) in PITCH_RULES:
        return normalized_name(pitch)
    try:
        if first_note_of_rule(pitch) is not None:
            return " ".join(pitch.split())
        return parse_note(pitch)
    except ValueError as error:
        raise ValueError(f"{error} (a pitch is {allowed})") from error


def first_note_of_rule(rule: str) -> int | None:
    """Return the MIDI pitch that a rule such as "by foot from C3" names; None for other rules.

    Raises:
        ValueError: the text after "from" is not a note.
    """
    match = _RULE_WITH_FIRST_NOTE.fullmatch(" ".join(rule.split()))
    return parse_note(match[2]) if match else None


ScaleName = Annotated[str, checked_by(parse_steps)]
ChordName = Annotated[str, checked_by(parse_chord)]
# One validator instead of a union, so that a mistake is reported once.
Pitch = Annotated[
    int | str,
    PlainValidator(_parse_pitch, json_schema_input_type=Annotated[int, Field(ge=0, le=127)] | str),
]

# --- phrases ---

MAX_STEPS = 256
"""Greatest number of steps in a phrase."""

# The minimum is for the schema only: the validators report an empty list in their own words.
_NOT_EMPTY: JsonDict = {"minItems": 1}

Degree = Annotated[int, Field(ge=-70, le=70)]


class StepTime(AudioConfig):
    """Time from one step to the next, in one of three units."""

    beats: Annotated[float, Field(gt=0, le=256)] | None = Field(
        None, description="Time to the next step in beats."
    )
    seconds: Annotated[float, Field(gt=0, le=600)] | None = Field(
        None, description="Time to the next step in seconds."
    )
    frames: Annotated[int, Field(ge=1, le=100_000)] | None = Field(
        None, description="Time to the next step in frames."
    )

    @model_validator(mode="after")
    def _check_units(self) -> Self:
        units = [unit for unit in ("beats", "seconds", "frames") if getattr(self, unit) is not None]
        if len(units) > 1:
            raise ValueError(f"give one of beats, seconds and frames; got {' and '.join(units)}")
        return self

    @property
    def has_time(self) -> bool:
        """Whether any unit is given."""
        return any(unit is not None for unit in (self.beats, self.seconds, self.frames))


class PhraseStep(StepTime):
    """One step of a phrase: its notes, and the time to the next step."""

    degrees: tuple[Degree, ...] = Field(
        (0,),
        max_length=12,
        json_schema_extra=_NOT_EMPTY,
        description="Scale degrees above the event's own pitch; several sound together.",
    )
    chord: ChordName | None = Field(
        None, description="Chord to play instead, its root nearest to the event's own pitch."
    )
    rest: bool = Field(False, description="True for a silence.")
    length: float | None = Field(
        None, gt=0, le=60, description="Length of its notes [s]; up to the next step by default."
    )
    gain_db: float = Field(0.0, ge=-60, le=24, description="Gain relative to its event [dB].")

    @field_validator("degrees")
    @classmethod
    def _check_degrees(cls, degrees: tuple[Degree, ...]) -> tuple[Degree, ...]:
        if not degrees:
            raise ValueError("a step has one degree at least; write rest for a silence")
        return degrees

    @model_validator(mode="after")
    def _check_content(self) -> Self:
        given = {
            "degrees": self.degrees != (0,),
            "chord": self.chord is not None,
            "rest": self.rest,
        }
        keys = [key for key, is_given in given.items() if is_given]
        if len(keys) > 1:
            raise ValueError(f"give one of degrees, chord and rest; got {' and '.join(keys)}")
        return self


def _expand_step(value: Any) -> Any:
    """Expand 2 to a degree, [0, 2] to simultaneous degrees, and "rest" to a rest."""
    if isinstance(value, int) and not isinstance(value, bool):
        return {"degrees": (value,)}
    if isinstance(value, list | tuple):
        return {"degrees": tuple(value)}
    if isinstance(value, str):
        if value.strip().casefold() != "rest":
            raise ValueError(
                f"a step of a phrase is a degree, a list of degrees, 'rest', or a mapping such as "
                f"{{chord: Am7, beats: 1}}; got {value!r}"
            )
        return {"rest": True}
    return value


StepOrDegrees = Annotated[
    PhraseStep,
    BeforeValidator(
        _expand_step, json_schema_input_type=Degree | list[Degree] | Literal["rest"] | PhraseStep
    ),
]


class Phrase(StepTime):
    """A sequence of notes played for one event."""

    steps: Annotated[tuple[StepOrDegrees, ...], Field(max_length=MAX_STEPS)] = Field(
        description="The steps in order: a degree, degrees together, rest, or a mapping.",
        json_schema_extra=_NOT_EMPTY,
    )

    @field_validator("steps")
    @classmethod
    def _check_steps(cls, steps: tuple[PhraseStep, ...]) -> tuple[PhraseStep, ...]:
        if not steps:
            raise ValueError("a phrase has one step at least")
        if steps[0].rest:
            raise ValueError(
                "the first step of a phrase sounds with its event; it cannot be a rest"
            )
        return steps


def _expand_phrase(value: Any) -> Any:
    return {"steps": tuple(value)} if isinstance(value, list | tuple) else value


PhraseOrSteps = Annotated[
    Phrase, BeforeValidator(_expand_phrase, json_schema_input_type=list[StepOrDegrees] | Phrase)
]

# --- velocities ---

DEFAULT_SLOWEST, DEFAULT_FASTEST = 0.05, 3.0
"""Speeds between which a linear or power curve runs by default [m/s]."""

_KEYS_OF_CURVE = {
    "physical": {"exponent", "slowest", "fastest"},
    "linear": {"slowest", "fastest", "softest", "loudest", "distance"},
    "power": {"exponent", "slowest", "fastest", "softest", "loudest", "distance"},
    "fixed": {"loudest", "distance"},
}


class Velocity(AudioConfig):
    """Curve from the strength of an event to the MIDI velocity of its note."""

    curve: Literal["physical", "linear", "power", "fixed"] = Field(
        "physical",
        description="'physical' follows speed, mass and distance; 'linear' and 'power' go from "
        "softest to loudest as the speed goes from slowest to fastest; 'fixed' is always loudest.",
    )
    exponent: float | None = Field(
        None,
        gt=0,
        le=4,
        description="Exponent of the speed: for physical that of the amplitude, 0.7 by default; "
        "for power that of the velocity, 0.5 by default.",
    )
    slowest: float | None = Field(
        None, gt=0, le=1000, description="Lower speeds are raised to this [m/s]."
    )
    fastest: float | None = Field(
        None, gt=0, le=1000, description="Higher speeds are lowered to this [m/s]."
    )
    softest: int = Field(20, ge=1, le=127, description="Velocity at the slowest, 1 to 127.")
    loudest: int = Field(112, ge=1, le=127, description="Velocity at the fastest, 1 to 127.")
    distance: bool = Field(
        True,
        description="Whether linear, power and fixed velocities hold at 4 m and are softer "
        "farther away; False to make them independent of distance.",
    )

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        fields = type(self).model_fields
        # A file that spells out the defaults in full is valid.
        unused = sorted(
            key
            for key in self.model_fields_set - _KEYS_OF_CURVE[self.curve] - {"curve"}
            if getattr(self, key) != fields[key].default
        )
        if unused:
            keys = ", ".join(sorted(_KEYS_OF_CURVE[self.curve]))
            raise ValueError(f"the curve {self.curve!r} has no {unused[0]!r}; it has {keys}")
        if self.curve in ("linear", "power"):
            slowest, fastest = self.slowest or DEFAULT_SLOWEST, self.fastest or DEFAULT_FASTEST
        else:
            slowest, fastest = self.slowest or 0.0, self.fastest or 1000.0
        if slowest >= fastest:
            raise ValueError(f"slowest, {slowest:g} m/s, is to be below fastest, {fastest:g} m/s")
        return self


def _expand_velocity(value: Any) -> Any:
    """Expand 90 to a fixed velocity of 90."""
    if isinstance(value, int) and not isinstance(value, bool):
        return {"curve": "fixed", "loudest": value}
    return value


VelocityOrNumber = Annotated[
    Velocity,
    BeforeValidator(
        _expand_velocity,
        json_schema_input_type=Annotated[int, Field(ge=1, le=127)] | Velocity,
    ),
]

# --- quantisation ---

GRIDS = tuple(f"1/{part}{kind}" for part in (1, 2, 4, 8, 16, 32) for kind in ("", "T", "D"))
_GRID = re.compile(r"1/(1|2|4|8|16|32)([TD]?)")
_LENGTH_FACTORS = {"": Fraction(1), "T": Fraction(2, 3), "D": Fraction(3, 2)}


def beats_of_grid(grid: str) -> Fraction:
    """Return the length of a grid step in beats: 1/4 is one beat, 1/8T a third of one.

    Raises:
        ValueError: no grid has this name; the message names the nearest.
    """
    match = _GRID.fullmatch(grid.strip().upper())
    if match is None:
        near = nearest_name(grid, GRIDS)
        hint = f"; did you mean {near!r}?" if near else ""
        raise ValueError(
            f"unknown grid {grid!r}{hint} (allowed: 1/1, 1/2, 1/4, 1/8, 1/16, 1/32, and with T for "
            "triplets or D for dotted notes, such as 1/8T)"
        )
    return Fraction(4, int(match[1])) * _LENGTH_FACTORS[match[2]]


def _check_grid(text: str) -> str:
    beats_of_grid(text)
    return text.strip().upper()


class Quantisation(AudioConfig):
    """Moves notes towards the grid of the tempo, and on to whole frames."""

    grid: Annotated[str, AfterValidator(_check_grid)] = Field(
        "1/16", description="Note value of a grid step: 1/4 is a beat; 1/8T triplets, 1/8D dotted."
    )
    strength: float = Field(
        1.0, ge=0, le=1, description="Fraction of the way to the grid that notes are moved."
    )
    swing: float = Field(
        0.5,
        ge=0.5,
        le=0.75,
        description="Share of the first of two steps: 0.5 is even, 0.667 a triplet's swing.",
    )
    offset: float = Field(0.0, ge=-3600, le=3600, description="Time of a beat [s].")
    mode: Literal["nearest", "next"] = Field(
        "nearest",
        description="'nearest' may sound before its cause is seen; 'next' only moves later.",
    )
