"""Configuration of quantisation: grid, strength, swing and mode."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from audio.config import AudioConfig
from audio.names import nearest_name

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


GridName = Annotated[str, AfterValidator(_check_grid)]


class Quantisation(AudioConfig):
    """Moves notes towards the grid of the tempo, and on to whole frames."""

    grid: GridName = Field(
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
