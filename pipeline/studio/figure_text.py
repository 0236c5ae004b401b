"""Figure text: the YAML of a figure file with what the editor changed, all else byte for byte.

Each change replaces, inserts or removes one piece of the text at the marks of PyYAML's tree, so
comments, order and alignment stay. What the pieces make is read again and compared with the
drawing: a text that cannot be changed like this is refused, never damaged.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

import yaml
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from pipeline.errors import SceneError, UsageError
from pipeline.spec import Figure
from pipeline.spec.library_search import FigureFile
from pipeline.spec.validation import check
from pipeline.spec.yaml_reader import read_bytes
from pipeline.spec.yaml_tree import SourceMap
from pipeline.studio.drawing import MAPPINGS, SETTINGS, DrawnFigure, DrawnNode
from pipeline.studio.yaml_pieces import (
    ALIASES,
    DECIMALS,
    Edit,
    Lines,
    entries,
    flow_text,
    last_mark,
    name_text,
    number_text,
    with_edits,
)

NEW_FIGURE = """\
# A figure, drawn from above: head up, tail down, legs to the sides [m].
pronk: 1
figure:
  style: insect
  nodes:
  chains:
"""
"""What a new file holds before its first node."""


def figure_of_text(text: str) -> Figure:
    """Return the figure of a figure file.

    Raises:
        SceneError: it is wrong; holds every problem found.
    """
    return read_figure(text, "figure")[0]


def read_figure(text: str, file: str) -> tuple[Figure, SourceMap]:
    """Return the figure of a figure file, and where its values stand.

    Args:
        text: of the file.
        file: its name, in problems.

    Raises:
        SceneError: it is wrong; holds every problem found.
    """
    tree, problems = read_bytes(text.encode("utf-8", "surrogatepass"), file)
    if tree is None:
        raise SceneError(problems)
    loaded, invalid = check(FigureFile, tree)
    if loaded is None or problems or invalid:
        raise SceneError([*problems, *invalid])
    return loaded.figure, SourceMap(tree)


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
        changed = with_edits(lines, list(_edits(lines, before, drawing)))
    made = DrawnFigure.of(figure_of_text(changed))
    if rounded(made) != rounded(drawing):
        raise UsageError(ALIASES)
    return changed


def rounded(drawing: DrawnFigure) -> tuple[object, ...]:
    """Return the values of a drawing as they are compared and written."""
    nodes = [
        (name, _rounded(node.at), _rounded(node.radius)) for name, node in drawing.nodes.items()
    ]
    mappings = [_rounded(getattr(drawing, key)) for key in MAPPINGS]
    return nodes, drawing.chains, drawing.is_mirrored, mappings, drawing.settings


def _rounded(value: Any) -> Any:
    """Return a value whose numbers are as they are written."""
    if isinstance(value, Mapping):
        return {key: _rounded(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(one) for one in value]
    return round(value, DECIMALS) + 0.0 if isinstance(value, int | float) else value


def _node_text(node: DrawnNode) -> str:
    at = f"[{number_text(node.at[0])}, {number_text(node.at[1])}]"
    return at if node.radius is None else f"{{at: {at}, radius: {number_text(node.radius)}}}"


def _edits(text: str, before: DrawnFigure, after: DrawnFigure) -> Iterator[Edit]:
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    top = entries(root).get("figure") if isinstance(root, MappingNode) else None
    if top is None or not isinstance(top[1], MappingNode) or top[1].flow_style:
        raise UsageError("the figure is no block of keys; change it as text")
    yield from _FigureEdits(text, top[1], before, after).all()


class _FigureEdits:
    """Finds the edits between two drawings of one figure."""

    def __init__(
        self, text: str, figure: MappingNode, before: DrawnFigure, after: DrawnFigure
    ) -> None:
        self._lines = Lines(text)
        self._figure = figure
        self._keys = entries(figure)
        self._before = before
        self._after = after
        first = figure.value[0][0]
        self._indent = " " * first.start_mark.column

    def all(self) -> Iterator[Edit]:
        """Yield the edits of all keys."""
        for key in SETTINGS:
            yield from self._setting(key)
        yield from self._nodes()
        blocks = [*self._missing_chains(), *self._missing_mirror()]
        if "chains" in self._keys:
            yield from self._chains()
        if self._before.is_mirrored and self._after.is_mirrored is False:
            yield self._without("then")
        for key in MAPPINGS:
            before, after = getattr(self._before, key), getattr(self._after, key)
            if before == after:
                continue
            if key not in self._keys:
                blocks.append(self._lines.entry(key, after, self._indent, "  "))
            elif not after:
                yield self._without(key)
            else:
                yield from self._mapping(key, before, after)
        if blocks:
            has_chains = "chains" in self._keys
            end = self._lines.after(last_mark(self._keys["chains" if has_chains else "nodes"][1]))
            yield Edit(end, end, "".join(blocks))

    def _setting(self, key: str) -> Iterator[Edit]:
        old, new = self._before.settings.get(key), self._after.settings.get(key)
        if old == new:
            return
        if new is None:
            yield self._without(key)
        elif old is None:
            start = self._lines.start(self._figure.value[0][0].start_mark.index)
            yield Edit(start, start, f"{self._indent}{key}: {new}{self._lines.end}")
        else:
            value = self._keys[key][1]
            yield Edit(value.start_mark.index, value.end_mark.index, new)

    def _nodes(self) -> Iterator[Edit]:
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
        there = entries(value)
        for name in before:
            if name not in after:
                yield self._lines.without(*there[name])
            elif before[name] != after[name]:
                yield from self._node(there[name][1], before[name], after[name])
        new = {name: node for name, node in after.items() if name not in before}
        if new:
            indent = " " * value.value[0][0].start_mark.column
            lines = (f"{indent}{name_text(name)}: {_node_text(n)}" for name, n in new.items())
            end = self._lines.after(value.value[-1][1].end_mark.index)
            yield Edit(end, end, "".join(f"{line}{self._lines.end}" for line in lines))

    def _whole_nodes(self, value: Node) -> Edit:
        """Write all nodes anew, where none of the old lines can stay."""
        if self._before.nodes and any(_has_more(node) for _, node in entries(value).values()):
            raise UsageError("the nodes are not written line by line; change them as text")
        indent = self._indent * 2
        lines = (
            f"{self._lines.end}{indent}{name_text(name)}: {_node_text(node)}"
            for name, node in self._after.nodes.items()
        )
        key = self._keys["nodes"][0]
        start = self._lines.text.index(":", key.end_mark.index) + 1
        end = value.end_mark.index
        if isinstance(value, MappingNode) and not value.flow_style:
            end = self._lines.after(value.value[-1][1].end_mark.index) - len(self._lines.end)
        elif isinstance(value, ScalarNode):
            end = start
        return Edit(start, end, "".join(lines))

    def _node(self, value: Node, before: DrawnNode, after: DrawnNode) -> Iterator[Edit]:
        at, radius = value, None
        if isinstance(value, MappingNode):
            keys = entries(value)
            at = keys["at"][1]
            radius = keys["radius"][1] if "radius" in keys else None
        assert isinstance(at, SequenceNode)
        for i in range(2):
            if round(before.at[i] - after.at[i], DECIMALS):
                scalar = at.value[i]
                marks = scalar.start_mark.index, scalar.end_mark.index
                yield Edit(*marks, number_text(after.at[i], scalar.value))
        if before.radius == after.radius or after.radius is None:
            return
        size = number_text(after.radius, radius.value if radius is not None else "")
        if radius is not None:
            yield Edit(radius.start_mark.index, radius.end_mark.index, size)
        elif value is at:
            yield Edit(at.start_mark.index, at.start_mark.index, "{at: ")
            yield Edit(at.end_mark.index, at.end_mark.index, f", radius: {size}}}")
        elif isinstance(value, MappingNode) and value.flow_style:
            yield Edit(at.end_mark.index, at.end_mark.index, f", radius: {size}")
        else:
            assert isinstance(value, MappingNode)
            indent = " " * value.value[0][0].start_mark.column
            end = self._lines.after(at.end_mark.index)
            yield Edit(end, end, f"{indent}radius: {size}{self._lines.end}")

    def _chains(self) -> Iterator[Edit]:
        before, after = self._before.chains, self._after.chains
        value = self._keys["chains"][1]
        # A new figure has a key without a list.
        if before == after and not isinstance(value, ScalarNode):
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
                yield Edit(node.start_mark.index, node.end_mark.index, flow_text(after[j1 + k]))
            for k in range(i1 + shared, i2):
                node = items[k]
                start = self._lines.start(node.start_mark.index)
                yield Edit(start, self._lines.after(node.end_mark.index), "")
            new = after[j1 + shared : j2]
            if new:
                last = items[i1 + shared - 1] if i1 + shared else None
                place = (
                    self._lines.start(items[0].start_mark.index)
                    if last is None
                    else self._lines.after(last.end_mark.index)
                )
                lines = (f"{indent}- {flow_text(chain)}{self._lines.end}" for chain in new)
                yield Edit(place, place, "".join(lines))

    def _whole_chains(self, value: Node) -> Edit:
        key = self._keys["chains"][0]
        start = self._lines.text.index(":", key.end_mark.index) + 1
        end = start if isinstance(value, ScalarNode) else value.end_mark.index
        if isinstance(value, SequenceNode) and not value.flow_style and value.value:
            end = self._lines.after(value.value[-1].end_mark.index) - len(self._lines.end)
        lines = (f"{self._lines.end}{self._indent * 2}- {flow_text(c)}" for c in self._after.chains)
        return Edit(start, end, "".join(lines) or " []")

    def _missing_chains(self) -> Iterator[str]:
        if "chains" not in self._keys and self._after.chains:
            lines = "".join(
                f"{self._indent * 2}- {flow_text(c)}{self._lines.end}" for c in self._after.chains
            )
            yield f"{self._indent}chains:{self._lines.end}{lines}"

    def _missing_mirror(self) -> Iterator[str]:
        if self._after.is_mirrored and self._before.is_mirrored is False:
            if "then" in self._keys:
                raise UsageError("the figure has a key 'then' without operations; remove it")
            end = self._lines.end
            yield f"{self._indent}then:{end}{self._indent * 2}- mirror: x{end}"

    def _mapping(
        self, key: str, before: Mapping[str, object], after: Mapping[str, object]
    ) -> Iterator[Edit]:
        """Change a key whose value is a mapping."""
        value = self._keys[key][1]
        if before and isinstance(value, MappingNode):
            yield from self._lines.changed(value, before, after)
        else:
            yield Edit(value.start_mark.index, value.end_mark.index, flow_text(after))

    def _without(self, key: str) -> Edit:
        """Remove a key of the figure with its lines."""
        return self._lines.without(*self._keys[key])


def _has_more(node: Node) -> bool:
    """Return whether a node of the drawing has keys that the editor does not write."""
    return isinstance(node, MappingNode) and not set(entries(node)) <= {"at", "radius"}
