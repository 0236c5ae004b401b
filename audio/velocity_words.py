"""The author's words on how hard a note is struck."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from audio.model import Words

_USES = {
    "physical": {"exponent", "slowest", "fastest"},
    "linear": {"slowest", "fastest", "softest", "loudest", "distance"},
    "power": {"exponent", "slowest", "fastest", "softest", "loudest", "distance"},
    "fixed": {"loudest", "distance"},
}
SLOWEST, FASTEST = 0.05, 3.0
"""Between which speeds a curve goes where the author does not say [m/s]."""


class VelocityWords(Words):
    """How the velocity of a note follows the strength of its cause."""

    curve: Literal["physical", "linear", "power", "fixed"] = Field(
        "physical",
        description="'physical' follows speed, mass and distance; 'linear' and 'power' go from "
        "softest to loudest as the speed goes from slowest to fastest; 'fixed' is always loudest.",
    )
    exponent: float | None = Field(
        None,
        gt=0,
        le=4,
        description="Power of the speed: of physical that of the amplitude, 0.7 if not said; of "
        "power that of the velocity, 0.5 if not said.",
    )
    slowest: float | None = Field(
        None, gt=0, le=1000, description="What is slower sounds as this [m/s]."
    )
    fastest: float | None = Field(
        None, gt=0, le=1000, description="What is faster sounds as this [m/s]."
    )
    softest: int = Field(20, ge=1, le=127, description="Velocity at the slowest, 1 to 127.")
    loudest: int = Field(112, ge=1, le=127, description="Velocity at the fastest, 1 to 127.")
    distance: bool = Field(
        True,
        description="Whether linear, power and fixed velocities hold at 4 m and are softer "
        "farther away; False for what they say wherever it is heard.",
    )

    @model_validator(mode="after")
    def _as_the_curve_uses(self) -> Self:
        idle = sorted(self.model_fields_set - _USES[self.curve] - {"curve"})
        # What a file that was written out in full says by default contradicts nothing.
        idle = [
            word for word in idle if getattr(self, word) != type(self).model_fields[word].default
        ]
        if idle:
            uses = ", ".join(sorted(_USES[self.curve]))
            raise ValueError(f"the curve {self.curve!r} has no {idle[0]!r}; it has {uses}")
        if self.curve in ("linear", "power"):
            slowest, fastest = self.slowest or SLOWEST, self.fastest or FASTEST
        else:
            slowest, fastest = self.slowest or 0.0, self.fastest or 1000.0
        if slowest >= fastest:
            raise ValueError(f"slowest, {slowest:g} m/s, is to be below fastest, {fastest:g} m/s")
        return self


def _spelled_out(words: Any) -> Any:
    """Read 90 as a fixed velocity of 90."""
    if isinstance(words, int) and not isinstance(words, bool):
        return {"curve": "fixed", "loudest": words}
    return words


Velocity = Annotated[
    VelocityWords,
    BeforeValidator(
        _spelled_out,
        json_schema_input_type=Annotated[int, Field(ge=1, le=127)] | VelocityWords,
    ),
]
