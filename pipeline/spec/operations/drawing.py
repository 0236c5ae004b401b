"""The drawing between two operations: its nodes, connections and selection."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from pipeline.spec.model_base import WORLD_LIMIT, ConfigModel, Fault, PathSegment
from pipeline.spec.suggestions import hint

MAX_NODES = 1000
"""Nodes of a drawing, copies included."""

MIN_LINK_LENGTH = 1e-6
"""Shortest link, as a fraction of the drawing's size."""

MIN_SCALE, MAX_SCALE = 1e-6, 1e6
"""Factors on the size of a node after all scalings."""

At = tuple[float, float]
"""A place on the drawing, x to the right and y towards the tail [m]."""

Pair = tuple[str, str]
"""Two connected nodes, in the order of the alphabet."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A node on the sheet.

    Attributes:
        at: its position [m].
        drawn: the drawn node that it is, or is a copy of.
        size: factor on the radius of that node.
        made_by: index of the operation that made or moved it last, -1 if none did.
    """

    at: At
    drawn: str
    size: float = 1.0
    made_by: int = -1


@dataclass(frozen=True)
class Sheet:
    """The dissection table of Sims between two operations.

    Attributes:
        marks: nodes by name, in the order in which they were made.
        connections: pairs of their names.
        sticky: distance from an axis within which a node snaps to it [m].
        sets: earlier selections, first to last.
        present: index of the present selection, -1 for none.
        extent: length of the longer side of what was drawn [m].
    """

    marks: Mapping[str, Mark]
    connections: frozenset[Pair] = frozenset()
    sticky: float = 0.0
    sets: tuple[tuple[str, ...], ...] = ()
    present: int = -1
    extent: float = 0.0

    @property
    def selected(self) -> tuple[str, ...]:
        """Names of the selected nodes that still exist."""
        names = self.sets[self.present] if self.present >= 0 else ()
        return tuple(name for name in names if name in self.marks)

    def with_marks(self, marks: Mapping[str, Mark]) -> Sheet:
        """Return the sheet with more or moved nodes, which snap to a near axis."""
        snapped = {name: replace(mark, at=self._snapped(mark.at)) for name, mark in marks.items()}
        return replace(self, marks={**self.marks, **snapped})

    def with_connections(self, pairs: Iterable[tuple[str, str]]) -> Sheet:
        """Return the sheet with more connections."""
        return replace(self, connections=self.connections | {pair_of(a, b) for a, b in pairs})

    def made_by(self, number: int, names: Iterable[str]) -> Sheet:
        """Return the sheet in which nodes know the operation that made or moved them."""
        marks = {name: replace(self.marks[name], made_by=number) for name in names}
        return replace(self, marks={**self.marks, **marks})

    def _snapped(self, at: At) -> At:
        x, y = (0.0 if abs(value) <= self.sticky else value for value in at)
        return x, y


def pair_of(a: str, b: str) -> Pair:
    """Return the connection of two nodes."""
    return (a, b) if a <= b else (b, a)


def copied_connections(
    connections: Iterable[Pair], twin: Mapping[str, str], ties: bool
) -> Iterator[Pair]:
    """Yield the connections of copies.

    A connection between two copied nodes is copied whole; one to another node ties the copy
    to that node too, so that a mirrored leg keeps its hip.

    Args:
        connections: the present ones.
        twin: names of the copies by their originals.
        ties: whether connections to other nodes are copied.
    """
    for a, b in connections:
        copied = (a in twin) + (b in twin)
        if copied == 2 or (copied == 1 and ties):
            yield pair_of(twin.get(a, a), twin.get(b, b))


def unknown_nodes(
    names: Iterable[str], known: Mapping[str, object], path: tuple[PathSegment, ...]
) -> Iterator[Fault]:
    """Find names of nodes that do not exist.

    Args:
        names: as the operation lists them.
        known: the nodes.
        path: of the list below the operation.
    """
    for k, name in enumerate(names):
        if name not in known:
            yield Fault((*path, k), f"no node is called '{name}', {hint(name, known)}")


def faults_of_chain(
    chain: tuple[str, ...], sheet: Sheet, path: tuple[PathSegment, ...]
) -> Iterator[Fault]:
    """Find faults of a chain of nodes.

    Args:
        chain: their names.
        sheet: the drawing.
        path: of the chain.
    """
    if len(chain) < 2:
        yield Fault(path, "a chain connects at least 2 nodes")
    yield from unknown_nodes(chain, sheet.marks, path)
    for k in range(1, len(chain)):
        before, name = chain[k - 1], chain[k]
        if before not in sheet.marks or name not in sheet.marks:
            continue
        if name == before:
            yield Fault((*path, k), f"node '{name}' is connected to itself")
        elif is_short(before, name, sheet):
            yield Fault((*path, k), no_length(before, name))


def changed_nodes(before: Sheet, after: Sheet) -> list[str]:
    """Return the names of the nodes that an operation made or moved."""
    return [name for name, mark in after.marks.items() if before.marks.get(name) != mark]


def faults_of_result(before: Sheet, after: Sheet) -> Iterator[Fault]:
    """Find nodes and links made by an operation that no figure can have.

    Args:
        before: the sheet before the operation.
        after: the sheet after it.
    """
    new = set(changed_nodes(before, after))
    for name in after.marks:
        if name in new and not _is_within(after.marks[name]):
            message = (
                f"node '{name}' would lie beyond {WORLD_LIMIT:g} m, or be too small or too large"
            )
            yield Fault((), message)
            return
    touched = {pair for pair in after.connections if not new.isdisjoint(pair)}
    for a, b in sorted(touched | (after.connections - before.connections)):
        if is_short(a, b, after):
            yield Fault((), no_length(a, b))
            return


def fault_of_room(sheet: Sheet, more: int, *path: PathSegment) -> Fault | None:
    """Return the fault of a drawing with too many nodes, None if there is room for `more`."""
    total = len(sheet.marks) + more
    if total <= MAX_NODES:
        return None
    return Fault(path, f"would make {total} nodes; a drawing has at most {MAX_NODES}")


def _is_within(mark: Mark) -> bool:
    return (
        all(abs(value) <= WORLD_LIMIT for value in mark.at) and MIN_SCALE <= mark.size <= MAX_SCALE
    )


def is_short(a: str, b: str, sheet: Sheet) -> bool:
    """Return whether two nodes are too close for a link."""
    return math.dist(sheet.marks[a].at, sheet.marks[b].at) <= MIN_LINK_LENGTH * sheet.extent


def no_length(a: str, b: str) -> str:
    """Return the message about two connected nodes that coincide."""
    return f"nodes '{a}' and '{b}' are at the same place, so the link has no length"


class DrawingOperation(ConfigModel):
    """An operation on the drawing."""

    @abstractmethod
    def apply(self, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
        """Return the drawing after the operation as far as possible, and the faults."""
