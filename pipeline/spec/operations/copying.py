"""Copy and move: a set of nodes, transformed.

Source: Sims 1987, A.1: every transformation either moves the selected set or copies it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from typing import Annotated

from pydantic import ConfigDict, Field

from pipeline.spec.faults import Fault
from pipeline.spec.nearest import hint
from pipeline.spec.operations.chosen import Chosen, chosen
from pipeline.spec.operations.sheet import (
    MOST_NODES,
    Sheet,
    copied_connections,
    fault_of_room,
)
from pipeline.spec.operations.transformation import (
    Transformation,
    faults_of_transformation,
    transformed,
)
from pipeline.spec.values import Name, Whole

_NUMBERED = re.compile(r"(.*?)([0-9]{1,9})?(_[lr])?")

Join = tuple[Name, Name]


class Copy(Transformation):
    """Copies nodes with the connections between them, once or each copy from the last."""

    # The field cannot be called copy, which every model has already.
    model_config = ConfigDict(serialize_by_alias=True)

    nodes: Chosen = Field(alias="copy", description="The nodes, by name, or `selected` or `all`.")
    repeat: Annotated[Whole, Field(ge=1, le=MOST_NODES)] = Field(
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
