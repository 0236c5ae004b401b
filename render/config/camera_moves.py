"""Configuration of orbit, dolly, truck and crane, the moves of a camera that frames automatically.

A move lasts for its whole cut, until the next cut or the end of the film.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from render.config.base import Angle, RenderConfig

MoveEase = Literal["linear", "in", "out", "in-out"]

_EASE_DESCRIPTION = (
    "Start and end of the move: in starts from rest, out comes to rest, in-out does both, linear "
    "does neither; in-out is the default between two ends, linear at a speed."
)

Length = Annotated[float, Field(ge=-1e4, le=1e4)]


class _Move(RenderConfig):
    ease: MoveEase | None = Field(None, description=_EASE_DESCRIPTION)


class Orbit(_Move):
    """A turn about the target; positive turns about +Y, as a heading does."""

    speed_deg: Angle | None = Field(
        None,
        description="Speed, starting from the side of the view [degrees/s]; 12 by default.",
    )
    from_deg: Angle | None = Field(
        None, description="Start angle, from the side of the view [degrees]."
    )
    to_deg: Angle | None = Field(None, description="End angle [degrees].")
    rise_deg: float = Field(
        0.0, ge=-178, le=178, description="Change of the elevation over the cut [degrees]."
    )

    @model_validator(mode="after")
    def _check_speed_or_ends(self) -> Self:
        _check_exclusive(self.speed_deg, self.from_deg, self.to_deg, "_deg")
        return self


class _LinearMove(_Move):
    # `from` is a keyword of Python, so the field needs an alias.
    model_config = ConfigDict(serialize_by_alias=True)

    def _check(self) -> None:
        start, end, speed = (getattr(self, key) for key in ("start", "end", "speed"))
        _check_exclusive(speed, start, end, "")
        if speed is None and end is None:
            raise ValueError("empty; give a speed, such as 0.3, or two ends, such as [2, 5]")


class Dolly(_LinearMove):
    """A move towards the target, or away from it."""

    speed: Length | None = Field(
        None, description="Speed towards the target [m/s]; away if negative."
    )
    start: Length | None = Field(
        None, alias="from", description="Distance at the start of the cut [m]."
    )
    end: Length | None = Field(None, alias="to", description="Distance at the end of the cut [m].")
    zoom: bool = Field(
        False,
        description="Zoom against the move, so that the target keeps its size (a dolly zoom).",
    )

    @model_validator(mode="after")
    def _check_ends(self) -> Self:
        self._check()
        if any(end is not None and end <= 0.0 for end in (self.start, self.end)):
            raise ValueError("the distances of `dolly` must be greater than 0")
        return self


class Truck(_LinearMove):
    """A sideways move that keeps looking at the target."""

    speed: Length | None = Field(None, description="Speed to the right [m/s].")
    start: Length | None = Field(
        None, alias="from", description="Offset to the right at the start [m]."
    )
    end: Length | None = Field(None, alias="to", description="Offset to the right at the end [m].")

    @model_validator(mode="after")
    def _check_ends(self) -> Self:
        self._check()
        return self


class Crane(_LinearMove):
    """A rise straight up, or a descent, that keeps looking at the target."""

    speed: Length | None = Field(
        None, description="Upward speed, starting from the elevation of the view [m/s]."
    )
    start: Length | None = Field(
        None,
        alias="from",
        description="Height at the start, over the ground below the target [m].",
    )
    end: Length | None = Field(None, alias="to", description="Height at the end [m].")

    @model_validator(mode="after")
    def _check_ends(self) -> Self:
        self._check()
        return self


def _check_exclusive(
    speed: float | None, start: float | None, end: float | None, suffix: str
) -> None:
    if speed is not None and (start is not None or end is not None):
        raise ValueError(f"`speed{suffix}` conflicts with `from{suffix}` and `to{suffix}`")
    if (start is None) != (end is None):
        missing, given = ("from", "to") if start is None else ("to", "from")
        raise ValueError(f"`{given}{suffix}` needs `{missing}{suffix}`")


def _expand(suffix: str) -> Callable[[Any], Any]:
    """Return a function that expands a number to a speed, and two numbers to both ends."""

    def expand(value: Any) -> Any:
        if isinstance(value, int | float) and not isinstance(value, bool):
            return {f"speed{suffix}": value}
        if isinstance(value, list | tuple) and len(value) == 2:
            return {f"from{suffix}": value[0], f"to{suffix}": value[1]}
        return value

    return expand


_Short = float | tuple[float, float]

OrbitField = Annotated[
    Orbit, BeforeValidator(_expand("_deg"), json_schema_input_type=Orbit | _Short)
]
DollyField = Annotated[Dolly, BeforeValidator(_expand(""), json_schema_input_type=Dolly | _Short)]
TruckField = Annotated[Truck, BeforeValidator(_expand(""), json_schema_input_type=Truck | _Short)]
CraneField = Annotated[Crane, BeforeValidator(_expand(""), json_schema_input_type=Crane | _Short)]
"""A number is a speed; two numbers are the start and the end of the move."""
