"""Drawing edits: mirror, copy, move, delete and connect.

Source: Sims 1987, A.1: every transformation either moves the selected set or copies it.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Annotated

from pydantic import ConfigDict, Field, Strict

from pipeline.spec.model_base import Fault, Integer, Name
from pipeline.spec.operations.drawing import (
    MAX_NODES,
    At,
    DrawingOperation,
    Sheet,
    copied_connections,
    fault_of_room,
    faults_of_chain,
    pair_of,
)
from pipeline.spec.operations.node_selection import Chosen, Names, Picked, chosen
from pipeline.spec.operations.transformation import (
    Axis,
    Transformation,
    faults_of_transformation,
    mirrored_point,
    transformed,
)
from pipeline.spec.suggestions import hint

AXIS_TOLERANCE = 1e-9
"""A node no farther than this from the axis lies on it [m]."""

_NUMBERED = re.compile(r"(.*?)([0-9]{1,9})?(_[lr])?")

Join = tuple[Name, Name]


class Copy(Transformation):
    """Copies nodes with the connections between them, once or each copy from the last."""

    # The field cannot be called copy, which every model has already.
    model_config = ConfigDict(serialize_by_alias=True)

    nodes: Chosen = Field(alias="copy", description="The nodes, by name, or `selected` or `all`.")
    repeat: Annotated[Integer, Field(ge=1, le=MAX_NODES)] = Field(
        1, description="Number of copies; each is made of the last as the first of the original."
    )
    join: tuple[Join, ...] | None = Field(
        None,
        description="Pairs of nodes, each [from, to]: `from` in the original is connected to "
        "the copy of `to`. If left out, copies are connected to the nodes outside that their "
        "originals are connected to.",
    )

    def apply(self, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
        """Return the drawing with the copies that can be made, and the faults."""
        picked, faults = chosen(self.nodes, sheet, ("copy",))
        names = [name for name, _ in picked]
        faults_of_move = faults_of_transformation(self, sheet)
        crowded = fault_of_room(sheet, len(names) * self.repeat, "repeat")
        if not names or crowded:
            return sheet, [*faults, *faults_of_move, *([crowded] if crowded else [])]
        faults += [*faults_of_move, *_faults_of_join(self.join or (), names, sheet)]
        joins = [(a, b) for a, b in self.join or () if a in sheet.marks and b in names]
        last = {name: name for name in names}
        for _ in range(self.repeat):
            sheet, last = self._copied_once(sheet, last, joins, not faults_of_move)
        return sheet, faults

    def _copied_once(
        self, sheet: Sheet, last: Mapping[str, str], joins: Iterable[Join], moves: bool
    ) -> tuple[Sheet, dict[str, str]]:
        """Copy the last copies; return them by their first originals as well."""
        twin = copied_names(last.values(), sheet.marks)
        marks = [sheet.marks[name] for name in twin]
        moved = transformed(self, marks, sheet) if moves else marks
        pairs = list(copied_connections(sheet.connections, twin, ties=self.join is None))
        pairs += [(last.get(a, a), twin[last[b]]) for a, b in joins]
        made = sheet.with_marks(dict(zip(twin.values(), moved, strict=True)))
        return made.with_connections(pairs), {name: twin[copy] for name, copy in last.items()}


class Move(Transformation):
    """Moves nodes; their connections follow."""

    move: Chosen = Field(description="The nodes, by name, or `selected` or `all`.")

    def apply(self, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
        """Return the drawing with the nodes moved, and the faults."""
        picked, faults = chosen(self.move, sheet, ("move",))
        names = [name for name, _ in picked]
        faults_of_move = faults_of_transformation(self, sheet)
        if faults_of_move or not names:
            return sheet, [*faults, *faults_of_move]
        moved = transformed(self, [sheet.marks[name] for name in names], sheet)
        return sheet.with_marks(dict(zip(names, moved, strict=True))), faults


class Mirror(DrawingOperation):
    """Copies nodes to the other side; nodes on the axis are not copied."""

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

    def apply(self, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
        """Return the drawing with the copies that can be made, and the faults."""
        originals, faults = self._originals(sheet)
        crowded = fault_of_room(sheet, len(originals), "mirror")
        if crowded:
            return sheet, [crowded]
        twin: dict[str, str] = {}
        for name, path in originals:
            copy = mirrored_name(name, self.suffix)
            if _on_axis(sheet.marks[name].at, self.mirror):
                message = f"node '{name}' lies on the axis, its copy would lie on itself"
            elif copy in sheet.marks or copy in twin.values():
                message = f"the copy of '{name}' would be called '{copy}', and there is one already"
                message += "; list the nodes to copy" if self.nodes is None else ""
            else:
                twin[name] = copy
                continue
            faults.append(Fault(path, message))
        marks = {
            copy: replace(sheet.marks[name], at=mirrored_point(sheet.marks[name].at, self.mirror))
            for name, copy in twin.items()
        }
        pairs = copied_connections(sheet.connections, twin, ties=True)
        return sheet.with_marks(marks).with_connections(pairs), faults

    def _originals(self, sheet: Sheet) -> tuple[list[Picked], list[Fault]]:
        if self.nodes is not None:
            return chosen(self.nodes, sheet, ("nodes",))
        marks = sheet.marks.items()
        return [(name, ()) for name, mark in marks if not _on_axis(mark.at, self.mirror)], []


class Delete(DrawingOperation):
    """Removes nodes, with all their connections."""

    delete: Chosen = Field(description="The nodes, by name, or `selected`.")

    def apply(self, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
        """Return the drawing without the nodes, and the faults."""
        picked, faults = chosen(self.delete, sheet, ("delete",))
        gone = {name for name, _ in picked}
        if len(gone) == len(sheet.marks):
            return sheet, [*faults, Fault(("delete",), "would leave no node")]
        marks = {name: mark for name, mark in sheet.marks.items() if name not in gone}
        pairs = frozenset(pair for pair in sheet.connections if not gone.intersection(pair))
        return replace(sheet, marks=marks, connections=pairs), faults


class Connect(DrawingOperation):
    """Connects existing nodes, each to the next; copies too."""

    connect: Names = Field(description="Names; each node is connected to the next.")

    def apply(self, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
        """Return the drawing with more connections, and the faults."""
        faults = list(faults_of_chain(self.connect, sheet, ("connect",)))
        pairs = {
            pair_of(a, b)
            for a, b in itertools.pairwise(self.connect)
            if a in sheet.marks and b in sheet.marks and a != b
        }
        return sheet.with_connections(pairs), faults


def copied_names(names: Iterable[str], taken: Collection[str]) -> dict[str, str]:
    """Return the names of copies by their originals.

    The number that ends a name, before a side `_l` or `_r`, is counted up until the name is
    free: `leg1_l` gives `leg2_l`. A name without a number is the first: `hip_l` gives
    `hip_2_l`, and `tail` gives `tail_2`.
    """
    names = list(names)
    used = {*taken, *names}
    twin = {}
    for name in names:
        found = _NUMBERED.fullmatch(name)
        assert found, "it fits every name"
        stem, digits, side = found.groups()
        number, stem = (int(digits), stem) if digits else (1, f"{stem}_")
        copy_name = name
        while copy_name in used:
            number += 1
            copy_name = f"{stem}{number}{side or ''}"
        used.add(copy_name)
        twin[name] = copy_name
    return twin


def mirrored_name(name: str, suffix: str = "_m") -> str:
    """Return the name of a node's copy: `_l` and `_r` are swapped, other names get the suffix."""
    if name.endswith("_l"):
        return name[:-2] + "_r"
    if name.endswith("_r"):
        return name[:-2] + "_l"
    return name + suffix


def _faults_of_join(joins: Iterable[Join], names: Collection[str], sheet: Sheet) -> list[Fault]:
    faults = []
    for i, (a, b) in enumerate(joins):
        if a not in sheet.marks:
            message = f"no node is called '{a}', {hint(a, sheet.marks)}"
            faults.append(Fault(("join", i, 0), message))
        if b not in names:
            message = f"no node called '{b}' is copied here, {hint(b, names)}"
            faults.append(Fault(("join", i, 1), message))
    return faults


def _on_axis(at: At, axis: Axis) -> bool:
    return abs(at[0 if axis == "x" else 1]) <= AXIS_TOLERANCE
