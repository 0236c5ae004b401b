"""Transformation of a set of nodes or of their copies: mirror, scale, rotate, translate, in order.

Source: Sims 1987, A.1.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from pipeline.spec.model_base import Fault, Name, Number, Point
from pipeline.spec.operations.drawing import At, DrawingOperation, Mark, Sheet
from pipeline.spec.suggestions import hint

Axis = Literal["x", "y"]
Factor = Annotated[Number, Field(ge=1e-3, le=1e3)]
Degrees = Annotated[Number, Field(ge=-3600, le=3600)]


def _form(value: Any) -> str:
    return "a node" if isinstance(value, str) else "a place"


Centre = Annotated[
    Annotated[Name, Tag("a node")] | Annotated[Point, Tag("a place")], Discriminator(_form)
]


class Transformation(DrawingOperation):
    """Keys that move a set of nodes."""

    mirror: Axis | None = Field(
        None, description="The coordinate that changes its sign, x or y, from the drawing's axis."
    )
    scale: Factor | None = Field(
        None, description="Factor on the distances from `about`, and on the nodes' radii."
    )
    scale_xy: tuple[Factor, Factor] | None = Field(
        None, description="Factors along x and along y; radii grow by their geometric mean."
    )
    rotate_deg: Degrees | None = Field(
        None, description="Turn about `about`, positive to the left as seen from above [degrees]."
    )
    rotate_abs_deg: Degrees | None = Field(
        None,
        description="Turn about the drawing's origin, where its axes meet, positive to the left "
        "[degrees].",
    )
    translate: Point | None = Field(
        None, description="Way along x, to the right, and y, towards the tail [m]."
    )
    about: Centre | None = Field(
        None,
        description="What `scale` and `rotate_deg` leave in place, a node or [x, y]; the middle "
        "of the nodes if left out.",
    )


MOTION_KEYS = ("mirror", "scale", "scale_xy", "rotate_deg", "rotate_abs_deg", "translate")


def faults_of_transformation(transformation: Transformation, sheet: Sheet) -> list[Fault]:
    """Find that a transformation moves nothing, or about a node that does not exist."""
    if all(getattr(transformation, key) is None for key in MOTION_KEYS):
        return [Fault((), f"moves nothing; give one of {', '.join(MOTION_KEYS)}")]
    if isinstance(transformation.about, str) and transformation.about not in sheet.marks:
        message = (
            f"no node is called '{transformation.about}', {hint(transformation.about, sheet.marks)}"
        )
        return [Fault(("about",), message)]
    return []


def transformed(
    transformation: Transformation, marks: Collection[Mark], sheet: Sheet
) -> list[Mark]:
    """Return nodes at their transformed positions.

    Args:
        transformation: one without faults.
        marks: the nodes, at least one.
        sheet: holds the node that `about` may name.
    """
    centre = _centre(transformation.about, marks, sheet)
    sx, sy = transformation.scale_xy or (1.0, 1.0)
    even = transformation.scale or 1.0
    moved = []
    for mark in marks:
        at = mirrored_point(mark.at, transformation.mirror) if transformation.mirror else mark.at
        x, y = at[0] - centre[0], at[1] - centre[1]
        x, y = turned((x * even * sx, y * even * sy), transformation.rotate_deg or 0.0)
        x, y = turned((x + centre[0], y + centre[1]), transformation.rotate_abs_deg or 0.0)
        dx, dy = transformation.translate or (0.0, 0.0)
        size = mark.size * even * math.sqrt(sx * sy)
        moved.append(replace(mark, at=(x + dx, y + dy), size=size))
    return moved


def mirrored_point(at: At, axis: Axis) -> At:
    """Return the mirrored position [m]."""
    x, y = at
    return (-x, y) if axis == "x" else (x, -y)


def turned(at: At, degrees: float) -> At:
    """Return a position turned about the origin, from the right by the head to the left."""
    quarter, rest = divmod(degrees, 90.0)
    # Quarter turns are exact, so that what lies on an axis comes to lie on an axis.
    x, y = at
    for _ in range(int(quarter) % 4):
        x, y = y, -x
    c, s = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    return c * x + s * y, c * y - s * x


def _centre(about: str | At | None, marks: Collection[Mark], sheet: Sheet) -> At:
    if isinstance(about, str):
        return sheet.marks[about].at
    if about is not None:
        return about
    n = len(marks)
    return sum(mark.at[0] for mark in marks) / n, sum(mark.at[1] for mark in marks) / n
