"""A YAML file as a tree of values that know their source location."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pipeline.errors import Problem, SceneError
from pipeline.spec.model_base import PathSegment
from pipeline.spec.yaml_scalars import Scalar

MAX_LINE_LENGTH = 200
"""Longer lines are not quoted under a message [characters]."""

MAX_PATH_STEPS = 12
"""Longer paths are cut off in messages."""

MAX_KEY_LENGTH = 40
"""Longer keys are cut off in messages [characters]."""


@dataclass(frozen=True, slots=True)
class SourceLocation:
    """A place in a file.

    Attributes:
        file: name of the file as the author gave it.
        line: 1-based line, 0 where there is none (a value given on the command line).
        column: 1-based column, 0 likewise.
        source: text of that line.
    """

    file: str
    line: int = 0
    column: int = 0
    source: str = ""

    def problem(self, path: Sequence[PathSegment], message: str) -> Problem:
        """Return a problem at this location."""
        source = self.source if len(self.source) <= MAX_LINE_LENGTH else ""
        return Problem(path_text(path), message, self.file, self.line, self.column, source)


class InvalidValue:
    """Replaces a value that the reader refused, so that no model accepts it."""

    def __repr__(self) -> str:
        return "a value that was refused"


REFUSED = InvalidValue()


@dataclass(frozen=True, slots=True)
class ScalarNode:
    """A scalar, or the stand-in for a refused value."""

    place: SourceLocation
    value: Scalar | InvalidValue

    @property
    def size(self) -> int:
        """Number of values in it."""
        return 1

    @property
    def height(self) -> int:
        """Number of levels below it."""
        return 0


@dataclass(frozen=True, slots=True)
class ListNode:
    """A list."""

    place: SourceLocation
    items: tuple[SourceNode, ...] = ()
    size: int = field(init=False)
    height: int = field(init=False)

    def __post_init__(self) -> None:
        _set_size(self, self.items)

    def with_item(self, index: int, item: SourceNode) -> ListNode:
        """Return the list with another item at `index`."""
        return ListNode(self.place, (*self.items[:index], item, *self.items[index + 1 :]))


@dataclass(frozen=True, slots=True)
class Entry:
    """A key of a mapping with its value."""

    key: SourceLocation
    value: SourceNode


@dataclass(frozen=True, slots=True)
class MappingNode:
    """A mapping."""

    place: SourceLocation
    entries: Mapping[str, Entry]
    size: int = field(init=False)
    height: int = field(init=False)

    def __post_init__(self) -> None:
        _set_size(self, [entry.value for entry in self.entries.values()])

    def get(self, key: str) -> SourceNode | None:
        """Return the value of a key, or None where there is no such key."""
        entry = self.entries.get(key)
        return entry.value if entry else None

    def with_entry(self, key: str, place: SourceLocation, value: SourceNode) -> MappingNode:
        """Return the mapping with this value at `key`."""
        return MappingNode(self.place, {**self.entries, key: Entry(place, value)})

    def with_value(self, key: str, value: SourceNode) -> MappingNode:
        """Return the mapping with another value at a key that it has."""
        return self.with_entry(key, self.entries[key].key, value)

    def without(self, key: str) -> MappingNode:
        """Return the mapping without `key`."""
        return MappingNode(self.place, {k: entry for k, entry in self.entries.items() if k != key})


SourceNode = ScalarNode | ListNode | MappingNode


def _set_size(tree: ListNode | MappingNode, children: Sequence[SourceNode]) -> None:
    object.__setattr__(tree, "size", 1 + sum(child.size for child in children))
    object.__setattr__(tree, "height", 1 + max((child.height for child in children), default=-1))


def plain_values(tree: SourceNode) -> Any:
    """Return the values without their locations; lists as tuples, as strict models want them."""
    match tree:
        case ScalarNode():
            return tree.value
        case ListNode():
            return tuple(plain_values(item) for item in tree.items)
        case MappingNode():
            return {key: plain_values(entry.value) for key, entry in tree.entries.items()}


NO_LOCATION = SourceLocation("")
"""Of values that stand in no file."""


def tree_of(value: Any, place: SourceLocation = NO_LOCATION) -> SourceNode:
    """Return plain values as a tree all of whose nodes have one location."""
    if isinstance(value, Mapping):
        entries = {key: Entry(place, tree_of(below, place)) for key, below in value.items()}
        return MappingNode(place, entries)
    if isinstance(value, list | tuple):
        return ListNode(place, tuple(tree_of(item, place) for item in value))
    return ScalarNode(place, value)


def with_key(tree: SourceNode, path: Sequence[PathSegment], name: str) -> SourceNode:
    """Return a tree whose key at a path is called otherwise, unless there is such a key already.

    Args:
        tree: the whole.
        path: to the key, which the tree has; one that a change before it moved is left alone.
        name: the new name.
    """
    *above, old = path
    found = find_node(tree, above)
    if found.skipped or not isinstance(found.tree, MappingNode) or name in found.tree.entries:
        return tree
    entries = {name if key == old else key: entry for key, entry in found.tree.entries.items()}
    return _replaced(tree, above, MappingNode(found.tree.place, entries))


def with_node(tree: MappingNode, path: Sequence[PathSegment], node: SourceNode) -> MappingNode:
    """Return the mapping with another node at a path below it, which it has."""
    step, *below = path
    assert isinstance(step, str)
    return tree.with_value(step, _replaced(tree.entries[step].value, below, node))


def _replaced(tree: SourceNode, path: Sequence[PathSegment], node: SourceNode) -> SourceNode:
    if not path:
        return node
    if isinstance(tree, MappingNode):
        return with_node(tree, path, node)
    step, *below = path
    assert isinstance(tree, ListNode)
    assert isinstance(step, int)
    return tree.with_item(step, _replaced(tree.items[step], below, node))


def _files_of(tree: SourceNode) -> set[str]:
    """Return the names of the files that the values of a tree stand in."""
    below: Iterable[SourceNode] = ()
    if isinstance(tree, MappingNode):
        below = (entry.value for entry in tree.entries.values())
    elif isinstance(tree, ListNode):
        below = tree.items
    return {tree.place.file}.union(*map(_files_of, below))


def has_refused(tree: SourceNode) -> bool:
    """Return whether a value in the tree was refused."""
    match tree:
        case ScalarNode():
            return tree.value is REFUSED
        case ListNode():
            return any(has_refused(item) for item in tree.items)
        case MappingNode():
            return any(has_refused(entry.value) for entry in tree.entries.values())


def path_text(path: Sequence[PathSegment]) -> str:
    """Return a path as an author writes it, such as `cast[0].walk.speed`."""
    text = ""
    for step in path[:MAX_PATH_STEPS]:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += f".{_key_text(step)}" if text else _key_text(step)
    return text + "..." if len(path) > MAX_PATH_STEPS else text


def _key_text(key: str) -> str:
    short = key if len(key) <= MAX_KEY_LENGTH else key[: MAX_KEY_LENGTH - 3] + "..."
    return short if short and short.isprintable() else repr(short)


@dataclass(frozen=True, slots=True)
class FoundNode:
    """The node that a path of pydantic's leads to.

    Attributes:
        path: steps that exist in the tree.
        tree: the node at their end.
        key: location of the key that leads there.
        skipped: number of steps that do not exist in the tree, such as tags of unions.
    """

    path: tuple[PathSegment, ...]
    tree: SourceNode
    key: SourceLocation
    skipped: int = 0


def find_node(tree: SourceNode, path: Sequence[PathSegment]) -> FoundNode:
    """Follow a path of pydantic's through the tree, skipping the tags of unions."""
    here, key = tree, tree.place
    steps: list[PathSegment] = []
    skipped = 0
    for step in path:
        if isinstance(here, MappingNode) and isinstance(step, str) and step in here.entries:
            entry = here.entries[step]
            here, key = entry.value, entry.key
        elif isinstance(here, ListNode) and isinstance(step, int) and step < len(here.items):
            here = here.items[step]
            key = here.place
        else:
            skipped += 1
            continue
        steps.append(step)
    return FoundNode(tuple(steps), here, key, skipped)


_STEP = re.compile(r"(?:^|\.)([^.\[\]]+)|\[([0-9]+)\]")

NAMED_BLOCKS = ("figures", "nodes", "parts", "joints")
"""Mappings whose keys are names: an error in an entry is reported at its name."""


@dataclass(frozen=True, slots=True, eq=False)
class SourceMap:
    """Finds the source location of a scene's values, for errors found after loading.

    Attributes:
        tree: the file of the scene; None for a scene that was not read from text.
    """

    tree: SourceNode | None = None

    # Equal scenes may come from different files.
    def __eq__(self, other: object) -> bool:
        return isinstance(other, SourceMap)

    def __hash__(self) -> int:
        return 0

    @property
    def files(self) -> set[str]:
        """Names of the files that the scene was read from: its own, those of figures and dances."""
        return _files_of(self.tree) - {""} if self.tree is not None else set()

    def find(self, path: str) -> SourceLocation | None:
        """Return the location of a path, or of its nearest parent that has one.

        Args:
            path: such as `figures.bug.then[1]`.
        """
        if self.tree is None:
            return None
        steps: list[PathSegment] = [
            int(found[2]) if found[2] else found[1].strip("'") for found in _STEP.finditer(path)
        ]
        found = find_node(self.tree, steps)
        while found.skipped:
            steps = steps[:-1]
            found = find_node(self.tree, steps)
        if not steps:
            return SourceLocation(found.tree.place.file)
        is_name = len(steps) > 1 and steps[-2] in NAMED_BLOCKS and isinstance(steps[-1], str)
        return found.key if is_name or not isinstance(found.tree, ScalarNode) else found.tree.place

    def with_location(self, problem: Problem) -> Problem:
        """Return a problem with its file, line and column, where it has none and they are known."""
        place = self.find(problem.path)
        if problem.file or place is None:
            return problem
        source = place.source if len(place.source) <= MAX_LINE_LENGTH else ""
        return Problem(problem.path, problem.message, place.file, place.line, place.column, source)

    def with_locations(self, error: SceneError) -> SceneError:
        """Return an error whose problems all have their locations, in the order of the file."""
        problems = [self.with_location(problem) for problem in error.problems]
        files = list(dict.fromkeys(problem.file for problem in problems))
        return SceneError(
            sorted(problems, key=lambda p: (not p.line, files.index(p.file), p.line, p.column))
        )
