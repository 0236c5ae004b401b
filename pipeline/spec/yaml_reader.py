"""YAML reader: text into a tree of values with their locations, with bounds on everything.

PyYAML delivers the events; what they mean is decided here, so that an object tag never makes
an object, an alias never a loop, and a key that is written twice never wins silently.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import yaml
from yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)
from yaml.reader import ReaderError

from pipeline.errors import Problem
from pipeline.spec.model_base import PathSegment
from pipeline.spec.yaml_scalars import Scalar, scalar_of
from pipeline.spec.yaml_tree import (
    REFUSED,
    Entry,
    InvalidValue,
    ListNode,
    MappingNode,
    ScalarNode,
    SourceLocation,
    SourceNode,
)

MAX_VALUES = 100_000
"""Values of a file after its aliases are expanded."""

MAX_DEPTH = 48
"""Levels of nested lists and mappings."""

_CORE = "tag:yaml.org,2002:"
_SCALAR_TYPES: dict[str, tuple[type, ...]] = {
    "str": (str,),
    "int": (int,),
    "float": (int, float),
    "bool": (bool,),
    "null": (type(None),),
}
# The line breaks that PyYAML counts.
_LINE_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")


class _Stop(Exception):
    """A problem that ends the reading."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem


@dataclass(slots=True)
class _Open:
    """A list or mapping whose end is not read yet."""

    place: SourceLocation
    is_table: bool
    anchor: str | None
    refused: bool = False
    size: int = 1
    items: list[SourceNode] = field(default_factory=list)
    entries: dict[str, Entry] = field(default_factory=dict)
    key: tuple[str | None, SourceLocation] | None = None

    @property
    def step(self) -> PathSegment | None:
        """Key or index of the value that is read next."""
        if self.is_table:
            return self.key[0] if self.key else None
        return len(self.items)

    def closed(self) -> SourceNode:
        """Return the finished tree."""
        if self.refused:
            return ScalarNode(self.place, REFUSED)
        if self.is_table:
            return MappingNode(self.place, self.entries)
        return ListNode(self.place, tuple(self.items))


def read_yaml(text: str, file: str) -> tuple[SourceNode | None, list[Problem]]:
    """Read one YAML document.

    Args:
        text: the whole file.
        file: its name as the author gave it.

    Returns:
        The tree, None where the text holds no document or is no YAML, and its problems.
    """
    reader = _Reader(text, file)
    try:
        for event in _events(text):
            reader.take(event)
    except _Stop as stop:
        return None, [*reader.problems, stop.problem]
    except yaml.YAMLError as error:
        problem = syntax_problem(error, file, reader.lines, text)
        return None, [*reader.problems, problem]
    return reader.root, reader.problems


def _events(text: str) -> Iterator[Event]:
    loader = yaml.SafeLoader(text)
    try:
        while loader.check_event():
            event: Event = loader.get_event()  # type: ignore[no-untyped-call] # so are the stubs
            yield event
    except (ValueError, OverflowError) as error:
        # PyYAML lets some errors of conversion through, as of "\UFFFFFFFF".
        said = "a number or an escape is out of range"
        raise yaml.MarkedYAMLError(problem=said, problem_mark=loader.get_mark()) from error
    finally:
        loader.dispose()


class _Reader:
    """Builds a tree from events.

    Attributes:
        root: the tree, once it is read.
        problems: found so far.
        lines: the text, line by line.
    """

    def __init__(self, text: str, file: str) -> None:
        self.root: SourceNode | None = None
        self.problems: list[Problem] = []
        self.lines = _LINE_BREAK.split(text)
        self._file = file
        self._open: list[_Open] = []
        self._anchors: dict[str, SourceNode] = {}
        self._documents = 0
        self._values = 0

    def take(self, event: Event) -> None:
        """Handle one event.

        Raises:
            _Stop: there is no use in reading on.
        """
        match event:
            case DocumentStartEvent():
                self._begin_document(event)
            case ScalarEvent():
                self._take_scalar(event)
            case AliasEvent():
                self._take_alias(event)
            case SequenceStartEvent() | MappingStartEvent():
                self._begin(event)
            case SequenceEndEvent() | MappingEndEvent():
                opened = self._open.pop()
                self._attach(opened.closed(), opened.anchor)

    def _begin_document(self, event: DocumentStartEvent) -> None:
        self._documents += 1
        if self._documents > 1:
            raise self._stop(event, "one file holds one document, and a second one begins here")

    def _begin(self, event: SequenceStartEvent | MappingStartEvent) -> None:
        if len(self._open) >= MAX_DEPTH:
            raise self._stop(event, f"lists and mappings go deeper than {MAX_DEPTH} levels")
        is_table = isinstance(event, MappingStartEvent)
        core = "map" if is_table else "seq"
        refused = event.tag not in (None, "!", _CORE + core)
        if refused:
            self._wrong(
                event, f"the tag '{_shown_tag(event.tag)}' is refused: a file is plain data"
            )
        self._open.append(_Open(self._place(event), is_table, event.anchor, refused))

    def _take_scalar(self, event: ScalarEvent) -> None:
        value = self._value(event)
        parent = self._open[-1] if self._open else None
        if parent and parent.is_table and parent.key is None:
            self._take_key(parent, event, value)
            if event.anchor:
                self._anchors[event.anchor] = ScalarNode(self._place(event), value)
            return
        self._attach(ScalarNode(self._place(event), value), event.anchor)

    def _take_key(self, parent: _Open, event: Event, value: Scalar | InvalidValue) -> None:
        place = self._place(event)
        parent.key = (None, place)
        if not isinstance(value, str):
            if value is not REFUSED:
                shown = "nothing" if value is None else f"{value!r}".lower()
                self._wrong(event, f"a key must be text, is {shown}; put it in quotes")
        elif value in parent.entries:
            line = parent.entries[value].key.line
            parent.key = (value, place)
            self._wrong(event, f"the key is repeated, it stands already on line {line}")
            parent.key = (None, place)
        else:
            parent.key = (value, place)

    def _take_alias(self, event: AliasEvent) -> None:
        name = event.anchor
        if any(opened.anchor == name for opened in self._open):
            raise self._stop(event, f"the alias '*{name}' would contain itself")
        if name not in self._anchors:
            raise self._stop(event, f"there is no anchor '&{name}' before this alias")
        tree = self._anchors[name]
        parent = self._open[-1] if self._open else None
        if parent and parent.is_table and parent.key is None and isinstance(tree, ScalarNode):
            self._take_key(parent, event, tree.value)
            return
        if len(self._open) + tree.height > MAX_DEPTH:
            raise self._stop(event, f"lists and mappings go deeper than {MAX_DEPTH} levels")
        self._attach(tree, None, event)

    def _attach(
        self, tree: SourceNode, anchor: str | None, alias: AliasEvent | None = None
    ) -> None:
        if anchor:
            self._anchors[anchor] = tree
        self._values += 1
        parent = self._open[-1] if self._open else None
        size = tree.size + (parent.size if parent else 0)
        if max(size, self._values) > MAX_VALUES:
            place = self._place(alias) if alias else tree.place
            message = f"holds more than {MAX_VALUES} values"
            message += " when its aliases are written out" if alias else ""
            raise _Stop(place.problem(self._path(), message))
        if parent is None:
            self.root = tree
            return
        parent.size = size
        if not parent.is_table:
            parent.items.append(tree)
        elif parent.key is None:
            parent.key = (None, tree.place)
            message = "a key must be text, not a list or a mapping"
            self.problems.append(tree.place.problem(self._path(), message))
        else:
            name, key_place = parent.key
            parent.key = None
            if name is not None:
                parent.entries[name] = Entry(key_place, tree)

    def _value(self, event: ScalarEvent) -> Scalar | InvalidValue:
        """Return the value of a scalar, refused if its tag or the value itself is."""
        tag = event.tag
        plain = event.implicit[0] if tag is None else tag.startswith(_CORE) and tag != _CORE + "str"
        try:
            value: Scalar = scalar_of(event.value) if plain else event.value
        except ValueError as error:
            self._wrong(event, str(error))
            return REFUSED
        if tag in (None, "!"):
            return value
        types = _SCALAR_TYPES.get(tag.removeprefix(_CORE)) if tag.startswith(_CORE) else None
        if types is None:
            self._wrong(event, _refused_tag(tag))
            return REFUSED
        # In Python true is an integer; here it is none.
        if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
            self._wrong(event, f"the value does not fit its tag '{_shown_tag(tag)}'")
            return REFUSED
        return value

    def _place(self, event: Event) -> SourceLocation:
        mark = event.start_mark
        assert mark is not None
        line, column = mark.line, mark.column
        source = self.lines[line] if line < len(self.lines) else ""
        return SourceLocation(self._file, line + 1, column + 1, source)

    def _path(self) -> list[PathSegment]:
        return [step for opened in self._open if (step := opened.step) is not None]

    def _wrong(self, event: Event, message: str) -> None:
        self.problems.append(self._place(event).problem(self._path(), message))

    def _stop(self, event: Event, message: str) -> _Stop:
        return _Stop(self._place(event).problem(self._path(), message))


def _refused_tag(tag: str | None) -> str:
    return f"the tag '{_shown_tag(tag)}' is refused: a file is plain data"


def _shown_tag(tag: str | None) -> str:
    text = str(tag)
    return "!!" + text.removeprefix(_CORE) if text.startswith(_CORE) else text


def syntax_problem(error: Exception, file: str, lines: Sequence[str], text: str) -> Problem:
    """Return the problem that an error of PyYAML stands for.

    Args:
        error: what PyYAML raised.
        file: name of the file as the author gave it.
        lines: the text, line by line.
        text: the whole file.
    """
    if isinstance(error, ReaderError):
        return _odd_character(text, error.position, file)
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if not isinstance(error, yaml.MarkedYAMLError) or mark is None:
        return SourceLocation(file).problem((), f"is not YAML: {error}")
    place = _place(file, lines, mark.line, mark.column)
    return place.problem((), _syntax_message(error))


def _syntax_message(error: yaml.MarkedYAMLError) -> str:
    problem = error.problem or error.context or "it cannot be read"
    if "'\\t'" in problem:
        return "is not YAML: a tab cannot indent, use blanks"
    message = f"is not YAML: {problem}"
    if error.problem and error.context and error.context_mark:
        message += f" ({error.context} that began on line {error.context_mark.line + 1})"
    return message


def _odd_character(text: str, position: int, file: str) -> Problem:
    before = text[:position]
    line = before.count("\n")
    column = position - (before.rfind("\n") + 1)
    code = ord(text[position]) if position < len(text) else 0
    # The line is not shown: what cannot be read might not be shown either.
    return SourceLocation(file, line + 1, column + 1).problem(
        (), f"is not YAML: the character U+{code:04X} is not allowed"
    )


def _place(file: str, lines: Sequence[str], line: int, column: int) -> SourceLocation:
    return SourceLocation(file, line + 1, column + 1, lines[line] if line < len(lines) else "")


MAX_FILE_BYTES = 8 * 2**20
_BOM = b"\xef\xbb\xbf"


def read_file(path: Path) -> tuple[MappingNode | None, list[Problem]]:
    """Read a file.

    Returns:
        Its mapping, None if there is none to go on with, and the problems so far.
    """
    file = str(path)
    try:
        if path.is_dir():
            return None, [Problem("", "is a folder, not a file", file)]
        with path.open("rb") as stream:
            content = stream.read(MAX_FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        return None, [Problem("", f"cannot be read: {reason}", file)]
    return read_bytes(content, file)


def read_bytes(content: bytes, file: str) -> tuple[MappingNode | None, list[Problem]]:
    """Read the content of a file.

    Args:
        content: UTF-8, with or without a byte order mark.
        file: its name as the author gave it.

    Returns:
        Its mapping, None if there is none to go on with, and the problems so far.
    """
    if len(content) > MAX_FILE_BYTES:
        return None, [Problem("", f"is larger than {MAX_FILE_BYTES // 2**20} MiB", file)]
    content = content.removeprefix(_BOM)
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        line = before.count(b"\n")
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8"))
        message = f"is not UTF-8: the byte 0x{content[error.start]:02x}"
        return None, [Problem("", message, file, line + 1, column + 1)]
    tree, problems = read_yaml(text, file)
    if problems and tree is None:
        return None, problems
    empty = "is empty; the least that a file holds is 'pronk: 1'"
    if tree is None:
        return None, [SourceLocation(file).problem((), empty)]
    if isinstance(tree, MappingNode):
        return tree, problems
    if problems:
        return None, problems
    return None, [tree.place.problem((), "should be a mapping of keys to values at the top")]
