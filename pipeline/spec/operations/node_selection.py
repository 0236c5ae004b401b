"""Node selection: the nodes that operations work on, by name, by selection or by an outline.

Source: Sims 1987, A.1 (select all, unselect all, a previously selected set, a circled set).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from pipeline.spec.model_base import Fault, Name, PathSegment, Point
from pipeline.spec.operations.drawing import At, DrawingOperation, Sheet, unknown_nodes

Names = Annotated[tuple[Name, ...], Field(min_length=1)]


def _nodes_form(value: Any) -> str:
    return "by a word" if isinstance(value, str) else "by name"


Chosen = Annotated[
    Annotated[Names, Tag("by name")] | Annotated[Literal["selected", "all"], Tag("by a word")],
    Discriminator(_nodes_form),
]
"""A list of names; `selected`, what the last `select` chose; or `all`."""

Picked = tuple[str, tuple[PathSegment, ...]]
"""A node, and the path at which the operation names it."""


def chosen(
    nodes: tuple[str, ...] | str, sheet: Sheet, path: tuple[PathSegment, ...]
) -> tuple[list[Picked], list[Fault]]:
    """Return the chosen nodes that exist, each once, and the faults of the choice.

    Args:
        nodes: names, or a word.
        sheet: the drawing.
        path: of the choice below the operation.
    """
    if isinstance(nodes, str):
        names = tuple(sheet.marks) if nodes == "all" else sheet.selected
        empty = "no node is selected here; write a select before it"
        return [(name, path) for name in names], ([] if names else [Fault(path, empty)])
    faults = [*unknown_nodes(nodes, sheet.marks, path), *_repeated(nodes, path)]
    first = {name: k for k, name in reversed(list(enumerate(nodes))) if name in sheet.marks}
    return [(name, (*path, first[name])) for name in dict.fromkeys(nodes) if name in first], faults


def _repeated(nodes: tuple[str, ...], path: tuple[PathSegment, ...]) -> Iterator[Fault]:
    for k, name in enumerate(nodes):
        if name in nodes[:k]:
            yield Fault((*path, k), f"node '{name}' is listed twice")


Outline = Annotated[tuple[Point, ...], Field(min_length=3, max_length=1000)]


def _selection_form(value: Any) -> str:
    if isinstance(value, str):
        return "by a word"
    is_outline = isinstance(value, Sequence) and value and not isinstance(value[0], str)
    return "by an outline" if is_outline else "by name"


class Select(DrawingOperation):
    """Selects nodes, which later operations call `selected`."""

    select: Annotated[
        Annotated[Names, Tag("by name")]
        | Annotated[Outline, Tag("by an outline")]
        | Annotated[Literal["all", "none", "previous"], Tag("by a word")],
        Discriminator(_selection_form),
    ] = Field(
        description="Names; an outline [[x, y], ...] around the nodes; all; none; or previous, "
        "the set that was selected before the present one."
    )

    def apply(self, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
        """Return the drawing with another selection, and the faults."""
        match self.select:
            case "none":
                return replace(sheet, present=-1), []
            case "previous":
                return _previous(sheet)
            case str():
                return _selected(sheet, tuple(sheet.marks)), []
            case (str(), *_):
                names = tuple(name for name in self.select if isinstance(name, str))
                picked, faults = chosen(names, sheet, ("select",))
                return _selected(sheet, tuple(name for name, _ in picked)), faults
        outline: list[At] = [at for at in self.select if not isinstance(at, str)]
        inside = tuple(name for name, mark in sheet.marks.items() if encloses(outline, mark.at))
        faults = [] if inside else [Fault(("select",), "there is no node inside this outline")]
        return _selected(sheet, inside), faults


def _previous(sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Return the drawing with the selection before the present one, in a ring."""
    if not sheet.sets:
        return sheet, [Fault(("select",), "nothing was selected before")]
    # After `none` the previous selection is the latest.
    before = sheet.present - 1 if sheet.present >= 0 else len(sheet.sets) - 1
    return replace(sheet, present=before % len(sheet.sets)), []


def _selected(sheet: Sheet, names: tuple[str, ...]) -> Sheet:
    sets = (*sheet.sets, names)
    return replace(sheet, sets=sets, present=len(sets) - 1)


def encloses(outline: Sequence[At], point: At) -> bool:
    """Return whether an outline winds around a point; points on the outline belong to it.

    The angles under which the point sees the outline's corners add up to a whole number of
    turns: none outside. The outline may be concave and may run either way. Where it winds
    around a point twice, as inside a pentagram, the point is inside.

    Args:
        outline: corners [m]; the last is joined to the first.
        point: the point [m].

    Source: Sims 1987, eq. A.1, where each difference of angles must be wrapped into (-π, π]:
    as printed, the sum of differences around a closed outline is always 0.
    """
    x, y = point
    seen = [(a - x, b - y) for a, b in outline]
    total = 0.0
    for (ax, ay), (bx, by) in pairwise([*seen, seen[0]]):
        cross, dot = ax * by - ay * bx, ax * bx + ay * by
        if cross == 0.0 and dot <= 0.0:
            return True
        # The wrapped difference of the two angles, without taking either.
        total += math.atan2(cross, dot)
    return abs(total) > math.pi
