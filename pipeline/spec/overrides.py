"""Values given on the command line: `cast[0].walk.speed=0.5`, `cast.bug.walk.speed=1`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from pipeline.errors import Problem
from pipeline.spec.cast import called, names_of
from pipeline.spec.faults import Step
from pipeline.spec.nearest import hint
from pipeline.spec.reader import read_yaml
from pipeline.spec.tree import Entry, Leaf, Place, Row, Table, Tree, path_text, plain

_STEP = re.compile(r"(?:^|\.)([^.\[\]=]+)|\[([0-9]{1,9})\]")

# Blocks for which the name of a preset may stand: a change adjusts the preset.
_PRESETS = re.compile(r"terrain|light|materials\..+")

# Either word says how long a scene lasts: giving one takes the other back.
_INSTEAD = {"frames": "duration", "duration": "frames"}


class _Wrong(Exception):
    """An override leads nowhere."""

    def __init__(self, path: Sequence[Step], message: str) -> None:
        self.path = tuple(path)
        self.message = message


def override(scene: Table, words: Sequence[str]) -> tuple[Table, list[Problem]]:
    """Lay values over a scene.

    Args:
        scene: the scene as its file has it.
        words: `path=value` each; the value is YAML.

    Returns:
        The changed scene, and what is wrong with the words themselves.
    """
    problems: list[Problem] = []
    for one in words:
        place = Place(f"--set {one if len(one) <= 80 else one[:77] + '...'}")
        try:
            scene = _overridden(scene, one, place)
        except _Wrong as wrong:
            problems.append(place.problem(wrong.path, wrong.message))
    return scene, problems


def _overridden(scene: Table, words: str, place: Place) -> Table:
    text, equals, value_text = words.partition("=")
    if not equals:
        raise _Wrong((), "should be path=value, such as cast[0].walk.speed=0.5")
    path = _path(text.strip())
    value = _value(value_text, path, place)
    if len(path) == 1 and path[0] in _INSTEAD:
        scene = scene.without(_INSTEAD[str(path[0])])
    changed = _changed(scene, path, 0, value, place)
    assert isinstance(changed, Table)
    return changed


def _path(text: str) -> list[Step]:
    steps: list[Step] = []
    end = 0
    while end < len(text):
        match = _STEP.match(text, end)
        if match is None or (match[2] and not steps):
            break
        steps.append(int(match[2]) if match[2] else match[1].strip())
        end = match.end()
    if end < len(text) or not steps or text.startswith("."):
        raise _Wrong((), f"'{text}' is no path; write one as cast[0].walk.speed")
    return steps


def _value(text: str, path: Sequence[Step], place: Place) -> Tree:
    tree, problems = read_yaml(text, place.file)
    if problems:
        raise _Wrong(path, problems[0].message)
    return Leaf(place, None) if tree is None else _moved(tree, place)


def _moved(tree: Tree, place: Place) -> Tree:
    match tree:
        case Leaf():
            return Leaf(place, tree.value)
        case Row():
            return Row(place, tuple(_moved(item, place) for item in tree.items))
        case Table():
            entries = {k: Entry(place, _moved(e.value, place)) for k, e in tree.entries.items()}
            return Table(place, entries)


def _changed(
    tree: Tree | None, path: Sequence[Step], depth: int, value: Tree, place: Place
) -> Tree:
    """Return the tree with the value below it at `path[depth:]`."""
    if depth == len(path):
        return value
    before, step = path[:depth], path[depth]
    if tree is None or (isinstance(tree, Leaf) and tree.value is None):
        tree = Table(place, {})
    if isinstance(tree, Leaf) and isinstance(tree.value, str):
        if _PRESETS.fullmatch(path_text(before)):
            tree = Table(tree.place, {"preset": Entry(tree.place, tree)})
    if isinstance(tree, Row):
        i = _index(tree, before, step)
        item = _changed(tree.items[i], [*before, i, *path[depth + 1 :]], depth + 1, value, place)
        return Row(tree.place, (*tree.items[:i], item, *tree.items[i + 1 :]))
    if isinstance(tree, Leaf):
        raise _Wrong(path, f"{path_text(before)} is no mapping, so nothing below it can be set")
    if isinstance(step, int):
        raise _Wrong(path, f"{path_text(before)} is no list")
    entry = tree.entries.get(step)
    below = _changed(entry.value if entry else None, path, depth + 1, value, place)
    # The key stays where it stands in the file, unless it is new.
    return tree.having(step, entry.key if entry else place, below)


def _index(row: Row, before: Sequence[Step], step: Step) -> int:
    where = path_text(before)
    if isinstance(step, int):
        if step < len(row.items):
            return step
        raise _Wrong((*before, step), f"{where} has {len(row.items)} entries, counted from 0")
    names = names_of([called(plain(item)) for item in row.items])
    if step in names:
        return names.index(step)
    close = hint(step, [name for name in names if not name.startswith("_")])
    raise _Wrong((*before, step), f"nothing in {where} is called '{step}', {close}")
