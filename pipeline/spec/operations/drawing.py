"""Sheet: nodes and connections as they lie between two operations, and which are selected."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from pipeline.spec.model_base import WORLD_LIMIT, Fault, Step
from pipeline.spec.suggestions import hint

MOST_NODES = 1000
"""Nodes of a drawing, copies included."""

LEAST_LENGTH = 1e-6
"""Length of a link that still is one, as a part of the drawing's size."""

FINEST, COARSEST = 1e-6, 1e6
"""Least and greatest factor on the size of a node after all its scalings."""

At = tuple[float, float]
"""A place on the drawing, x to the right and y towards the tail [m]."""

Pair = tuple[str, str]
"""Two connected nodes, in the order of the alphabet."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A node on the sheet.

    Attributes:
        at: where it lies [m].
        drawn: the node of the drawing that it is, or is a copy of.
        size: factor on that node's radius.
        made_by: the operation that made or moved it last, -1 for what lies as it was drawn.
    """

    at: At
    drawn: str
    size: float = 1.0
    made_by: int = -1


@dataclass(frozen=True)
class Sheet:
    """The dissection table between two operations.

    Attributes:
        marks: nodes by name, in the order of their making.
        connections: pairs of their names.
        sticky: how near an axis a node lands on it [m].
        sets: the sets that were selected, first to last.
        present: which of them is selected now, -1 if none is.
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
        """Names of the selected nodes that there still are."""
        names = self.sets[self.present] if self.present >= 0 else ()
        return tuple(name for name in names if name in self.marks)

    @property
    def places(self) -> dict[str, At]:
        """Where the nodes lie [m]."""
        return {name: mark.at for name, mark in self.marks.items()}

    def with_marks(self, marks: Mapping[str, Mark]) -> Sheet:
        """Return the sheet with more nodes, or with nodes elsewhere; near an axis they stick."""
        stuck = {name: replace(mark, at=self._stuck(mark.at)) for name, mark in marks.items()}
        return replace(self, marks={**self.marks, **stuck})

    def with_connections(self, pairs: Iterable[tuple[str, str]]) -> Sheet:
        """Return the sheet with more connections."""
        return replace(self, connections=self.connections | {pair_of(a, b) for a, b in pairs})

    def made_by(self, number: int, names: Iterable[str]) -> Sheet:
        """Return the sheet with the operation that made or moved nodes kept with them."""
        noted = {name: replace(self.marks[name], made_by=number) for name in names}
        return replace(self, marks={**self.marks, **noted})

    def _stuck(self, at: At) -> At:
        x, y = (0.0 if abs(value) <= self.sticky else value for value in at)
        return x, y


def pair_of(a: str, b: str) -> Pair:
    """Return two names as a connection."""
    return (a, b) if a <= b else (b, a)


def copied_connections(
    connections: Iterable[Pair], twin: Mapping[str, str], ties: bool
) -> Iterator[Pair]:
    """Give the connections of copies.

    One between two copied nodes is copied whole; one that leads out of them ties the copy to
    the node that the original is connected to, so that a mirrored leg keeps its hip.

    Args:
        connections: those that there are.
        twin: the copies by their originals.
        ties: whether those that lead out are copied.
    """
    for a, b in connections:
        copied = (a in twin) + (b in twin)
        if copied == 2 or (copied == 1 and ties):
            yield pair_of(twin.get(a, a), twin.get(b, b))


def unknown(
    names: Iterable[str], known: Mapping[str, object], path: tuple[Step, ...]
) -> Iterator[Fault]:
    """Find names that no node has.

    Args:
        names: as the operation lists them.
        known: the nodes that there are.
        path: where the list stands below the operation.
    """
    for k, name in enumerate(names):
        if name not in known:
            yield Fault((*path, k), f"no node is called '{name}', {hint(name, known)}")


def faults_of_chain(
    chain: tuple[str, ...], sheet: Sheet, path: tuple[Step, ...]
) -> Iterator[Fault]:
    """Find what is wrong with nodes that are connected each to the next.

    Args:
        chain: their names.
        sheet: the nodes that there are.
        path: where the chain stands.
    """
    if len(chain) < 2:
        yield Fault(path, "a chain connects at least 2 nodes")
    yield from unknown(chain, sheet.marks, path)
    for k in range(1, len(chain)):
        before, name = chain[k - 1], chain[k]
        if before not in sheet.marks or name not in sheet.marks:
            continue
        if name == before:
            yield Fault((*path, k), f"node '{name}' is connected to itself")
        elif is_short(before, name, sheet):
            yield Fault((*path, k), no_length(before, name))


def changed(before: Sheet, after: Sheet) -> list[str]:
    """Return the nodes that an operation has made or moved."""
    return [name for name, mark in after.marks.items() if before.marks.get(name) != mark]


def faults_of_result(before: Sheet, after: Sheet) -> Iterator[Fault]:
    """Find what an operation has made that no figure can have.

    Args:
        before: the sheet before the operation.
        after: the sheet after it.
    """
    new = set(changed(before, after))
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


def fault_of_room(sheet: Sheet, more: int, *path: Step) -> Fault | None:
    """Find whether a sheet has no room for more nodes."""
    total = len(sheet.marks) + more
    if total <= MOST_NODES:
        return None
    return Fault(path, f"would make {total} nodes; a drawing has at most {MOST_NODES}")


def _is_within(mark: Mark) -> bool:
    return all(abs(value) <= WORLD_LIMIT for value in mark.at) and FINEST <= mark.size <= COARSEST


def is_short(a: str, b: str, sheet: Sheet) -> bool:
    """Tell whether two nodes lie so near each other that a link between them is none."""
    return math.dist(sheet.marks[a].at, sheet.marks[b].at) <= LEAST_LENGTH * sheet.extent


def no_length(a: str, b: str) -> str:
    """Return what is wrong where two connected nodes coincide."""
    return f"nodes '{a}' and '{b}' are at the same place, so the link has no length"


Doing = Callable[..., tuple[Sheet, list[Fault]]]
"""Carries out an operation, as far as it can, and says what is wrong with it."""
