"""Configuration of meter and of changes of tempo."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Annotated, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from audio.config import AudioConfig
from audio.names import nearest_name

_METER = re.compile(r"([1-9]\d?)\s*/\s*(\d+)")
_UNITS = (1, 2, 4, 8, 16, 32)
_MOST_BEATS = 64
_COMMON = (*(f"{n}/4" for n in range(1, 13)), *(f"{n}/8" for n in range(1, 17)), "2/2", "3/2")


def parse_meter(text: str) -> tuple[int, int]:
    """Return the number of beats of a bar and the note value of each, such as (6, 8).

    Raises:
        ValueError: the text is no meter; the message names the nearest.
    """
    match = _METER.fullmatch(text.strip())
    if match is None or int(match[2]) not in _UNITS or int(match[1]) > _MOST_BEATS:
        near = nearest_name(text, _COMMON)
        hint = f"; did you mean {near}?" if near else ""
        raise ValueError(
            f"{text!r} is no meter{hint} (allowed: 1 to {_MOST_BEATS} beats, a slash, and one of "
            f"{', '.join(map(str, _UNITS))}, such as 4/4 or 6/8)"
        )
    return int(match[1]), int(match[2])


def bar_length(meter: tuple[int, int]) -> Fraction:
    """Return the length of a bar in beats of quarter notes."""
    return Fraction(4 * meter[0], meter[1])


def _normalized(text: str) -> str:
    return "{}/{}".format(*parse_meter(text))


def _as_text(value: object) -> object:
    # A meter is a text; a number has no second part.
    return f"{value}" if isinstance(value, int | float) and not isinstance(value, bool) else value


MeterText = Annotated[
    str, BeforeValidator(_as_text, json_schema_input_type=str), AfterValidator(_normalized)
]
Tempo = Annotated[float, Field(ge=10, le=480)]


class TempoChange(AudioConfig):
    """Another tempo or meter from a bar on."""

    bar: int = Field(ge=2, le=100_000, description="The bar that it starts with; the first is 1.")
    tempo_bpm: Tempo | None = Field(
        None, description="Quarter notes a minute from here on; as before if left out."
    )
    meter: MeterText | None = Field(
        None, description="Meter from here on, such as 3/4; as before if left out."
    )

    @model_validator(mode="after")
    def _check_change(self) -> Self:
        if self.tempo_bpm is None and self.meter is None:
            raise ValueError("changes nothing; give tempo_bpm, meter or both")
        return self
