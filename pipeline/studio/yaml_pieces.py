"""YAML pieces: changes of a YAML text at the marks of PyYAML's tree, all else byte for byte."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from yaml.nodes import CollectionNode, MappingNode, Node

from pipeline.errors import UsageError

DECIMALS = 4
"""Of a number that the editor writes: a tenth of a millimetre, or a tenth of a gram."""

ALIASES = (
    "the file is written in a way that the editor cannot change piece by piece, such as by "
    "aliases; change it as text"
)

_DECIMALS = re.compile(r"[-+]?\d*\.(\d+)")
_PLAIN = re.compile(r"[A-Za-z_][\w\-]*")
_WORDS = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}


@dataclass(frozen=True, slots=True)
class Edit:
    """A piece of the text and what stands there instead."""

    start: int
    end: int
    text: str


def with_edits(text: str, edits: Sequence[Edit]) -> str:
    """Return a text with some edits.

    Raises:
        UsageError: two of them meet, as where a value is shared by aliases.
    """
    ordered = sorted(edits, key=lambda e: (e.start, e.end))
    for one, other in itertools.pairwise(ordered):
        if other.start < one.end:
            raise UsageError(ALIASES)
    for edit in reversed(ordered):
        text = text[: edit.start] + edit.text + text[edit.end :]
    return text


def number_text(value: float, before: str = "") -> str:
    """Return a number as it is written, with at least the decimals of one that stood there."""
    found = _DECIMALS.fullmatch(before)
    rounded = round(value, DECIMALS) + 0.0
    if found is None or len(found[1]) > DECIMALS:
        return np.format_float_positional(rounded, trim="-")
    return np.format_float_positional(rounded, min_digits=len(found[1]))


def name_text(text: str) -> str:
    """Return a name, in quotes where it needs them."""
    is_plain = _PLAIN.fullmatch(text) and text.lower() not in _WORDS
    return text if is_plain else '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def flow_text(value: Any) -> str:
    """Return a value in one line: a name, a number, or a list or mapping of such."""
    if isinstance(value, str):
        return name_text(value)
    if isinstance(value, Mapping):
        words = (f"{name_text(key)}: {flow_text(one)}" for key, one in value.items())
        return "{" + ", ".join(words) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(flow_text, value)) + "]"
    return number_text(value)


def entries(mapping: Node) -> dict[str, tuple[Node, Node]]:
    """Return the key and value nodes of a mapping by key."""
    assert isinstance(mapping, MappingNode)
    return {str(key.value): (key, value) for key, value in mapping.value}


def last_mark(node: Node) -> int:
    """Return where the last scalar or flow collection of a node ends; blocks end lines later."""
    while isinstance(node, CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        node = last[1] if isinstance(last, tuple) else last
    return int(node.end_mark.index)


class Lines:
    """A text by lines.

    Args:
        text: YAML.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self.end = "\r\n" if "\r\n" in text else "\n"

    def start(self, index: int) -> int:
        """Return the start of the line of a place in the text."""
        return self.text.rfind("\n", 0, index) + 1

    def after(self, index: int) -> int:
        """Return the start of the line after a place in the text."""
        found = self.text.find("\n", index)
        return len(self.text) if found < 0 else found + 1

    def without(self, key: Node, value: Node) -> Edit:
        """Remove the lines of an entry."""
        return Edit(self.start(key.start_mark.index), self.after(last_mark(value)), "")

    def entry(self, name: str, value: Any, indent: str, step: str) -> str:
        """Return the lines of an entry: mappings of mappings by lines, others in one."""
        head = f"{indent}{name_text(name)}:"
        inside = value.values() if isinstance(value, Mapping) else [None]
        if not all(isinstance(one, Mapping) for one in inside):
            return f"{head} {flow_text(value)}{self.end}"
        lines = (self.entry(key, one, indent + step, step) for key, one in value.items())
        return f"{head}{self.end}{''.join(lines)}"

    def changed(
        self, node: MappingNode, before: Mapping[str, Any], after: Mapping[str, Any]
    ) -> Iterator[Edit]:
        """Change a mapping that is not to be empty.

        Args:
            node: of the mapping, as it stands in the text.
            before: what it holds.
            after: what it should hold.
        """
        there = entries(node)
        gone = [name for name in before if name not in after]
        new = {name: value for name, value in after.items() if name not in before}
        # In one line, where a comma goes with what is removed.
        if node.flow_style and gone:
            yield Edit(node.start_mark.index, node.end_mark.index, flow_text(after))
            return
        for name in gone:
            yield self.without(*there[name])
        for name, old in before.items():
            value = after.get(name)
            if value is None or value == old:
                continue
            own = there[name][1]
            if isinstance(value, Mapping) and isinstance(own, MappingNode):
                yield from self.changed(own, old, value)
            else:
                yield Edit(own.start_mark.index, last_mark(own), flow_text(value))
        if new and node.flow_style:
            words = "".join(f", {flow_text({k: v})[1:-1]}" for k, v in new.items())
            end = last_mark(node.value[-1][1])
            yield Edit(end, end, words)
        elif new:
            indent = " " * node.value[0][0].start_mark.column
            end = self.after(last_mark(node.value[-1][1]))
            lines = (self.entry(name, value, indent, "  ") for name, value in new.items())
            yield Edit(end, end, "".join(lines))
