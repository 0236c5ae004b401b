"""Camera: what is seen from where, as words; production computes the poses."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, TypeAdapter, model_validator

from render.words.base import Words
from render.words.ease import HELD_EASE, TURN, Ease, Place, Rate, Rates, Time, Turn

View = Literal["three-quarter", "side", "front", "back", "top"]


MOST_KEYS = 10_000
"""Keyframes of one cut."""

VALUES = ("position", "target", "rotation_deg", "fov_deg")
"""What a keyframe of the camera may say."""

FieldOfView = Annotated[float, Field(ge=1, le=150)]


class CameraTangent(Words):
    """How fast a spline goes through a keyframe, where that is not left to the spline."""

    position: Rates | None = Field(None, description="[m/s].")
    target: Rates | None = Field(None, description="[m/s].")
    rotation_deg: Rates | None = Field(None, description="Of each of the three angles [degrees/s].")
    fov_deg: Rate | None = Field(None, description="[degrees/s].")


class CameraKey(Words):
    """Where the camera is at one time and how it sees, relative to its parent or the world."""

    at: Time = Field(description="When, from the begin of the film [s].")
    position: Place | None = Field(None, description="Where it is, [x, y, z] [m].")
    target: Place | None = Field(None, description="The point it looks at, [x, y, z] [m].")
    rotation_deg: Turn | None = Field(
        None,
        description=f"How it is turned: {TURN}; at 0 it looks along +X.",
    )
    fov_deg: FieldOfView | None = Field(None, description="Vertical field of view [degrees].")
    ease: Ease = Field("spline", description=HELD_EASE)
    tangent: CameraTangent | None = Field(
        None,
        description="How fast a spline goes through here; found from the keys beside it "
        "if left out, 0 at the first and the last.",
    )

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        said = [word for word in VALUES if getattr(self, word) is not None]
        if not said:
            raise ValueError(f"should say one of {', '.join(VALUES)}")
        for word in VALUES:
            if getattr(self.tangent, word, None) is not None and word not in said:
                raise ValueError(f"its tangent needs the {word} that it goes through")
        return self


class Camera(Words):
    """One cut: a camera that goes along with performers, stands in a place, or is moved."""

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
    fov_deg: FieldOfView = Field(35.0, description="Vertical field of view [degrees].")
    at: Place | None = Field(
        None, description="Place [x, y, z] where the camera stands, in its parent or the world."
    )
    look_at: Place | None = Field(
        None, description="Point [x, y, z] of the world at which it looks."
    )
    parent: str | None = Field(
        None,
        min_length=1,
        max_length=200,
        description="What it goes along with: a performer, or one of its links or nodes as "
        "bug.head; it looks ahead from there, unless told where.",
    )
    keyframes: Annotated[tuple[CameraKey, ...], Field(max_length=MOST_KEYS)] = Field(
        (), description="Where it is at certain times, where it looks, and how wide it sees."
    )
    velocity: Rates | None = Field(
        None, description="How fast it goes from `at`, where it is when the cut begins [m/s]."
    )
    rotation_deg: Turn | None = Field(
        None,
        description=f"How it is turned, instead of a point at which it looks: {TURN}; at 0 it "
        "looks along +X.",
    )
    spin_deg: Rates | None = Field(
        None,
        description="How it turns, about x, y and z of its parent or the world, from its "
        "rotation_deg when the cut begins [degrees/s].",
    )
    steady: float = Field(
        0.0,
        ge=0,
        le=60,
        description="Over about how long the shaking of its parent is evened out [s].",
    )

    @model_validator(mode="after")
    def _no_idle_words(self) -> Self:
        viewed = [w for w in ("view", "distance", "elevation_deg") if getattr(self, w) is not None]
        if self.at is not None and viewed:
            raise ValueError(f"a camera that stands at a place has no {' and no '.join(viewed)}")
        if (wrong := next(self._wrong(viewed), None)) is not None:
            raise ValueError(wrong)
        if self.look_at is not None and self.follow is not None:
            raise ValueError("give one of follow and look_at")
        if self.at is not None and self.at == self.look_at:
            raise ValueError("the camera stands at the point it looks at")
        if self.view == "top" and self.elevation_deg is not None:
            raise ValueError("the view from the top has no elevation_deg")
        return self

    @property
    def moved(self) -> bool:
        """Whether it is moved by its author, by keyframes, velocity or a parent."""
        words = (self.parent, self.velocity, self.rotation_deg, self.spin_deg)
        return bool(self.keyframes) or any(word is not None for word in words)

    def _wrong(self, viewed: list[str]) -> Iterator[str]:
        """Find what does not fit together in a camera that is moved."""
        if not self.moved:
            if self.steady:
                yield "steady is for a camera that has a parent"
            return
        if viewed:
            yield f"a camera that is moved by its author has no {' and no '.join(viewed)}"
        places = any(key.position is not None for key in self.keyframes)
        if self.at is None and not places:
            yield "a camera that is moved needs a place: at, or a position in its keyframes"
        if self.at is not None and places:
            yield "give one of at and positions in keyframes"
        if self.velocity is not None and self.keyframes:
            yield "give one of velocity and keyframes"
        yield from self._looks_twice()
        if any(b.at < a.at for a, b in itertools.pairwise(self.keyframes)):
            yield "keyframes must be in the order of time"

    def _looks_twice(self) -> Iterator[str]:
        looks = [word for word in ("look_at", "follow") if getattr(self, word) is not None]
        looks += [
            f"{word} in keyframes"
            for word in ("target", "rotation_deg")
            if any(getattr(key, word) is not None for key in self.keyframes)
        ]
        if self.rotation_deg is not None or self.spin_deg is not None:
            looks.append("rotation_deg and spin_deg")
        if len(looks) > 1:
            yield f"where it looks is said by {' and by '.join(looks)}; give one of them"


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
