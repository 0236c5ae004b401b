"""Overrides: values from the command line, `cast[0].walk.speed=0.5`, `cast.bug.walk.speed=1`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from pipeline.errors import Problem
from pipeline.spec.model_base import PathSegment
from pipeline.spec.partial_scene import member_names
from pipeline.spec.suggestions import hint
from pipeline.spec.yaml_reader import read_yaml
from pipeline.spec.yaml_tree import (
    Entry,
    ListNode,
    MappingNode,
    ScalarNode,
    SourceLocation,
    SourceNode,
    path_text,
    plain_values,
)

_STEP = re.compile(r"(?:^|\.)([^.\[\]=]+)|\[([0-9]{1,9})\]")

MAX_SHOWN = 80
"""Longer assignments are cut off in messages [characters]."""

# Blocks that may be the name of a preset: a change adjusts the preset.
_PRESETS = re.compile(r"terrain|light|materials\..+")

# Both keys give the length of a scene: setting one removes the other.
_ALTERNATIVES = {"frames": "duration", "duration": "frames"}


class _PathError(Exception):
    """The path of an assignment leads nowhere."""

    def __init__(self, path: Sequence[PathSegment], message: str) -> None:
        self.path = tuple(path)
        self.message = message


def override(scene: MappingNode, assignments: Sequence[str]) -> tuple[MappingNode, list[Problem]]:
    """Lay values over a scene.

    Args:
        scene: the scene as its file has it.
        assignments: `path=value` each; the value is YAML.

    Returns:
        The changed scene, and the problems of the assignments themselves.
    """
    problems: list[Problem] = []
    for text in assignments:
        is_short = len(text) <= MAX_SHOWN
        place = SourceLocation(f"--set {text if is_short else text[: MAX_SHOWN - 3] + '...'}")
        try:
            scene = _assigned(scene, text, place)
        except _PathError as error:
            problems.append(place.problem(error.path, error.message))
    return scene, problems


def _assigned(scene: MappingNode, assignment: str, place: SourceLocation) -> MappingNode:
    text, equals, value_text = assignment.partition("=")
    if not equals:
        raise _PathError((), "should be path=value, such as cast[0].walk.speed=0.5")
    path = _path(text.strip())
    value = _value(value_text, path, place)
    if len(path) == 1 and path[0] in _ALTERNATIVES:
        scene = scene.without(_ALTERNATIVES[str(path[0])])
    changed = _changed(scene, path, 0, value, place)
    assert isinstance(changed, MappingNode)
    return changed


def _path(text: str) -> list[PathSegment]:
    steps: list[PathSegment] = []
    end = 0
    while end < len(text):
        match = _STEP.match(text, end)
        if match is None or (match[2] and not steps):
            break
        steps.append(int(match[2]) if match[2] else match[1].strip())
        end = match.end()
    if end < len(text) or not steps or text.startswith("."):
        raise _PathError((), f"'{text}' is no path; write one as cast[0].walk.speed")
    return steps


def _value(text: str, path: Sequence[PathSegment], place: SourceLocation) -> SourceNode:
    tree, problems = read_yaml(text, place.file)
    if problems:
        raise _PathError(path, problems[0].message)
    return ScalarNode(place, None) if tree is None else _at_place(tree, place)


def _at_place(tree: SourceNode, place: SourceLocation) -> SourceNode:
    """Return the tree with all its nodes at one location."""
    match tree:
        case ScalarNode():
            return ScalarNode(place, tree.value)
        case ListNode():
            return ListNode(place, tuple(_at_place(item, place) for item in tree.items))
        case MappingNode():
            entries = {k: Entry(place, _at_place(e.value, place)) for k, e in tree.entries.items()}
            return MappingNode(place, entries)


def _changed(
    tree: SourceNode | None,
    path: Sequence[PathSegment],
    depth: int,
    value: SourceNode,
    place: SourceLocation,
) -> SourceNode:
    """Return the tree with the value below it at `path[depth:]`."""
    if depth == len(path):
        return value
    before, step = path[:depth], path[depth]
    if tree is None or (isinstance(tree, ScalarNode) and tree.value is None):
        tree = MappingNode(place, {})
    if isinstance(tree, ScalarNode) and isinstance(tree.value, str):
        if _PRESETS.fullmatch(path_text(before)):
            tree = MappingNode(tree.place, {"preset": Entry(tree.place, tree)})
    if isinstance(tree, ListNode):
        i = _index(tree, before, step)
        item = _changed(tree.items[i], [*before, i, *path[depth + 1 :]], depth + 1, value, place)
        return tree.with_item(i, item)
    if isinstance(tree, ScalarNode):
        raise _PathError(path, f"{path_text(before)} is no mapping, so nothing below it can be set")
    if isinstance(step, int):
        raise _PathError(path, f"{path_text(before)} is no list")
    entry = tree.entries.get(step)
    below = _changed(entry.value if entry else None, path, depth + 1, value, place)
    # The key stays where it stands in the file, unless it is new.
    return tree.with_entry(step, entry.key if entry else place, below)


def _index(row: ListNode, before: Sequence[PathSegment], step: PathSegment) -> int:
    where = path_text(before)
    if isinstance(step, int):
        if step < len(row.items):
            return step
        raise _PathError((*before, step), f"{where} has {len(row.items)} entries, counted from 0")
    names = member_names([plain_values(item) for item in row.items])
    if step in names:
        return names.index(step)
    close = hint(step, [name for name in names if not name.startswith("_")])
    raise _PathError((*before, step), f"nothing in {where} is called '{step}', {close}")
