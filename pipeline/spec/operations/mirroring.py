"""Mirror: copies of nodes on the other side of an axis of the drawing.

Source: Sims 1987, A.1, "mirror X", "mirror Y".
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

from pydantic import Field, Strict

from pipeline.spec.faults import Fault
from pipeline.spec.operations.chosen import Chosen, Picked, chosen
from pipeline.spec.operations.sheet import At, Sheet, copied_connections, fault_of_room
from pipeline.spec.values import Words

ON_AXIS = 1e-9
"""A node no farther than this from the axis lies on it [m]."""

Axis = Literal["x", "y"]


class Mirror(Words):
    """Copies nodes to the other side; what lies on the axis is not copied."""

    mirror: Axis = Field(
        description="The coordinate that changes its sign: x copies left to right, y front to back."
    )
    nodes: Chosen | None = Field(
        None,
        description="The nodes to copy, by name, or `selected`; all that do not lie on the axis "
        "if left out.",
    )
    suffix: Annotated[str, Strict(), Field(pattern=r"^[\w\-]+$", max_length=16)] = Field(
        "_m",
        description="Ends the name of a copy, unless the name ends in _l or _r: those are swapped.",
    )


def mirrored_name(name: str, suffix: str = "_m") -> str:
    """Return the name of a node's copy: `_l` and `_r` are swapped, other names get the suffix."""
    if name.endswith("_l"):
        return name[:-2] + "_r"
    if name.endswith("_r"):
        return name[:-2] + "_l"
    return name + suffix


def mirrored_point(at: At, axis: Axis) -> At:
    """Return the place of a copy [m]."""
    x, y = at
    return (-x, y) if axis == "x" else (x, -y)


def mirror(words: Mirror, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Return the sheet with the copies that can be made, and what is wrong with the others."""
    originals, faults = _originals(words, sheet)
    crowded = fault_of_room(sheet, len(originals), "mirror")
    if crowded:
        return sheet, [crowded]
    twin: dict[str, str] = {}
    made: set[str] = set()
    for name, path in originals:
        copy = mirrored_name(name, words.suffix)
        if _on_axis(sheet.marks[name].at, words.mirror):
            message = f"node '{name}' lies on the axis, its copy would lie on itself"
        elif copy in sheet.marks or copy in made:
            message = f"the copy of '{name}' would be called '{copy}', and there is one already"
            message += "; list the nodes to copy" if words.nodes is None else ""
        else:
            twin[name] = copy
            made.add(copy)
            continue
        faults.append(Fault(path, message))
    marks = {
        copy: replace(sheet.marks[name], at=mirrored_point(sheet.marks[name].at, words.mirror))
        for name, copy in twin.items()
    }
    pairs = copied_connections(sheet.connections, twin, ties=True)
    return sheet.with_marks(marks).with_connections(pairs), faults


def _originals(words: Mirror, sheet: Sheet) -> tuple[list[Picked], list[Fault]]:
    if words.nodes is not None:
        return chosen(words.nodes, sheet, ("nodes",))
    marks = sheet.marks.items()
    return [(name, ()) for name, mark in marks if not _on_axis(mark.at, words.mirror)], []


def _on_axis(at: At, axis: Axis) -> bool:
    return abs(at[0 if axis == "x" else 1]) <= ON_AXIS
