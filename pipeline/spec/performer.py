"""Performer: what all members of a cast have."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pipeline.spec.model_base import ConfigModel, Coordinate, MaterialName, Name, Number

MAX_KEYFRAMES = 10_000
"""Keyframes of one performer."""

Speed = Annotated[Number, Field(ge=-1000, le=1000)]
Velocity = tuple[Speed, Speed, Speed]

At = Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)]
"""[x, z] on the ground, or [x, y, z] [m]."""


class Performer(ConfigModel):
    """What all members of a cast have."""

    name: Name = Field(
        "", description="Its name; its kind, numbered, if left out.", validate_default=False
    )
    heading_deg: Number = Field(
        0.0,
        ge=-3600,
        le=3600,
        description="Direction it faces: 0 along +X, positive turns about +Y [degrees].",
    )
    material: MaterialName | None = Field(None, description="Material of the parts that name none.")
    parent: str | None = Field(
        None,
        min_length=1,
        max_length=200,
        description="What carries it: a performer, or one of its links or nodes such as bug.head; "
        "its position is then relative to that.",
    )
