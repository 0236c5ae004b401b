"""Renamed keys: earlier names of keys, which keep working with a warning."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.errors import Problem
from pipeline.spec.model_base import PathSegment
from pipeline.spec.yaml_tree import Entry, ListNode, MappingNode, SourceNode, path_text

EACH = "*"
"""Any entry of a list or mapping."""


@dataclass(frozen=True, slots=True)
class RenamedKey:
    """A key that has another name now.

    Attributes:
        block: path of the mapping that has it; `EACH` stands for any step.
        old: its earlier name.
        new: its name.
        beside: a key that the mapping must have as well, "" for none.
    """

    block: tuple[str, ...]
    old: str
    new: str
    beside: str = ""


RENAMED_KEYS = (
    RenamedKey((), "samples", "rows_per_frame"),
    RenamedKey(("cast", EACH, "walk"), "bounciness", "body_bob"),
    RenamedKey(("script", EACH, "do"), "bounciness", "body_bob", beside="gait"),
    RenamedKey(("moods", EACH), "bounciness", "body_bob"),
)


def rename_keys(scene: MappingNode) -> tuple[MappingNode, list[str], list[Problem]]:
    """Replace earlier names of keys by the present ones.

    Returns:
        The scene, a line of warning for each key that was renamed, and the keys that stand there
        under both names. A value from the command line replaces that of the file.
    """
    warnings: list[str] = []
    problems: list[Problem] = []
    tree: SourceNode = scene
    for key in RENAMED_KEYS:
        tree = _renamed(tree, key, key.block, (), warnings, problems)
    assert isinstance(tree, MappingNode)
    return tree, warnings, problems


def _renamed(
    tree: SourceNode,
    key: RenamedKey,
    block: tuple[str, ...],
    path: tuple[PathSegment, ...],
    warnings: list[str],
    problems: list[Problem],
) -> SourceNode:
    """Return the tree with a key renamed in the mappings at `block` below it."""
    if not block:
        return _renamed_here(tree, key, path, warnings, problems)
    step, below = block[0], block[1:]
    if isinstance(tree, ListNode) and step == EACH:
        for i, item in enumerate(tree.items):
            changed = _renamed(item, key, below, (*path, i), warnings, problems)
            tree = tree if changed is item else tree.with_item(i, changed)
    elif isinstance(tree, MappingNode):
        for name in tree.entries if step == EACH else tree.entries.keys() & {step}:
            value = tree.entries[name].value
            changed = _renamed(value, key, below, (*path, name), warnings, problems)
            tree = tree if changed is value else tree.with_value(name, changed)
    return tree


def _renamed_here(
    tree: SourceNode,
    key: RenamedKey,
    path: tuple[PathSegment, ...],
    warnings: list[str],
    problems: list[Problem],
) -> SourceNode:
    if not isinstance(tree, MappingNode) or key.old not in tree.entries:
        return tree
    if key.beside and key.beside not in tree.entries:
        return tree
    old = tree.entries[key.old]
    place = old.key
    if key.new in tree.entries:
        if old.value.place.line:
            message = (
                f"'{key.old}' is the earlier name of '{key.new}', which is given too; remove it"
            )
            problems.append(place.problem((*path, key.old), message))
            return tree.without(key.old)
        tree = tree.without(key.new)
    where = f"{place.file}:{place.line}" if place.line else place.file
    warnings.append(
        f"warning: {where}: {path_text((*path, key.old))} is now called {key.new}; write that"
    )
    entries = {
        key.new if name == key.old else name: Entry(entry.key, entry.value)
        for name, entry in tree.entries.items()
    }
    return MappingNode(tree.place, entries)
