"""Copy and move: a set of nodes, transformed.

Source: Sims 1987, A.1: every transformation either moves the selected set or copies it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Annotated

from pydantic import ConfigDict, Field, Strict

from pipeline.spec.model_base import ConfigModel, Fault, Integer, Name
from pipeline.spec.operations.drawing import (
    MOST_NODES,
    At,
    Sheet,
    copied_connections,
    fault_of_room,
)
from pipeline.spec.operations.node_selection import Chosen, Picked, chosen
from pipeline.spec.operations.transformation import (
    Axis,
    Transformation,
    faults_of_transformation,
    mirrored_point,
    transformed,
)
from pipeline.spec.suggestions import hint

_NUMBERED = re.compile(r"(.*?)([0-9]{1,9})?(_[lr])?")

Join = tuple[Name, Name]


class Copy(Transformation):
    """Copies nodes with the connections between them, once or each copy from the last."""

    # The field cannot be called copy, which every model has already.
    model_config = ConfigDict(serialize_by_alias=True)

    nodes: Chosen = Field(alias="copy", description="The nodes, by name, or `selected` or `all`.")
    repeat: Annotated[Integer, Field(ge=1, le=MOST_NODES)] = Field(
        1, description="How many copies; each is made of the last as the first of the original."
    )
    join: tuple[Join, ...] | None = Field(
        None,
        description="Pairs of nodes, each [from, to]: `from` in what is copied is connected to "
        "the copy of `to`. If left out, copies are connected to the nodes outside that their "
        "originals are connected to.",
    )


class Move(Transformation):
    """Moves nodes; their connections follow."""

    move: Chosen = Field(description="The nodes, by name, or `selected` or `all`.")


def copy(words: Copy, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Return the sheet with the copies that can be made, and what is wrong with the words."""
    picked, faults = chosen(words.nodes, sheet, ("copy",))
    names = [name for name, _ in picked]
    lost = faults_of_transformation(words, sheet)
    crowded = fault_of_room(sheet, len(names) * words.repeat, "repeat")
    if not names or crowded:
        return sheet, [*faults, *lost, *([crowded] if crowded else [])]
    faults += [*lost, *_faults_of_join(words.join or (), names, sheet)]
    joins = [(a, b) for a, b in words.join or () if a in sheet.marks and b in names]
    last = {name: name for name in names}
    for _ in range(words.repeat):
        sheet, last = _copied_once(words, sheet, last, joins, bool(lost))
    return sheet, faults


def _copied_once(
    words: Copy, sheet: Sheet, last: Mapping[str, str], joins: Iterable[Join], stays: bool
) -> tuple[Sheet, dict[str, str]]:
    """Copy the last copies; return them by their first originals as well."""
    twin = copied_names(last.values(), sheet.marks)
    marks = [sheet.marks[name] for name in twin]
    moved = marks if stays else transformed(words, marks, sheet)
    pairs = list(copied_connections(sheet.connections, twin, ties=words.join is None))
    pairs += [(last.get(a, a), twin[last[b]]) for a, b in joins]
    made = sheet.with_marks(dict(zip(twin.values(), moved, strict=True)))
    return made.with_connections(pairs), {name: twin[one] for name, one in last.items()}


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


def move(words: Move, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Return the sheet with nodes elsewhere, and what is wrong with the words."""
    picked, faults = chosen(words.move, sheet, ("move",))
    names = [name for name, _ in picked]
    lost = faults_of_transformation(words, sheet)
    if lost or not names:
        return sheet, [*faults, *lost]
    moved = transformed(words, [sheet.marks[name] for name in names], sheet)
    return sheet.with_marks(dict(zip(names, moved, strict=True))), faults


ON_AXIS = 1e-9
"""A node no farther than this from the axis lies on it [m]."""


class Mirror(ConfigModel):
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
