"""The author's words on phrases: the notes that answer one event."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from audio.model import Words
from audio.pitch_words import ChordName

LONGEST = 256
"""Most steps of a phrase."""

Degree = Annotated[int, Field(ge=-70, le=70)]


class StepWords(Words):
    """One step of a phrase: what sounds, and how long until the next."""

    degrees: tuple[Degree, ...] = Field(
        (0,),
        min_length=1,
        max_length=12,
        description="Steps of the scale above the event's own pitch; several sound together.",
    )
    chord: ChordName | None = Field(
        None, description="Chord that sounds instead, its root nearest to the event's own pitch."
    )
    rest: bool = Field(False, description="True for a silence.")
    beats: float | None = Field(
        None, gt=0, le=256, description="Time to the next step in beats; half a beat if not said."
    )
    seconds: float | None = Field(None, gt=0, le=600, description="That time in seconds.")
    frames: int | None = Field(None, ge=1, le=100_000, description="That time in frames.")
    length: float | None = Field(
        None, gt=0, le=60, description="How long its notes last [s]; to the next step if not said."
    )
    gain_db: float = Field(0.0, ge=-60, le=24, description="Louder or softer than its event [dB].")

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        times = [w for w in ("beats", "seconds", "frames") if getattr(self, w) is not None]
        if len(times) > 1:
            raise ValueError(f"give one of beats, seconds and frames; got {' and '.join(times)}")
        said = {
            "degrees": self.degrees != (0,),
            "chord": self.chord is not None,
            "rest": self.rest,
        }
        given = [word for word, is_said in said.items() if is_said]
        if len(given) > 1:
            raise ValueError(f"give one of degrees, chord and rest; got {' and '.join(given)}")
        return self


def _spelled_out(step: Any) -> Any:
    """Read 2 as a degree, [0, 2] as degrees that sound together, and rest as a rest."""
    if isinstance(step, int) and not isinstance(step, bool):
        return {"degrees": [step]}
    if isinstance(step, list | tuple):
        return {"degrees": step}
    if isinstance(step, str):
        if step.strip().casefold() != "rest":
            raise ValueError(
                f"a step of a phrase is a degree, a list of degrees, 'rest', or a mapping such as "
                f"{{chord: Am7, beats: 1}}; got {step!r}"
            )
        return {"rest": True}
    return step


Step = Annotated[
    StepWords,
    BeforeValidator(_spelled_out, json_schema_input_type=Degree | list[Degree] | str | StepWords),
]


def _sounds_at_once(steps: tuple[StepWords, ...]) -> tuple[StepWords, ...]:
    if steps and steps[0].rest:
        raise ValueError("the first step of a phrase sounds with its event; it cannot be a rest")
    return steps


Phrase = Annotated[
    tuple[Step, ...], Field(min_length=1, max_length=LONGEST), AfterValidator(_sounds_at_once)
]
