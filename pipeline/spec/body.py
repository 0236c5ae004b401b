"""Body: a rigid thing that falls, bounces and rolls; its shape and what it is made of."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.values import Length, LengthOrZero, Number, Place, Whole, Words

AROUND_IT = "Diameter of the sphere around it [m]."


class Matter(Words):
    """What every body has, whatever its shape."""

    density: Annotated[Number, Field(gt=0, le=30_000)] = Field(600.0, description="[kg/m³].")
    bounciness: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.4,
        description="Speed after / before an impact: 0 stays down, 1 comes back as high. What "
        "approaches at less than 0.05 m/s does not bounce.",
    )
    friction: Annotated[Number, Field(ge=0, le=10)] = Field(
        0.5, description="Coulomb's coefficient; 0 is ice."
    )
    rolling: Annotated[Number, Field(ge=0, le=1)] = Field(
        0.01, description="How far before its middle the ground bears what rolls, in its size."
    )
    collide: Literal["terrain", "all"] = Field(
        "terrain",
        description="What it meets: terrain is the ground alone; all is the ground, creatures, "
        "props, characters, and other bodies of which this is said.",
    )
    inertia: Literal["tensor", "scalar"] = Field(
        "tensor",
        description="tensor tumbles as bodies do; scalar takes one moment of inertia for every "
        "axis, the mean.",
    )
    soft: Annotated[LengthOrZero, Field(le=1)] = Field(
        0.0,
        description="How long the ground pushes it back at an impact, while it sinks in [s]; 0 "
        "is rigid.",
    )

    @model_validator(mode="after")
    def _meets_as_it_can(self) -> Self:
        if self.collide == "all" and self.soft > 0.0:
            message = "goes with collide: terrain; what meets all is rigid, take this away"
            refuse([Fault(("soft",), message, at_key=True)])
        return self


class Box(Matter):
    """A box about its middle."""

    shape: Literal["box"] = Field(description="A box.")
    size: tuple[Length, Length, Length] = Field(
        (0.3, 0.3, 0.3), description="Its extent along x, y and z [m]."
    )


class Brick(Matter):
    """A brick: a box that lies."""

    shape: Literal["brick"] = Field(description="A brick.")
    size: tuple[Length, Length, Length] = Field(
        (0.24, 0.071, 0.115), description="Its extent along x, y and z [m]."
    )
    density: Annotated[Number, Field(gt=0, le=30_000)] = Field(1800.0, description="[kg/m³].")


class Cube(Matter):
    """A cube; as a die it has pips, opposite ones adding up to seven."""

    shape: Literal["cube", "die"] = Field(description="A cube, or one with pips.")
    size: Length = Field(0.3, description="Length of its edges [m].")


class Regular(Matter):
    """A regular solid."""

    shape: Literal["tetrahedron", "octahedron", "dodecahedron", "icosahedron"] = Field(
        description="A regular solid of 4, 8, 12 or 20 faces."
    )
    size: Length = Field(0.4, description=AROUND_IT)


class Upright(Matter):
    """A prism or a pyramid over a regular polygon."""

    shape: Literal["prism", "pyramid"] = Field(
        description="Upright over a regular polygon; a pyramid ends in a point."
    )
    sides: Annotated[Whole, Field(ge=3, le=48)] = Field(6, description="Sides of the polygon.")
    radius: Length = Field(0.2, description="Of the circle around the polygon [m].")
    height: Length = Field(0.4, description="Its height [m].")


class Sphere(Matter):
    """A ball."""

    shape: Literal["sphere"] = Field(description="A ball.")
    radius: Length = Field(0.2, description="Its radius [m].")


class HullBody(Matter):
    """The convex hull of points."""

    shape: Literal["hull"] = Field(description="The convex hull of points.")
    points: Annotated[tuple[Place, ...], Field(min_length=4, max_length=1000)] = Field(
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


BodyWords = Annotated[
    Box | Brick | Cube | Regular | Upright | Sphere | HullBody | MeshBody,
    Field(discriminator="shape"),
]
