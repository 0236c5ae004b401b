"""Configuration of phrases: the steps that answer an event."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator
from pydantic.config import JsonDict

from audio.config import AudioConfig
from audio.config.pitch import ChordName

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

    @property
    def is_timed(self) -> bool:
        """Whether all its steps are measured in seconds or frames, none in beats."""
        times = [step if step.has_time else self for step in self.steps]
        return all(time.seconds is not None or time.frames is not None for time in times)


def _expand_phrase(value: Any) -> Any:
    return {"steps": tuple(value)} if isinstance(value, list | tuple) else value


PhraseOrSteps = Annotated[
    Phrase, BeforeValidator(_expand_phrase, json_schema_input_type=list[StepOrDegrees] | Phrase)
]
