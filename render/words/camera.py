"""Camera: what is seen from where, as words; production computes the poses."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, TypeAdapter, model_validator

from render.words.base import Point, Words

View = Literal["three-quarter", "side", "front", "back", "top"]


class Camera(Words):
    """One cut: a camera that goes along with performers, or one that stands in a place."""

    start: float = Field(0.0, ge=0, description="Time at which this cut begins [s].")
    follow: str | tuple[str, ...] | None = Field(
        None, description="Performer or performers to keep in the picture; all unless said."
    )
    view: View | None = Field(
        None, description="Side from which the camera looks; three-quarter unless said."
    )
    distance: float | None = Field(
        None, gt=0, le=1e5, description="Distance to what is followed [m]; chosen if left out."
    )
    elevation_deg: float | None = Field(
        None, ge=-89, le=89, description="Height of the camera as an angle; that of the view."
    )
    fov_deg: float = Field(35.0, ge=1, le=150, description="Vertical field of view [degrees].")
    at: Point | None = Field(None, description="Place [x, y, z] where the camera stands still.")
    look_at: Point | None = Field(None, description="Point [x, y, z] at which it looks.")

    @model_validator(mode="after")
    def _no_idle_words(self) -> Self:
        moving = [w for w in ("view", "distance", "elevation_deg") if getattr(self, w) is not None]
        if self.at is not None and moving:
            raise ValueError(f"a camera that stands at a place has no {' and no '.join(moving)}")
        if self.look_at is not None and self.follow is not None:
            raise ValueError("give one of follow and look_at")
        if self.at is not None and self.at == self.look_at:
            raise ValueError("the camera stands at the point it looks at")
        if self.view == "top" and self.elevation_deg is not None:
            raise ValueError("the view from the top has no elevation_deg")
        return self


def _listed(value: object) -> object:
    return value if isinstance(value, list | tuple) else (value,)


def _in_order(value: tuple[Camera, ...]) -> tuple[Camera, ...]:
    if not value or value[0].start != 0:
        raise ValueError("the first cut must start at 0")
    if any(b.start <= a.start for a, b in itertools.pairwise(value)):
        raise ValueError("each cut must start later than the one before")
    return value


Cuts = Annotated[
    tuple[Camera, ...],
    BeforeValidator(_listed, json_schema_input_type=Camera | list[Camera]),
    AfterValidator(_in_order),
]
"""One camera, or a list of cuts of which the first starts at 0."""

_CUTS: TypeAdapter[tuple[Camera, ...]] = TypeAdapter(Cuts)


def cuts(word: Mapping[str, Any] | Camera | list[Mapping[str, Any] | Camera]) -> tuple[Camera, ...]:
    """Return the cuts that a word in a scene stands for, in order of time.

    Raises:
        ValueError: a word is out of range, or the cuts are not in order from 0.
    """
    return _CUTS.validate_python(word)
