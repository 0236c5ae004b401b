"""Reads YAML text into a tree, with rules of our own and a bound on everything.

PyYAML delivers the events; what they mean is decided here, so that an object tag never makes
an object, an alias never a loop, and a key that is written twice never wins silently.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

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

from pipeline.errors import Problem
from pipeline.spec.faults import Step
from pipeline.spec.scalars import Scalar, scalar_of
from pipeline.spec.tree import REFUSED, Entry, Leaf, Place, Refused, Row, Table, Tree
from pipeline.spec.yaml_errors import syntax_problem

MOST_VALUES = 100_000
"""Values of a file after its aliases are written out."""

DEEPEST = 48
"""Levels of lists and mappings in each other."""

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
    """Reading cannot go on after this problem."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem


@dataclass(slots=True)
class _Open:
    """A list or mapping whose end has not been read."""

    place: Place
    is_table: bool
    anchor: str | None
    refused: bool = False
    size: int = 1
    items: list[Tree] = field(default_factory=list)
    entries: dict[str, Entry] = field(default_factory=dict)
    key: tuple[str | None, Place] | None = None

    @property
    def step(self) -> Step | None:
        """The step from this to what is read next."""
        if self.is_table:
            return self.key[0] if self.key else None
        return len(self.items)

    def closed(self) -> Tree:
        """Return the finished tree."""
        if self.refused:
            return Leaf(self.place, REFUSED)
        if self.is_table:
            return Table(self.place, self.entries)
        return Row(self.place, tuple(self.items))


def read_yaml(text: str, file: str) -> tuple[Tree | None, list[Problem]]:
    """Read one YAML document.

    Args:
        text: the whole file.
        file: its name as the author gave it.

    Returns:
        The tree, None where the text holds no document or is no YAML, and what is wrong with it.
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
        problems: what is wrong so far.
        lines: the text, line by line.
    """

    def __init__(self, text: str, file: str) -> None:
        self.root: Tree | None = None
        self.problems: list[Problem] = []
        self.lines = _LINE_BREAK.split(text)
        self._file = file
        self._open: list[_Open] = []
        self._anchors: dict[str, Tree] = {}
        self._documents = 0
        self._values = 0

    def take(self, event: Event) -> None:
        """Go on by one event.

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
        if len(self._open) >= DEEPEST:
            raise self._stop(event, f"lists and mappings go deeper than {DEEPEST} levels")
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
                self._anchors[event.anchor] = Leaf(self._place(event), value)
            return
        self._attach(Leaf(self._place(event), value), event.anchor)

    def _take_key(self, parent: _Open, event: Event, value: Scalar | Refused) -> None:
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
        if parent and parent.is_table and parent.key is None and isinstance(tree, Leaf):
            self._take_key(parent, event, tree.value)
            return
        if len(self._open) + tree.height > DEEPEST:
            raise self._stop(event, f"lists and mappings go deeper than {DEEPEST} levels")
        self._attach(tree, None, event)

    def _attach(self, tree: Tree, anchor: str | None, alias: AliasEvent | None = None) -> None:
        if anchor:
            self._anchors[anchor] = tree
        self._values += 1
        parent = self._open[-1] if self._open else None
        size = tree.size + (parent.size if parent else 0)
        if max(size, self._values) > MOST_VALUES:
            place = self._place(alias) if alias else tree.place
            message = f"holds more than {MOST_VALUES} values"
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

    def _value(self, event: ScalarEvent) -> Scalar | Refused:
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

    def _place(self, event: Event) -> Place:
        mark = event.start_mark
        assert mark is not None
        line, column = mark.line, mark.column
        source = self.lines[line] if line < len(self.lines) else ""
        return Place(self._file, line + 1, column + 1, source)

    def _path(self) -> list[Step]:
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
