"""Camera configuration: cuts, keyframes, moves and lens. `production` computes the poses."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    TypeAdapter,
    model_validator,
)

from render.config.base import (
    HELD_EASE_DESCRIPTION,
    TURN_DESCRIPTION,
    Ease,
    Place,
    Rate,
    Rates,
    RenderConfig,
    Time,
    Turn,
    Unit,
)
from render.config.camera_moves import CraneField, DollyField, OrbitField, TruckField

View = Literal["three-quarter", "side", "front", "back", "top"]

ViewAngle = Annotated[float, Field(ge=-360, le=360)]
"""Azimuth of the camera from ahead of those it follows, positive to their right [degrees]."""


def _name_or_angle(value: object) -> str:
    return "a name" if isinstance(value, str) else "an angle"


Side = Annotated[
    Annotated[View, Tag("a name")] | Annotated[ViewAngle, Tag("an angle")],
    Discriminator(_name_or_angle),
]
"""A view by name or by angle."""

Pace = Literal["calm", "natural", "quick"]
"""How often a director cuts."""

AUTO = "auto"
"""What stands for a camera whose cuts a director decides."""


def _usual_pace(value: object) -> object:
    return "natural" if value is True else value


DirectedPace = Annotated[
    Pace, BeforeValidator(_usual_pace, json_schema_input_type=Pace | Literal[True])
]
"""A pace; true is the usual one."""

MAX_KEYFRAMES = 10_000
"""Keyframes of one cut."""

POSE_KEYS = ("position", "target", "rotation_deg")
"""Keys of a keyframe that place a camera."""

DIRECTED_KEYS = ("start", "auto", "follow", "handheld")
"""Keys of a camera whose cuts a director decides; it decides the others."""

KEYFRAME_KEYS = (*POSE_KEYS, "fov_deg", "focus")
"""Keys of a keyframe that have a value."""

FRAMING_KEYS = ("view", "distance", "elevation_deg", "orbit", "dolly", "truck", "crane")
"""Keys of a camera that frames automatically."""

Focus = Annotated[float, Field(gt=0, le=1e5)] | Place | str
"""A distance [m], a point of the world, or a performer."""

FOCUS_DESCRIPTION = (
    "Focus: a performer or one of its links or nodes as bug.head, a point [x, y, z] of the "
    "world, or a distance [m]"
)


def _refuse_name(value: object) -> object:
    """Refuse a name where the camera looks at a point.

    Raises:
        ValueError: it is a name.
    """
    if isinstance(value, str):
        raise ValueError(
            f"is a point [x, y, z]; write `follow: {value}` for a camera that looks at a member of "
            "the cast"
        )
    return value


def _refuse_point(value: object) -> object:
    """Refuse a point where the camera follows members of the cast.

    Raises:
        ValueError: it is a point.
    """
    numbers = value if isinstance(value, list | tuple) else ()
    if numbers and all(isinstance(number, int | float) for number in numbers):
        point = ", ".join(f"{number:g}" for number in numbers)
        raise ValueError(
            f"names members of the cast; write `look_at: [{point}]` for a camera that looks at a "
            "point"
        )
    return value


LookedAt = Annotated[
    Place | None, BeforeValidator(_refuse_name, json_schema_input_type=Place | None)
]
"""A point [x, y, z] [m]."""

Followed = Annotated[
    str | tuple[str, ...] | None,
    BeforeValidator(_refuse_point, json_schema_input_type=str | tuple[str, ...] | None),
]
"""Members of the cast by name."""

FieldOfView = Annotated[float, Field(ge=1, le=150)]


class CameraTangent(RenderConfig):
    """Velocities of a spline at a keyframe, where they are given."""

    position: Rates | None = Field(None, description="[m/s].")
    target: Rates | None = Field(None, description="[m/s].")
    rotation_deg: Rates | None = Field(None, description="Rates of the three angles [degrees/s].")
    fov_deg: Rate | None = Field(None, description="[degrees/s].")


class CameraKey(RenderConfig):
    """Pose and lens of the camera at one time, relative to its parent or the world."""

    at: Time = Field(description="Time from the start of the film [s].")
    position: Place | None = Field(None, description="Position [x, y, z] [m].")
    target: LookedAt = Field(None, description="Point it looks at, [x, y, z] [m].")
    rotation_deg: Turn | None = Field(
        None,
        description=f"Rotation: {TURN_DESCRIPTION}; at 0 it looks along +X.",
    )
    fov_deg: FieldOfView | None = Field(None, description="Vertical field of view [degrees].")
    focus: Focus | None = Field(None, description=f"{FOCUS_DESCRIPTION}.")
    ease: Ease = Field("spline", description=HELD_EASE_DESCRIPTION)
    tangent: CameraTangent | None = Field(
        None,
        description="Velocity of the spline here; found from the neighbouring keyframes if left "
        "out, 0 at the first and the last.",
    )

    @model_validator(mode="after")
    def _check_values(self) -> Self:
        given = [key for key in KEYFRAME_KEYS if getattr(self, key) is not None]
        if not given:
            raise ValueError(f"the keyframe is empty; give one of {', '.join(KEYFRAME_KEYS)}")
        for key in KEYFRAME_KEYS:
            if getattr(self.tangent, key, None) is not None and key not in given:
                raise ValueError(f"`tangent.{key}` needs `{key}`")
        return self


class Camera(RenderConfig):
    """One cut: a camera that follows performers, stands still, or is animated by the author."""

    start: float = Field(0.0, ge=0, description="Time at which this cut starts [s].")
    follow: Followed = Field(
        None, description="Performer or performers to keep in the frame; all by default."
    )
    auto: DirectedPace | None = Field(
        None,
        description="Let a director decide the cuts from here on, by what happens: calm, natural "
        "or quick; true is natural.",
    )
    view: Side | None = Field(
        None,
        description="Side from which the camera looks, by name or in degrees from ahead of the "
        "followed, positive to their right; three-quarter by default.",
    )
    distance: float | None = Field(
        None, gt=0, le=1e5, description="Distance to the target [m]; automatic if left out."
    )
    elevation_deg: float | None = Field(
        None, ge=-89, le=89, description="Elevation of the camera; that of the view by default."
    )
    fov_deg: FieldOfView = Field(35.0, description="Vertical field of view [degrees].")
    at: Place | None = Field(
        None, description="Position [x, y, z] of the camera, in its parent or the world."
    )
    look_at: LookedAt = Field(None, description="Point [x, y, z] of the world at which it looks.")
    parent: str | None = Field(
        None,
        min_length=1,
        max_length=200,
        description="Part that carries it: a performer, or one of its links or nodes as bug.head; "
        "it looks ahead from there unless it has a target.",
    )
    keyframes: Annotated[tuple[CameraKey, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
        (), description="Position, target, rotation, field of view and focus at certain times."
    )
    velocity: Rates | None = Field(
        None, description="Velocity, from `at` at the start of the cut [m/s]."
    )
    rotation_deg: Turn | None = Field(
        None,
        description=f"Rotation, instead of a target: {TURN_DESCRIPTION}; at 0 it looks along +X.",
    )
    spin_deg: Rates | None = Field(
        None,
        description="Angular velocity about x, y and z of its parent or the world, from its "
        "rotation_deg at the start of the cut [degrees/s].",
    )
    steady: float = Field(
        0.0,
        ge=0,
        le=60,
        description="Time over which the motion of its parent is smoothed [s].",
    )

    orbit: OrbitField | None = Field(
        None, description="Turn about the target: degrees per second, [from, to], or in full."
    )
    dolly: DollyField | None = Field(
        None,
        description="Move towards the target: metres per second, distances [from, to], or in full.",
    )
    truck: TruckField | None = Field(
        None, description="Move to the right: metres per second, [from, to] in metres, or in full."
    )
    crane: CraneField | None = Field(
        None,
        description="Rise: metres per second, heights [from, to] over the ground, or in full.",
    )
    lead: float | None = Field(
        None,
        ge=-0.5,
        le=0.5,
        description="Lead room: offset of a moving performer from the centre, as a fraction of "
        "the frame; 0.1 by default.",
    )
    aperture: float | None = Field(
        None,
        ge=0.05,
        le=64,
        description="F-number of the lens on a sensor of 36 x 24 mm: the smaller, the shallower "
        "the depth of field. All is sharp if left out.",
    )
    focus: Focus | None = Field(None, description=f"{FOCUS_DESCRIPTION}; the target if left out.")
    handheld: Unit = Field(
        0.0,
        description="Shake of a camera that a person holds: 0.3 is slight, 1 that of a run.",
    )

    @model_validator(mode="after")
    def _check_conflicts(self) -> Self:
        conflicts = itertools.chain(
            self._direction_conflicts(),
            self._pose_conflicts(),
            self._move_conflicts(),
            self._lens_conflicts(),
        )
        if (conflict := next(conflicts, None)) is not None:
            raise ValueError(conflict)
        return self

    @property
    def is_animated(self) -> bool:
        """Whether the author moves it, by keyframes, velocity or a parent."""
        own = (self.parent, self.velocity, self.rotation_deg, self.spin_deg)
        keyed = (getattr(key, name) for key in self.keyframes for name in POSE_KEYS)
        return any(value is not None for value in (*own, *keyed))

    def _given(self, keys: tuple[str, ...]) -> list[str]:
        return [key for key in keys if getattr(self, key) is not None]

    def _is_keyed(self, *keys: str) -> bool:
        """Return whether any keyframe gives one of these keys."""
        return any(getattr(frame, key) is not None for frame in self.keyframes for key in keys)

    def _direction_conflicts(self) -> Iterator[str]:
        if self.auto is None:
            return
        # Defaults that are written out are those of the director as well.
        fields = type(self).model_fields
        given = [
            key
            for key in fields
            if key not in DIRECTED_KEYS and getattr(self, key) != fields[key].default
        ]
        if given:
            yield f"`auto` conflicts with {_listing(given)}; a director decides them, remove one"

    def _pose_conflicts(self) -> Iterator[str]:
        framing = self._given(FRAMING_KEYS)
        if self.at is not None and framing:
            yield f"`at` conflicts with {_listing(framing)}; remove one"
        yield from self._animation_conflicts(framing)
        if self.look_at is not None and self.follow is not None:
            yield "`follow` conflicts with `look_at`; remove one"
        if self.at is not None and self.at == self.look_at:
            yield "`look_at` equals `at`; move one of them"

    def _animation_conflicts(self, framing: list[str]) -> Iterator[str]:
        if any(b.at < a.at for a, b in itertools.pairwise(self.keyframes)):
            yield "keyframes are not in the order of time; sort them by `at`"
        if not self.is_animated:
            if self.steady:
                yield "`steady` needs a `parent`"
            return
        if framing:
            yield (
                f"{_listing(framing)} conflicts with a camera that is animated by parent, "
                "velocity, rotation or keyframes; remove one"
            )
        has_positions = self._is_keyed("position")
        if self.at is None and not has_positions:
            yield "an animated camera needs a position; give `at` or `position` in its keyframes"
        if self.at is not None and has_positions:
            yield "`at` conflicts with `position` in keyframes; remove one"
        if self.velocity is not None and self.keyframes:
            yield "`velocity` conflicts with `keyframes`; remove one"
        aims = self._given(("look_at", "follow"))
        aims += [f"{key} in keyframes" for key in ("target", "rotation_deg") if self._is_keyed(key)]
        if self.rotation_deg is not None or self.spin_deg is not None:
            aims.append("rotation_deg or spin_deg")
        if len(aims) > 1:
            yield f"the direction is given by {_listing(aims)}; keep one"

    def _move_conflicts(self) -> Iterator[str]:
        if self.view == "top" and (
            given := self._given(("elevation_deg", "orbit", "truck", "crane"))
        ):
            yield f"`view: top` conflicts with {_listing(given)}; remove one"
        if self.lead is not None and (self.look_at is not None or self.is_animated):
            other = "`look_at`" if self.look_at is not None else "an animated camera"
            yield f"`lead` conflicts with {other}; remove one"
        if self.dolly is not None and self.dolly.start is not None and self.distance is not None:
            yield "`distance` conflicts with the distances of `dolly`; remove one"
        if self.crane is not None and self.crane.start is not None:
            if self.elevation_deg is not None:
                yield "`elevation_deg` conflicts with the heights of `crane`; remove one"
            if self.orbit is not None and self.orbit.rise_deg:
                yield "`orbit.rise_deg` conflicts with the heights of `crane`; remove one"
        if self.dolly is not None and self.dolly.zoom and self._is_keyed("fov_deg"):
            yield "`dolly.zoom` conflicts with `fov_deg` in keyframes; remove one"

    def _lens_conflicts(self) -> Iterator[str]:
        is_keyed = self._is_keyed("focus")
        if self.focus is not None and is_keyed:
            yield "`focus` conflicts with `focus` in keyframes; remove one"
        if self.aperture is None:
            if self.focus is not None or is_keyed:
                yield "`focus` needs an `aperture`, such as 2.8; without one all is sharp"
            return
        is_turned = self.rotation_deg is not None or self.spin_deg is not None
        is_turned |= self._is_keyed("rotation_deg")
        has_target = bool(self._given(("look_at", "follow"))) or self._is_keyed("target")
        is_aimless = is_turned or (self.parent is not None and not has_target)
        if is_aimless and self.focus is None and not is_keyed:
            yield "a camera with an `aperture` and no target needs a `focus`"


def _listing(keys: list[str]) -> str:
    return " and ".join(f"`{key}`" for key in keys)


def _as_sequence(value: object) -> object:
    if value == AUTO:
        return ({AUTO: "natural"},)
    if isinstance(value, str):
        raise ValueError(
            f"no camera is called '{value}', did you mean '{AUTO}'? Others are mappings, such as "
            "{follow: bug}"
        )
    return value if isinstance(value, list | tuple) else (value,)


def _check_starts(value: tuple[Camera, ...]) -> tuple[Camera, ...]:
    if not value or value[0].start != 0:
        raise ValueError("the first cut must start at 0")
    if any(b.start <= a.start for a, b in itertools.pairwise(value)):
        raise ValueError("each cut must start later than the one before")
    return value


Cuts = Annotated[
    tuple[Camera, ...],
    BeforeValidator(_as_sequence, json_schema_input_type=Literal["auto"] | Camera | list[Camera]),
    AfterValidator(_check_starts),
]
"""One camera, or a list of cuts, the first of which starts at 0; or `auto`."""

_CUTS: TypeAdapter[tuple[Camera, ...]] = TypeAdapter(Cuts)


def cuts(
    value: str | Mapping[str, Any] | Camera | list[Mapping[str, Any] | Camera],
) -> tuple[Camera, ...]:
    """Return the cuts of a value in a scene, in order of time.

    Raises:
        ValueError: a value is out of range, or the cuts are not in order from 0.
    """
    return _CUTS.validate_python(value)
