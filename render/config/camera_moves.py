"""Camera moves: orbit, dolly, truck and crane, as words of a cut that frames by itself.

A move goes on for the whole of its cut, from its begin to the next cut or the end of the film.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from render.config.base import Words

MoveEase = Literal["linear", "in", "out", "in-out"]

_EASE = (
    "How it begins and ends: in starts from rest, out comes to rest, in-out does both, linear "
    "does neither; in-out between two ends, linear at a speed."
)

Length = Annotated[float, Field(ge=-1e4, le=1e4)]
Angle = Annotated[float, Field(ge=-36_000, le=36_000)]


class _Move(Words):
    ease: MoveEase | None = Field(None, description=_EASE)


class Orbit(_Move):
    """A turn about what the camera looks at; positive turns about +Y, as a heading does."""

    speed_deg: Angle | None = Field(
        None,
        description="How fast it turns, from the side of the view [degrees/s]; 12 if left out.",
    )
    from_deg: Angle | None = Field(
        None, description="Where it begins, from the side of the view [degrees]."
    )
    to_deg: Angle | None = Field(None, description="Where it ends [degrees].")
    rise_deg: float = Field(
        0.0, ge=-178, le=178, description="By how much its elevation grows over the cut [degrees]."
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        _one_of_two(self.speed_deg, self.from_deg, self.to_deg, "_deg")
        return self


class _Straight(_Move):
    # The field cannot be called from, which is no name in Python.
    model_config = ConfigDict(serialize_by_alias=True)

    def _check(self) -> None:
        start, end, speed = (getattr(self, word) for word in ("start", "end", "speed"))
        _one_of_two(speed, start, end, "")
        if speed is None and end is None:
            raise ValueError("say how fast it goes, as 0.3, or between what, as [2, 5]")


class Dolly(_Straight):
    """A drive towards what the camera looks at, or away from it."""

    speed: Length | None = Field(
        None, description="How fast it comes nearer [m/s]; away if negative."
    )
    start: Length | None = Field(
        None, alias="from", description="Distance at the begin of the cut [m]."
    )
    end: Length | None = Field(None, alias="to", description="Distance at its end [m].")
    zoom: bool = Field(
        False,
        description="Zoom against it, so that what is looked at keeps its size (a dolly zoom).",
    )

    @model_validator(mode="after")
    def _some_way(self) -> Self:
        self._check()
        if any(end is not None and end <= 0.0 for end in (self.start, self.end)):
            raise ValueError("its distances must be greater than 0")
        return self


class Truck(_Straight):
    """A drive sideways, looking at the same thing all the while."""

    speed: Length | None = Field(None, description="How fast it goes to the right [m/s].")
    start: Length | None = Field(
        None, alias="from", description="How far to the right it begins [m]."
    )
    end: Length | None = Field(None, alias="to", description="How far to the right it ends [m].")

    @model_validator(mode="after")
    def _some_way(self) -> Self:
        self._check()
        return self


class Crane(_Straight):
    """A rise straight up, or a descent, looking at the same thing all the while."""

    speed: Length | None = Field(
        None, description="How fast it rises from the elevation of its view [m/s]."
    )
    start: Length | None = Field(
        None,
        alias="from",
        description="Height at the begin, over the ground below what is looked at [m].",
    )
    end: Length | None = Field(None, alias="to", description="Height at the end [m].")

    @model_validator(mode="after")
    def _some_way(self) -> Self:
        self._check()
        return self


def _one_of_two(speed: float | None, start: float | None, end: float | None, suffix: str) -> None:
    if speed is not None and (start is not None or end is not None):
        raise ValueError(f"give speed{suffix}, or from{suffix} and to{suffix}")
    if (start is None) != (end is None):
        missing, given = ("from", "to") if start is None else ("to", "from")
        raise ValueError(f"{given}{suffix} needs {missing}{suffix}")


def _written_out(suffix: str) -> Callable[[Any], Any]:
    """Let a number stand for a speed, and two for both ends."""

    def write_out(value: Any) -> Any:
        if isinstance(value, int | float) and not isinstance(value, bool):
            return {f"speed{suffix}": value}
        if isinstance(value, list | tuple) and len(value) == 2:
            return {f"from{suffix}": value[0], f"to{suffix}": value[1]}
        return value

    return write_out


_Short = float | tuple[float, float]

OrbitWords = Annotated[
    Orbit, BeforeValidator(_written_out("_deg"), json_schema_input_type=Orbit | _Short)
]
DollyWords = Annotated[
    Dolly, BeforeValidator(_written_out(""), json_schema_input_type=Dolly | _Short)
]
TruckWords = Annotated[
    Truck, BeforeValidator(_written_out(""), json_schema_input_type=Truck | _Short)
]
CraneWords = Annotated[
    Crane, BeforeValidator(_written_out(""), json_schema_input_type=Crane | _Short)
]
"""A number is a speed, two numbers are where the move begins and where it ends."""
