"""Camera: what is seen from where, as words; production computes the poses."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, TypeAdapter, model_validator

from render.config.base import Words
from render.config.camera_moves import CraneWords, DollyWords, OrbitWords, TruckWords
from render.config.ease import HELD_EASE, TURN, Ease, Place, Rate, Rates, Time, Turn

View = Literal["three-quarter", "side", "front", "back", "top"]


MOST_KEYS = 10_000
"""Keyframes of one cut."""

PLACED = ("position", "target", "rotation_deg")
"""What a keyframe says of a camera that its author moves."""

VALUES = (*PLACED, "fov_deg", "focus")
"""What a keyframe of the camera may say."""

FRAMED = ("view", "distance", "elevation_deg", "orbit", "dolly", "truck", "crane")
"""Words of a camera that is not put anywhere: it frames by itself."""

Focus = Annotated[float, Field(gt=0, le=1e5)] | Place | str
"""A distance [m], a point of the world, or a performer."""

FOCUS = (
    "What is sharp: a performer or one of its links or nodes as bug.head, a point [x, y, z] of the "
    "world, or a distance [m]"
)

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
    focus: Focus | None = Field(None, description=f"{FOCUS}.")
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

    orbit: OrbitWords | None = Field(
        None, description="Turn about what it looks at: degrees a second, [from, to], or in full."
    )
    dolly: DollyWords | None = Field(
        None,
        description="Drive towards what it looks at: metres a second, distances [from, to], or in "
        "full.",
    )
    truck: TruckWords | None = Field(
        None, description="Drive to the right: metres a second, [from, to] in metres, or in full."
    )
    crane: CraneWords | None = Field(
        None,
        description="Rise: metres a second, heights [from, to] over the ground, or in full.",
    )
    lead: float | None = Field(
        None,
        ge=-0.5,
        le=0.5,
        description="How much more room a performer that moves has ahead than behind, as it is put "
        "back from the middle, as a part of the picture; 0.1 if left out.",
    )
    aperture: float | None = Field(
        None,
        ge=0.05,
        le=64,
        description="F-number of the lens on a sensor of 36 x 24 mm: the smaller, the less is "
        "sharp before and behind the focus. All is sharp if left out.",
    )
    focus: Focus | None = Field(None, description=f"{FOCUS}; what it looks at if left out.")

    @model_validator(mode="after")
    def _no_idle_words(self) -> Self:
        viewed = [word for word in FRAMED if getattr(self, word) is not None]
        if self.at is not None and viewed:
            raise ValueError(f"a camera that stands at a place has no {' and no '.join(viewed)}")
        if (wrong := next(self._wrong(viewed), None)) is not None:
            raise ValueError(wrong)
        if self.look_at is not None and self.follow is not None:
            raise ValueError("give one of follow and look_at")
        if self.at is not None and self.at == self.look_at:
            raise ValueError("the camera stands at the point it looks at")
        if (wrong := next(iter((*self._wrong_moves(), *self._wrong_lens())), None)) is not None:
            raise ValueError(wrong)
        return self

    @property
    def moved(self) -> bool:
        """Whether it is moved by its author, by keyframes, velocity or a parent."""
        words = (self.parent, self.velocity, self.rotation_deg, self.spin_deg)
        said = (getattr(key, word) for key in self.keyframes for word in PLACED)
        return any(word is not None for word in (*words, *said))

    def _wrong(self, viewed: list[str]) -> Iterator[str]:
        """Find what does not fit together in a camera that is moved."""
        if any(b.at < a.at for a, b in itertools.pairwise(self.keyframes)):
            yield "keyframes must be in the order of time"
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

    def _wrong_moves(self) -> Iterator[str]:
        """Find what does not fit together in a camera that frames by itself."""
        if self.view == "top":
            words = ("elevation_deg", "orbit", "truck", "crane")
            if said := [word for word in words if getattr(self, word) is not None]:
                yield f"the view from the top has no {' and no '.join(said)}"
        if self.lead is not None and (self.look_at is not None or self.moved):
            which = "looks at a point" if self.look_at is not None else "is moved by its author"
            yield f"a camera that {which} has no lead"
        if self.dolly is not None and self.dolly.start is not None and self.distance is not None:
            yield "the distance is said by distance and by dolly; give one of them"
        if self.crane is not None and self.crane.start is not None:
            if self.elevation_deg is not None:
                yield "the height is said by elevation_deg and by crane; give one of them"
            if self.orbit is not None and self.orbit.rise_deg:
                yield "the height is said by crane and by rise_deg of orbit; give one of them"
        zooms = any(key.fov_deg is not None for key in self.keyframes)
        if self.dolly is not None and self.dolly.zoom and zooms:
            yield "give one of zoom of dolly and fov_deg in keyframes"

    def _wrong_lens(self) -> Iterator[str]:
        """Find what does not fit together in a lens."""
        keyed = any(key.focus is not None for key in self.keyframes)
        if self.focus is not None and keyed:
            yield "give one of focus and focus in keyframes"
        if self.aperture is None:
            if self.focus is not None or keyed:
                yield "focus needs an aperture, as 2.8; without one all is sharp"
            return
        turned = self.rotation_deg is not None or self.spin_deg is not None
        turned |= any(key.rotation_deg is not None for key in self.keyframes)
        aims = (self.look_at, self.follow, *(key.target for key in self.keyframes))
        ahead = turned or (self.parent is not None and all(aim is None for aim in aims))
        if ahead and self.focus is None and not keyed:
            yield "a camera that looks at nothing in particular needs a focus"

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
