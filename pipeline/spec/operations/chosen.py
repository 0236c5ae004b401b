"""Chosen: the nodes that an operation works on, by name or by the present selection."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from pipeline.spec.faults import Fault, Step
from pipeline.spec.operations.sheet import Sheet, unknown
from pipeline.spec.values import Name

Names = Annotated[tuple[Name, ...], Field(min_length=1)]


def _form(words: Any) -> str:
    return "by a word" if isinstance(words, str) else "by name"


Chosen = Annotated[
    Annotated[Names, Tag("by name")] | Annotated[Literal["selected", "all"], Tag("by a word")],
    Discriminator(_form),
]
"""A list of names; `selected`, what the last `select` chose; or `all`."""

Picked = tuple[str, tuple[Step, ...]]
"""A node, and where the operation names it."""


def chosen(
    nodes: tuple[str, ...] | str, sheet: Sheet, path: tuple[Step, ...]
) -> tuple[list[Picked], list[Fault]]:
    """Return the chosen nodes that there are, each once, and what is wrong with the choice.

    Args:
        nodes: as the author chooses them.
        sheet: the nodes that there are, and which are selected.
        path: where the choice stands below the operation.
    """
    if isinstance(nodes, str):
        names = tuple(sheet.marks) if nodes == "all" else sheet.selected
        empty = "no node is selected here; say which with select before it"
        return [(name, path) for name in names], ([] if names else [Fault(path, empty)])
    faults = [*unknown(nodes, sheet.marks, path), *_repeated(nodes, path)]
    first = {name: k for k, name in reversed(list(enumerate(nodes))) if name in sheet.marks}
    return [(name, (*path, first[name])) for name in dict.fromkeys(nodes) if name in first], faults


def _repeated(nodes: tuple[str, ...], path: tuple[Step, ...]) -> Iterator[Fault]:
    for k, name in enumerate(nodes):
        if name in nodes[:k]:
            yield Fault((*path, k), f"node '{name}' is listed twice")
