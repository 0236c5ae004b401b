"""The author's words on phrases: the notes that answer one event."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator
from pydantic.config import JsonDict

from audio.model import Words
from audio.pitch_words import ChordName

LONGEST = 256
"""Most steps of a phrase."""

# Its own check, because a list whose only item is wrong would be called too short as well.
_SOME: JsonDict = {"minItems": 1}

Degree = Annotated[int, Field(ge=-70, le=70)]
Beats = Annotated[float, Field(gt=0, le=256)]
Seconds = Annotated[float, Field(gt=0, le=600)]
Frames = Annotated[int, Field(ge=1, le=100_000)]


class Timed(Words):
    """A time from one step to the next, in one of three units."""

    beats: Beats | None = Field(None, description="Time from step to step in beats.")
    seconds: Seconds | None = Field(None, description="That time in seconds.")
    frames: Frames | None = Field(None, description="That time in frames.")

    @model_validator(mode="after")
    def _one_unit(self) -> Self:
        units = [w for w in ("beats", "seconds", "frames") if getattr(self, w) is not None]
        if len(units) > 1:
            raise ValueError(f"give one of beats, seconds and frames; got {' and '.join(units)}")
        return self

    @property
    def says_when(self) -> bool:
        """Whether any unit is given."""
        return any(unit is not None for unit in (self.beats, self.seconds, self.frames))


class StepWords(Timed):
    """One step of a phrase: what sounds, and how long until the next."""

    degrees: tuple[Degree, ...] = Field(
        (0,),
        max_length=12,
        json_schema_extra=_SOME,
        description="Steps of the scale above the event's own pitch; several sound together.",
    )
    chord: ChordName | None = Field(
        None, description="Chord that sounds instead, its root nearest to the event's own pitch."
    )
    rest: bool = Field(False, description="True for a silence.")
    length: float | None = Field(
        None, gt=0, le=60, description="How long its notes last [s]; to the next step if not said."
    )
    gain_db: float = Field(0.0, ge=-60, le=24, description="Louder or softer than its event [dB].")

    @field_validator("degrees")
    @classmethod
    def _sounds(cls, degrees: tuple[Degree, ...]) -> tuple[Degree, ...]:
        if not degrees:
            raise ValueError("a step has one degree at least; write rest for a silence")
        return degrees

    @model_validator(mode="after")
    def _one_sound(self) -> Self:
        said = {
            "degrees": self.degrees != (0,),
            "chord": self.chord is not None,
            "rest": self.rest,
        }
        given = [word for word, is_said in said.items() if is_said]
        if len(given) > 1:
            raise ValueError(f"give one of degrees, chord and rest; got {' and '.join(given)}")
        return self


def _step(words: Any) -> Any:
    """Read 2 as a degree, [0, 2] as degrees that sound together, and rest as a rest."""
    if isinstance(words, int) and not isinstance(words, bool):
        return {"degrees": (words,)}
    if isinstance(words, list | tuple):
        return {"degrees": tuple(words)}
    if isinstance(words, str):
        if words.strip().casefold() != "rest":
            raise ValueError(
                f"a step of a phrase is a degree, a list of degrees, 'rest', or a mapping such as "
                f"{{chord: Am7, beats: 1}}; got {words!r}"
            )
        return {"rest": True}
    return words


Step = Annotated[
    StepWords,
    BeforeValidator(
        _step, json_schema_input_type=Degree | list[Degree] | Literal["rest"] | StepWords
    ),
]


class PhraseWords(Timed):
    """Notes one after the other that answer an event."""

    steps: Annotated[tuple[Step, ...], Field(max_length=LONGEST)] = Field(
        description="What sounds step by step: a degree, degrees together, rest, or in full.",
        json_schema_extra=_SOME,
    )

    @field_validator("steps")
    @classmethod
    def _sounds_at_once(cls, steps: tuple[StepWords, ...]) -> tuple[StepWords, ...]:
        if not steps:
            raise ValueError("a phrase has one step at least")
        if steps[0].rest:
            raise ValueError(
                "the first step of a phrase sounds with its event; it cannot be a rest"
            )
        return steps


def _phrase(words: Any) -> Any:
    """Read a list as the steps of a phrase."""
    return {"steps": tuple(words)} if isinstance(words, list | tuple) else words


Phrase = Annotated[
    PhraseWords, BeforeValidator(_phrase, json_schema_input_type=list[Step] | PhraseWords)
]
