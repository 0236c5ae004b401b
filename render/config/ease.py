"""Ease: how a value comes to a key from the one before, be it of a thing or of the camera."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

Ease = Literal["spline", "linear", "in", "out", "in-out", "hold"]
"""How a value comes to a keyframe from the one before."""

EASE = (
    "How it comes here from the keyframe before: spline goes through without a halt, in starts "
    "from rest, out comes to rest, in-out does both, linear does neither"
)
HELD_EASE = f"{EASE}, hold waits and then jumps."

TURN = "about z, then x, then y, so that y turns it about the vertical [degrees]"
"""What the three numbers of every `turn_deg` and `rotation_deg` mean."""

# Beyond 10 km a float32 vertex is no longer exact to a millimetre.
Coordinate = Annotated[float, Field(ge=-10_000, le=10_000)]
Place = tuple[Coordinate, Coordinate, Coordinate]
Rate = Annotated[float, Field(ge=-36_000, le=36_000)]
Rates = tuple[Rate, Rate, Rate]

Time = Annotated[float, Field(ge=0, le=1e6)]
Angle = Annotated[float, Field(ge=-36_000, le=36_000)]
Turn = tuple[Angle, Angle, Angle]
