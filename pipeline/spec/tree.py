"""A file as a tree of values that know where they stand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pipeline.errors import Problem
from pipeline.spec.faults import Step
from pipeline.spec.scalars import Scalar

LONGEST_LINE = 200
"""Longer lines are not shown under a message."""

MOST_STEPS = 12
"""Longer paths are not shown to their end."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where something stands.

    Attributes:
        file: name of the file as the author gave it.
        line: 1-based line, 0 where there is none (a value given on the command line).
        column: 1-based column, 0 likewise.
        source: the text of that line.
    """

    file: str
    line: int = 0
    column: int = 0
    source: str = ""

    def problem(self, path: Sequence[Step], message: str) -> Problem:
        """Return a problem at this place."""
        source = self.source if len(self.source) <= LONGEST_LINE else ""
        return Problem(path_text(path), message, self.file, self.line, self.column, source)


class Refused:
    """Stands for a value that was refused when the file was read, so that no type accepts it."""

    def __repr__(self) -> str:
        return "a value that was refused"


REFUSED = Refused()


@dataclass(frozen=True, slots=True)
class Leaf:
    """A scalar, or what stands for a value that was refused."""

    place: Place
    value: Scalar | Refused

    @property
    def size(self) -> int:
        """Number of values in it."""
        return 1

    @property
    def height(self) -> int:
        """Number of levels below it."""
        return 0


@dataclass(frozen=True, slots=True)
class Row:
    """A list."""

    place: Place
    items: tuple[Tree, ...] = ()
    size: int = field(init=False)
    height: int = field(init=False)

    def __post_init__(self) -> None:
        _measure(self, self.items)


@dataclass(frozen=True, slots=True)
class Entry:
    """A key of a table with its value."""

    key: Place
    value: Tree


@dataclass(frozen=True, slots=True)
class Table:
    """A mapping."""

    place: Place
    entries: Mapping[str, Entry]
    size: int = field(init=False)
    height: int = field(init=False)

    def __post_init__(self) -> None:
        _measure(self, [entry.value for entry in self.entries.values()])

    def get(self, key: str) -> Tree | None:
        """Return the value of a key, or None where there is no such key."""
        entry = self.entries.get(key)
        return entry.value if entry else None

    def having(self, key: str, place: Place, value: Tree) -> Table:
        """Return a table in which `key` has this value."""
        return Table(self.place, {**self.entries, key: Entry(place, value)})

    def without(self, key: str) -> Table:
        """Return a table that has no `key`."""
        return Table(self.place, {k: entry for k, entry in self.entries.items() if k != key})


Tree = Leaf | Row | Table


def _measure(tree: Row | Table, children: Sequence[Tree]) -> None:
    object.__setattr__(tree, "size", 1 + sum(child.size for child in children))
    object.__setattr__(tree, "height", 1 + max((child.height for child in children), default=-1))


def plain(tree: Tree) -> Any:
    """Return the values without their places; lists as tuples, as strict models want them."""
    match tree:
        case Leaf():
            return tree.value
        case Row():
            return tuple(plain(item) for item in tree.items)
        case Table():
            return {key: plain(entry.value) for key, entry in tree.entries.items()}


def has_refused(tree: Tree) -> bool:
    """Tell whether a value in the tree was refused."""
    match tree:
        case Leaf():
            return tree.value is REFUSED
        case Row():
            return any(has_refused(item) for item in tree.items)
        case Table():
            return any(has_refused(entry.value) for entry in tree.entries.values())


def path_text(path: Sequence[Step]) -> str:
    """Return a path as an author writes it, such as `cast[0].walk.speed`."""
    text = ""
    if len(path) > MOST_STEPS:
        return path_text(path[:MOST_STEPS]) + "..."
    for step in path:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += f".{_key_text(step)}" if text else _key_text(step)
    return text


def _key_text(key: str) -> str:
    short = key if len(key) <= 40 else key[:37] + "..."
    return short if short and short.isprintable() else repr(short)
