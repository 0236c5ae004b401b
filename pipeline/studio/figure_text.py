"""Figure text: the YAML of a figure file with what the editor changed, all else byte for byte.

Each change replaces, inserts or removes one piece of the text at the marks of PyYAML's tree, so
comments, order and alignment stay. What the pieces make is read again and compared with the
drawing: a text that cannot be changed like this is refused, never damaged.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import yaml
from yaml.nodes import CollectionNode, MappingNode, Node, ScalarNode, SequenceNode

from pipeline.errors import SceneError, UsageError
from pipeline.spec import Figure
from pipeline.spec.library_search import FigureFile
from pipeline.spec.validation import check
from pipeline.spec.yaml_reader import read_bytes
from pipeline.studio.drawing import SETTINGS, DrawnFigure, DrawnNode

DECIMALS = 4
"""Of a number that the editor writes: a tenth of a millimetre."""

NEW_FIGURE = """\
# A figure, drawn from above: head up, tail down, legs to the sides [m].
pronk: 1
figure:
  style: insect
  nodes:
  chains:
"""
"""What a new file holds before its first node."""

_PLAIN = re.compile(r"[A-Za-z_][\w\-]*")
_WORDS = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}


@dataclass(frozen=True, slots=True)
class _Edit:
    """A piece of the text and what stands there instead."""

    start: int
    end: int
    text: str


def figure_of_text(text: str, file: str = "figure") -> Figure:
    """Return the figure of a figure file.

    Raises:
        SceneError: it is wrong; holds every problem found.
    """
    tree, problems = read_bytes(text.encode("utf-8", "surrogatepass"), file)
    if tree is None:
        raise SceneError(problems)
    loaded, invalid = check(FigureFile, tree)
    if loaded is None or problems or invalid:
        raise SceneError([*problems, *invalid])
    return loaded.figure


def updated_text(text: str, drawing: DrawnFigure) -> str:
    """Return the text of a figure file with a drawing in it.

    Args:
        text: of the file; `NEW_FIGURE` for a new one.
        drawing: what the nodes, chains and other values should be.

    Raises:
        UsageError: the text cannot be changed piece by piece.
        SceneError: the drawing is no figure.
    """
    if text == NEW_FIGURE:
        before, changed = DrawnFigure(settings={"style": "insect"}), text
    else:
        before = DrawnFigure.of(figure_of_text(text))
        changed = text
    if rounded(before) != rounded(drawing):
        # New lines may follow the last one.
        lines = text if text.endswith("\n") else text + "\n"
        changed = _with_edits(lines, list(_edits(lines, before, drawing)))
    made = DrawnFigure.of(figure_of_text(changed))
    if rounded(made) != rounded(drawing):
        raise UsageError(
            "the file is written in a way that the editor cannot change piece by piece, such as "
            "by aliases; change it as text"
        )
    return changed


def rounded(drawing: DrawnFigure) -> tuple[object, ...]:
    """Return the values of a drawing as they are compared and written."""
    nodes = [
        (name, *(round(v, DECIMALS) + 0.0 for v in node.at), _rounded_radius(node))
        for name, node in drawing.nodes.items()
    ]
    return nodes, drawing.chains, drawing.is_mirrored, drawing.parts, drawing.settings


def _rounded_radius(node: DrawnNode) -> float | None:
    return None if node.radius is None else round(node.radius, DECIMALS)


def _number(value: float) -> str:
    return f"{round(value, DECIMALS) + 0.0:.{DECIMALS}f}".rstrip("0").rstrip(".")


def _name(text: str) -> str:
    is_plain = _PLAIN.fullmatch(text) and text.lower() not in _WORDS
    return text if is_plain else '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _list(names: tuple[str, ...]) -> str:
    return "[" + ", ".join(map(_name, names)) + "]"


def _node_text(node: DrawnNode) -> str:
    at = f"[{_number(node.at[0])}, {_number(node.at[1])}]"
    return at if node.radius is None else f"{{at: {at}, radius: {_number(node.radius)}}}"


def _with_edits(text: str, edits: list[_Edit]) -> str:
    for edit in sorted(edits, key=lambda e: (e.start, e.end), reverse=True):
        text = text[: edit.start] + edit.text + text[edit.end :]
    return text


def _edits(text: str, before: DrawnFigure, after: DrawnFigure) -> Iterator[_Edit]:
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    top = _entries(root).get("figure") if isinstance(root, MappingNode) else None
    if top is None or not isinstance(top[1], MappingNode) or top[1].flow_style:
        raise UsageError("the figure is no block of keys; change it as text")
    yield from _FigureEdits(text, top[1], before, after).all()


def _entries(mapping: Node) -> dict[str, tuple[Node, Node]]:
    """Return the key and value nodes of a mapping by key."""
    assert isinstance(mapping, MappingNode)
    return {str(key.value): (key, value) for key, value in mapping.value}


class _FigureEdits:
    """Finds the edits between two drawings of one figure."""

    def __init__(
        self, text: str, figure: MappingNode, before: DrawnFigure, after: DrawnFigure
    ) -> None:
        self._text = text
        self._figure = figure
        self._keys = _entries(figure)
        self._before = before
        self._after = after
        first = figure.value[0][0]
        self._indent = " " * first.start_mark.column
        self._newline = "\r\n" if "\r\n" in text else "\n"

    def all(self) -> Iterator[_Edit]:
        """Yield the edits of all keys."""
        for key in SETTINGS:
            yield from self._setting(key)
        yield from self._nodes()
        blocks = [*self._missing_chains(), *self._missing_mirror(), *self._missing_parts()]
        if "chains" in self._keys:
            yield from self._chains()
        if self._before.is_mirrored and self._after.is_mirrored is False:
            yield self._without("then")
        if "parts" in self._keys:
            yield from self._parts()
        if blocks:
            end = self._end("chains" if "chains" in self._keys else "nodes")
            yield _Edit(end, end, "".join(blocks))

    def _setting(self, key: str) -> Iterator[_Edit]:
        old, new = self._before.settings.get(key), self._after.settings.get(key)
        if old == new:
            return
        if new is None:
            yield self._without(key)
        elif old is None:
            start = self._line_start(self._figure.value[0][0].start_mark.index)
            yield _Edit(start, start, f"{self._indent}{key}: {new}{self._newline}")
        else:
            value = self._keys[key][1]
            yield _Edit(value.start_mark.index, value.end_mark.index, new)

    def _nodes(self) -> Iterator[_Edit]:
        before, after = self._before.nodes, self._after.nodes
        value = self._keys["nodes"][1] if "nodes" in self._keys else None
        if value is None:
            raise UsageError("the figure has no key 'nodes'")
        if before == after:
            return
        is_block = isinstance(value, MappingNode) and not value.flow_style
        kept = [name for name in before if name in after]
        if not is_block or not kept or kept != [name for name in after if name in before]:
            yield self._whole_nodes(value)
            return
        entries = _entries(value)
        for name in before:
            if name not in after:
                yield self._line_of(*entries[name])
            elif before[name] != after[name]:
                yield from self._node(entries[name][1], before[name], after[name])
        new = {name: node for name, node in after.items() if name not in before}
        if new:
            indent = " " * value.value[0][0].start_mark.column
            lines = (f"{indent}{_name(name)}: {_node_text(n)}" for name, n in new.items())
            end = self._after_line(value.value[-1][1].end_mark.index)
            yield _Edit(end, end, "".join(f"{line}{self._newline}" for line in lines))

    def _whole_nodes(self, value: Node) -> _Edit:
        """Write all nodes anew, where none of the old lines can stay."""
        if self._before.nodes and any(_has_more(node) for _, node in _entries(value).values()):
            raise UsageError("the nodes are not written line by line; change them as text")
        indent = self._indent * 2
        lines = (
            f"{self._newline}{indent}{_name(name)}: {_node_text(node)}"
            for name, node in self._after.nodes.items()
        )
        key = self._keys["nodes"][0]
        start = self._text.index(":", key.end_mark.index) + 1
        end = value.end_mark.index
        if isinstance(value, MappingNode) and not value.flow_style:
            end = self._after_line(value.value[-1][1].end_mark.index) - len(self._newline)
        elif isinstance(value, ScalarNode):
            end = start
        return _Edit(start, end, "".join(lines))

    def _node(self, value: Node, before: DrawnNode, after: DrawnNode) -> Iterator[_Edit]:
        at, radius = value, None
        if isinstance(value, MappingNode):
            keys = _entries(value)
            at = keys["at"][1]
            radius = keys["radius"][1] if "radius" in keys else None
        assert isinstance(at, SequenceNode)
        for i in range(2):
            if round(before.at[i] - after.at[i], DECIMALS):
                scalar = at.value[i]
                marks = scalar.start_mark.index, scalar.end_mark.index
                yield _Edit(*marks, _number(after.at[i]))
        if before.radius == after.radius or after.radius is None:
            return
        size = _number(after.radius)
        if radius is not None:
            yield _Edit(radius.start_mark.index, radius.end_mark.index, size)
        elif value is at:
            yield _Edit(at.start_mark.index, at.start_mark.index, "{at: ")
            yield _Edit(at.end_mark.index, at.end_mark.index, f", radius: {size}}}")
        elif isinstance(value, MappingNode) and value.flow_style:
            yield _Edit(at.end_mark.index, at.end_mark.index, f", radius: {size}")
        else:
            assert isinstance(value, MappingNode)
            indent = " " * value.value[0][0].start_mark.column
            end = self._after_line(at.end_mark.index)
            yield _Edit(end, end, f"{indent}radius: {size}{self._newline}")

    def _chains(self) -> Iterator[_Edit]:
        before, after = self._before.chains, self._after.chains
        value = self._keys["chains"][1]
        if before == after:
            return
        if not isinstance(value, SequenceNode) or value.flow_style or not before:
            yield self._whole_chains(value)
            return
        items = value.value
        indent = " " * value.start_mark.column
        matcher = difflib.SequenceMatcher(None, before, after, autojunk=False)
        for change, i1, i2, j1, j2 in matcher.get_opcodes():
            if change == "equal":
                continue
            shared = min(i2 - i1, j2 - j1)
            for k in range(shared):
                node = items[i1 + k]
                if not node.flow_style:
                    raise UsageError("the chains are not written line by line")
                yield _Edit(node.start_mark.index, node.end_mark.index, _list(after[j1 + k]))
            for k in range(i1 + shared, i2):
                node = items[k]
                start = self._line_start(node.start_mark.index)
                yield _Edit(start, self._after_line(node.end_mark.index), "")
            new = after[j1 + shared : j2]
            if new:
                last = items[i1 + shared - 1] if i1 + shared else None
                place = (
                    self._line_start(items[0].start_mark.index)
                    if last is None
                    else self._after_line(last.end_mark.index)
                )
                lines = (f"{indent}- {_list(chain)}{self._newline}" for chain in new)
                yield _Edit(place, place, "".join(lines))

    def _whole_chains(self, value: Node) -> _Edit:
        key = self._keys["chains"][0]
        start = self._text.index(":", key.end_mark.index) + 1
        end = start if isinstance(value, ScalarNode) else value.end_mark.index
        if isinstance(value, SequenceNode) and not value.flow_style and value.value:
            end = self._after_line(value.value[-1].end_mark.index) - len(self._newline)
        lines = (f"{self._newline}{self._indent * 2}- {_list(c)}" for c in self._after.chains)
        return _Edit(start, end, "".join(lines) or " []")

    def _missing_chains(self) -> Iterator[str]:
        if "chains" not in self._keys and self._after.chains:
            lines = "".join(
                f"{self._indent * 2}- {_list(c)}{self._newline}" for c in self._after.chains
            )
            yield f"{self._indent}chains:{self._newline}{lines}"

    def _missing_mirror(self) -> Iterator[str]:
        if self._after.is_mirrored and self._before.is_mirrored is False:
            if "then" in self._keys:
                raise UsageError("the figure has a key 'then' without operations; remove it")
            yield (
                f"{self._indent}then:{self._newline}{self._indent * 2}- mirror: x{self._newline}"
            )

    def _missing_parts(self) -> Iterator[str]:
        if "parts" not in self._keys and self._after.parts:
            yield f"{self._indent}parts: {_mapping(self._after.parts)}{self._newline}"

    def _parts(self) -> Iterator[_Edit]:
        if self._before.parts == self._after.parts:
            return
        if not self._after.parts:
            yield self._without("parts")
            return
        key, value = self._keys["parts"]
        start = self._text.index(":", key.end_mark.index) + 1
        end = value.end_mark.index
        if isinstance(value, MappingNode) and not value.flow_style:
            end = value.value[-1][1].end_mark.index
        yield _Edit(start, end, f" {_mapping(self._after.parts)}")

    def _without(self, key: str) -> _Edit:
        """Remove a key of the figure with its lines."""
        return self._line_of(*self._keys[key])

    def _line_of(self, key: Node, value: Node) -> _Edit:
        last = _last_mark(value)
        return _Edit(self._line_start(key.start_mark.index), self._after_line(last), "")

    def _end(self, key: str) -> int:
        return self._after_line(_last_mark(self._keys[key][1]) or 0)

    def _line_start(self, index: int) -> int:
        return self._text.rfind("\n", 0, index) + 1

    def _after_line(self, index: int) -> int:
        """Return the start of the line after a place in the text."""
        found = self._text.find("\n", index)
        return len(self._text) if found < 0 else found + 1


def _last_mark(node: Node) -> int:
    """Return where the last scalar or flow collection of a node ends; blocks end lines later."""
    while isinstance(node, CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        node = last[1] if isinstance(last, tuple) else last
    return int(node.end_mark.index)


def _has_more(node: Node) -> bool:
    """Return whether a node of the drawing has keys that the editor does not write."""
    return isinstance(node, MappingNode) and not set(_entries(node)) <= {"at", "radius"}


def _mapping(words: Mapping[str, str]) -> str:
    return "{" + ", ".join(f"{_name(key)}: {_name(value)}" for key, value in words.items()) + "}"
