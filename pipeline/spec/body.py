"""Bodies: rigid things that fall, bounce and roll, alone or many in a layout."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError, model_validator

from pipeline.spec.hold import Hold, faults_of_holds
from pipeline.spec.keyframes import Turn
from pipeline.spec.model_base import (
    ConfigModel,
    Fault,
    Integer,
    Length,
    LengthOrZero,
    MaterialName,
    Number,
    Point,
    Position,
    Positive,
    raise_faults,
)
from pipeline.spec.performer import MAX_KEYFRAMES, At, Performer, Velocity
from render.config.base import TURN_DESCRIPTION

AROUND_IT = "Diameter of the sphere around it [m]."


class Matter(ConfigModel):
    """What every body has besides its shape."""

    density: Annotated[Positive, Field(le=30_000)] = Field(600.0, description="[kg/m³].")
    bounciness: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.4,
        description="Speed after / before an impact: 0 stays down, 1 comes back as high. Below "
        "0.05 m/s there is no bounce.",
    )
    friction: Annotated[Number, Field(ge=0, le=10)] = Field(
        0.5, description="Coulomb's coefficient; 0 is ice."
    )
    rolling: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.01,
        description="Rolling resistance: lever arm of the ground's force, in its size.",
    )
    collide: Literal["terrain", "all"] = Field(
        "terrain",
        description="What it collides with: terrain is the ground alone; all is the ground, "
        "creatures, props, characters, and other bodies with collide: all.",
    )
    inertia: Literal["tensor", "scalar"] = Field(
        "tensor",
        description="tensor tumbles as bodies do; scalar takes one moment of inertia for every "
        "axis, the mean.",
    )
    soft: Annotated[LengthOrZero, Field(le=1)] = Field(
        0.0,
        description="Duration of an impact on the ground, while it sinks in [s]; 0 is rigid.",
    )

    @model_validator(mode="after")
    def _check_collide(self) -> Self:
        if self.collide == "all" and self.soft > 0.0:
            message = "needs collide: terrain; remove this, bodies that meet all are rigid"
            raise_faults([Fault(("soft",), message, at_key=True)])
        return self


def faults_of_hollow(wall: float | None, least: float) -> list[Fault]:
    """Return what is wrong with the wall of a hollow body [m] whose least extent is given [m]."""
    if wall is None or 2.0 * wall < least:
        return []
    message = f"leaves no cavity; write less than {least / 2.0:g}, or remove this"
    return [Fault(("hollow",), message)]


HOLLOW = (
    "Thickness of its wall, if it is closed and hollow [m]; solid if left out. It changes the "
    "sound; mass is density times the whole volume."
)


class Hollow(Matter, ABC):
    """Matter that may have a cavity."""

    hollow: Length | None = Field(None, description=HOLLOW)

    @model_validator(mode="after")
    def _check_wall(self) -> Self:
        raise_faults(faults_of_hollow(self.hollow, self.least_extent))
        return self

    @property
    @abstractmethod
    def least_extent(self) -> float:
        """The least of its extents [m]."""


class Box(Hollow):
    """A box about its middle."""

    shape: Literal["box"] = Field(description="A box.")
    size: tuple[Length, Length, Length] = Field(
        (0.3, 0.3, 0.3), description="Its extent along x, y and z [m]."
    )

    @property
    def least_extent(self) -> float:
        """The least of its extents [m]."""
        return min(self.size)


class Brick(Hollow):
    """A brick: a box that lies."""

    shape: Literal["brick"] = Field(description="A brick.")
    size: tuple[Length, Length, Length] = Field(
        (0.24, 0.071, 0.115), description="Its extent along x, y and z [m]."
    )
    density: Annotated[Positive, Field(le=30_000)] = Field(1800.0, description="[kg/m³].")

    @property
    def least_extent(self) -> float:
        """The least of its extents [m]."""
        return min(self.size)


class Cube(Hollow):
    """A cube; as a die it has pips, opposite ones adding up to seven."""

    shape: Literal["cube", "die"] = Field(description="A cube, or one with pips.")
    size: Length = Field(0.3, description="Length of its edges [m].")

    @property
    def least_extent(self) -> float:
        """The least of its extents [m]."""
        return self.size


class Regular(Matter):
    """A regular solid."""

    shape: Literal["tetrahedron", "octahedron", "dodecahedron", "icosahedron"] = Field(
        description="A regular solid of 4, 8, 12 or 20 faces."
    )
    size: Length = Field(0.4, description=AROUND_IT)


class Upright(Hollow):
    """A prism or a pyramid over a regular polygon."""

    shape: Literal["prism", "pyramid"] = Field(
        description="Upright over a regular polygon; a pyramid ends in a point."
    )
    sides: Annotated[Integer, Field(ge=3, le=48)] = Field(6, description="Sides of the polygon.")
    radius: Length = Field(0.2, description="Of the circle around the polygon [m].")
    height: Length = Field(0.4, description="Its height [m].")

    @property
    def least_extent(self) -> float:
        """The least of its extents [m]."""
        return min(self.height, 2.0 * self.radius * math.cos(math.pi / self.sides))


class Sphere(Hollow):
    """A ball."""

    shape: Literal["sphere"] = Field(description="A ball.")
    radius: Length = Field(0.2, description="Its radius [m].")

    @property
    def least_extent(self) -> float:
        """The least of its extents [m]."""
        return 2.0 * self.radius


class HullBody(Matter):
    """The convex hull of points."""

    shape: Literal["hull"] = Field(description="The convex hull of points.")
    points: Annotated[tuple[Position, ...], Field(min_length=4, max_length=1000)] = Field(
        description="Points [x, y, z], wherever their origin is [m]."
    )


class MeshBody(Matter):
    """The convex hull of a mesh."""

    shape: Literal["mesh"] = Field(description="The convex hull of a mesh.")
    file: str = Field(
        min_length=1,
        max_length=1000,
        description="An OBJ or PLY mesh, named from the scene's folder.",
    )
    scale: Length = Field(1.0, description="Metres a unit of the file.")


BodyShape = Annotated[
    Box | Brick | Cube | Regular | Upright | Sphere | HullBody | MeshBody,
    Field(discriminator="shape"),
]


MAX_BODIES = 5_000
"""Bodies of one member of the cast."""

Count = Annotated[Integer, Field(ge=1, le=MAX_BODIES)]

ShapeName = Literal[
    "box",
    "brick",
    "cube",
    "die",
    "tetrahedron",
    "octahedron",
    "dodecahedron",
    "icosahedron",
    "prism",
    "pyramid",
    "sphere",
]


def _body_from_name(value: Any) -> Any:
    """Return a body given by the name of its shape, or in full; it collides with all."""
    if isinstance(value, str):
        value = {"shape": value}
    return {"collide": "all", **value} if isinstance(value, Mapping) else value


OfWhat = Annotated[
    BodyShape, BeforeValidator(_body_from_name, json_schema_input_type=ShapeName | BodyShape)
]


class Arrangement(ConfigModel, ABC):
    """What all arrangements have."""

    of: OfWhat = Field(
        description="Shape and matter of each: a shape by its name, or a body in full."
    )
    materials: tuple[MaterialName, ...] = Field(
        (),
        max_length=100,
        description="Each has one of these, by chance; if none are given, that of all.",
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.of.collide != "all":
            message = "bodies of `many` collide with one another; remove this"
            raise_faults([Fault(("of", "collide"), message)])
        if self.total > MAX_BODIES:
            raise_faults([Fault((), f"makes {self.total} bodies, where {MAX_BODIES} are the most")])
        return self

    @property
    @abstractmethod
    def total(self) -> int:
        """How many bodies there are."""


class Wall(Arrangement):
    """A wall in running bond, about its middle."""

    layout: Literal["wall"] = Field(
        "wall",
        description="A wall along its x; every other row is moved by not quite half a body.",
    )
    rows: Count = Field(6, description="How high it is, in bodies.")
    columns: Count = Field(8, description="How long it is, in bodies.")
    gap: LengthOrZero = Field(0.002, description="Between neighbours of a row [m].")

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.rows * self.columns


class Pyramid(Arrangement):
    """A wall whose rows become shorter by one body."""

    layout: Literal["pyramid"] = Field(
        description="A wall along its x, each row shorter by one body."
    )
    rows: Annotated[Integer, Field(ge=1, le=100)] = Field(
        6, description="How high it is, and how long at the ground, in bodies."
    )
    gap: LengthOrZero = Field(0.01, description="Between neighbours of a row [m].")

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.rows * (self.rows + 1) // 2


class Stack(Arrangement):
    """One on top of another."""

    layout: Literal["stack"] = Field(description="One on top of another.")
    count: Count = Field(10, description="How many there are.")

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.count


class Row(Arrangement):
    """One after another, each on the ground and looking along the row."""

    layout: Literal["row"] = Field(description="One after another, as dominoes.")
    count: Count = Field(20, description="How many there are.")
    spacing: Length = Field(0.15, description="From middle to middle along the row [m].")
    along: Annotated[tuple[Point, ...], Field(max_length=1000)] = Field(
        (),
        description="Places [x, z] that the row passes smoothly after `at`, relative to it and "
        "its heading; straight along its x, and beyond the last one, if left out.",
    )

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.count


class Heap(Arrangement):
    """Turned at random above one another, so that they fall on a heap."""

    layout: Literal["heap"] = Field(description="Loose in the air, to fall on a heap.")
    count: Count = Field(40, description="How many there are.")
    radius: Length = Field(0.6, description="Of the column of air that they fall in [m].")
    above: LengthOrZero = Field(0.3, description="From the ground to the lowest of them [m].")

    @property
    def total(self) -> int:
        """How many bodies there are."""
        return self.count


def _with_layout(value: Any) -> Any:
    """Return bodies with their layout, a wall by default."""
    return {"layout": "wall", **value} if isinstance(value, Mapping) else value


Layout = Annotated[
    Wall | Pyramid | Stack | Row | Heap,
    Field(discriminator="layout"),
    BeforeValidator(_with_layout),
]


_LAYOUT: TypeAdapter[Arrangement] = TypeAdapter(Layout)


def body_count(many: object) -> int:
    """Return how many bodies a layout makes, typed or raw; the most that may be, of a wrong one."""
    try:
        return _LAYOUT.validate_python(many).total
    except ValidationError:
        return MAX_BODIES


class Body(Performer):
    """A rigid body that falls, bounces and rolls."""

    body: BodyShape = Field(description="Its shape and matter.")
    at: At = Field(
        (0.0, 0.0),
        description="Centre of mass at the start, [x, y, z]; [x, z] puts it on the ground [m].",
    )
    rotation_deg: Turn = Field(
        (0.0, 0.0, 0.0),
        description=f"Its rotation at the start, before its heading: {TURN_DESCRIPTION}.",
    )
    velocity: Velocity = Field((0.0, 0.0, 0.0), description="At the start, [x, y, z] [m/s].")
    spin_deg: Turn = Field(
        (0.0, 0.0, 0.0),
        description="Its spin at the start, about x, y and z of the world [degrees/s].",
    )
    held: Annotated[tuple[Hold, ...], Field(max_length=MAX_KEYFRAMES)] = Field(
        (), description="Hands that hold it, and when; released it moves on as the hand did."
    )

    @model_validator(mode="after")
    def _check_holds(self) -> Self:
        raise_faults(list(faults_of_holds(self.held)))
        if self.held and self.body.soft > 0.0:
            message = "conflicts with soft; what hands hold is rigid"
            raise_faults([Fault(("held",), message, at_key=True)])
        return self

    @model_validator(mode="after")
    def _check_parent(self) -> Self:
        if self.parent is not None:
            message = "a body moves by itself; remove parent, or write a prop"
            raise_faults([Fault(("parent",), message, at_key=True)])
        return self

    @property
    def kind_name(self) -> str:
        """Name of a member that is given none."""
        return self.body.shape


class Many(Performer):
    """Bodies of one kind that start in a layout and collide with all."""

    many: Layout = Field(description="Kind, number and layout of the bodies.")
    at: At = Field(
        (0.0, 0.0),
        description="The middle of the ground that they stand on, or where their row begins, "
        "[x, z]; [x, y, z] with the height that they stand at [m].",
    )
    velocity: Velocity = Field((0.0, 0.0, 0.0), description="At the start, [x, y, z] [m/s].")

    @model_validator(mode="after")
    def _check_parent(self) -> Self:
        if self.parent is not None:
            message = "bodies move by themselves; remove parent"
            raise_faults([Fault(("parent",), message, at_key=True)])
        return self

    @property
    def kind_name(self) -> str:
        """Name of a member that is given none."""
        return self.many.layout
