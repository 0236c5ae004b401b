"""Transformation: how a set of nodes is moved, or where its copies go.

What one operation says is done in this order: mirror, scale, rotate, translate.

Source: Sims 1987, A.1.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from pipeline.spec.model_base import ConfigModel, Fault, Name, Number, Point
from pipeline.spec.operations.drawing import At, Mark, Sheet
from pipeline.spec.suggestions import hint

Axis = Literal["x", "y"]
Factor = Annotated[Number, Field(ge=1e-3, le=1e3)]
Degrees = Annotated[Number, Field(ge=-3600, le=3600)]


def _form(words: Any) -> str:
    return "a node" if isinstance(words, str) else "a place"


Centre = Annotated[
    Annotated[Name, Tag("a node")] | Annotated[Point, Tag("a place")], Discriminator(_form)
]


class Transformation(ConfigModel):
    """What moves a set of nodes."""

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


MOVES = ("mirror", "scale", "scale_xy", "rotate_deg", "rotate_abs_deg", "translate")


def faults_of_transformation(words: Transformation, sheet: Sheet) -> list[Fault]:
    """Find what keeps a transformation from being one."""
    if all(getattr(words, word) is None for word in MOVES):
        return [Fault((), f"says not where to; give one of {', '.join(MOVES)}")]
    if isinstance(words.about, str) and words.about not in sheet.marks:
        message = f"no node is called '{words.about}', {hint(words.about, sheet.marks)}"
        return [Fault(("about",), message)]
    return []


def transformed(words: Transformation, marks: Collection[Mark], sheet: Sheet) -> list[Mark]:
    """Return nodes where a transformation puts them.

    Args:
        words: without faults.
        marks: the nodes as they lie, at least one.
        sheet: holds the node that `about` may name.
    """
    centre = _centre(words.about, marks, sheet)
    sx, sy = words.scale_xy or (1.0, 1.0)
    even = words.scale or 1.0
    moved = []
    for mark in marks:
        at = mirrored_point(mark.at, words.mirror) if words.mirror else mark.at
        x, y = at[0] - centre[0], at[1] - centre[1]
        x, y = turned((x * even * sx, y * even * sy), words.rotate_deg or 0.0)
        x, y = turned((x + centre[0], y + centre[1]), words.rotate_abs_deg or 0.0)
        dx, dy = words.translate or (0.0, 0.0)
        size = mark.size * even * math.sqrt(sx * sy)
        moved.append(replace(mark, at=(x + dx, y + dy), size=size))
    return moved


def mirrored_point(at: At, axis: Axis) -> At:
    """Return the place of a copy [m]."""
    x, y = at
    return (-x, y) if axis == "x" else (x, -y)


def turned(at: At, degrees: float) -> At:
    """Return a place turned about the origin, from the right by the head to the left."""
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
