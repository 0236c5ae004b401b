"""Delete and connect: nodes taken off the drawing, and connections laid on it.

Source: Sims 1987, A.1.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

from pydantic import Field

from pipeline.spec.model_base import ConfigModel, Fault
from pipeline.spec.operations.drawing import Sheet, faults_of_chain, pair_of
from pipeline.spec.operations.node_selection import Chosen, Names, chosen


class Delete(ConfigModel):
    """Takes nodes away, with all their connections."""

    delete: Chosen = Field(description="The nodes, by name, or `selected`.")


class Connect(ConfigModel):
    """Connects nodes that there are by now, each to the next; copies too."""

    connect: Names = Field(description="Names; each node is connected to the next.")


def delete(words: Delete, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Return the sheet without the nodes, and what is wrong with the words."""
    picked, faults = chosen(words.delete, sheet, ("delete",))
    gone = {name for name, _ in picked}
    if len(gone) == len(sheet.marks):
        return sheet, [*faults, Fault(("delete",), "would leave no node")]
    marks = {name: mark for name, mark in sheet.marks.items() if name not in gone}
    pairs = frozenset(pair for pair in sheet.connections if not gone.intersection(pair))
    return replace(sheet, marks=marks, connections=pairs), faults


def connect(words: Connect, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Return the sheet with more connections, and what is wrong with the words."""
    faults = list(faults_of_chain(words.connect, sheet, ("connect",)))
    known = sheet.marks
    pairs = {
        pair_of(a, b)
        for a, b in itertools.pairwise(words.connect)
        if a in known and b in known and a != b
    }
    return sheet.with_connections(pairs), faults
