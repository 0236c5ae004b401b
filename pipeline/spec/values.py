"""The values that scene words are made of: numbers that are numbers, names, lengths."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Strict, Tag


class Words(BaseModel):
    """What the author's models have in common: no unknown keys, no change, no NaN."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True
    )


_LETTER = "0-9A-Za-z_\u00c0-\u1fff\u2c00-\ud7ff"
NAME_PATTERN = f"^[{_LETTER}]([{_LETTER} \\-]*[{_LETTER}])?$"
"""Letters of any script, digits, `_`; inside also `-` and blanks. Dots and brackets are left to
paths. Spelled out, because pydantic, Python and editors disagree on what `\\w` is."""

# Beyond 10 km a float32 vertex is no longer exact to a millimetre.
FAR = 10_000.0

Number = Annotated[float, Strict()]
Whole = Annotated[int, Strict()]
Name = Annotated[str, Strict(), Field(pattern=NAME_PATTERN, max_length=64)]
Coordinate = Annotated[Number, Field(ge=-FAR, le=FAR)]
Length = Annotated[Number, Field(gt=0, le=FAR)]
LengthOrZero = Annotated[Number, Field(ge=0, le=FAR)]
Phase = Annotated[Number, Field(ge=0, le=1)]
Point = tuple[Coordinate, Coordinate]
Place = tuple[Coordinate, Coordinate, Coordinate]


def _name_or_place(words: Any) -> str:
    return "a name" if isinstance(words, str) else "a place"


Target = Annotated[
    Annotated[Name, Tag("a name")] | Annotated[Place, Tag("a place")],
    Discriminator(_name_or_place),
]
"""A performer by its name, or a place [x, y, z] [m]."""
