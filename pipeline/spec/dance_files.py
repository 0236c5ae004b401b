"""Dances that stand in files of their own, and where these are found."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from pydantic import Field

from pipeline.errors import Problem
from pipeline.spec.checking import check
from pipeline.spec.dance import Dance
from pipeline.spec.faults import Step
from pipeline.spec.files import read_file
from pipeline.spec.nearest import hint
from pipeline.spec.shipped import SUFFIX, library, names_in
from pipeline.spec.tree import Leaf, Place, Row, Table, Tree
from pipeline.spec.values import NAME_PATTERN, Words

Steps = tuple[Step, ...]

DANCES = "dances"
"""Folder of dances beside a scene and in the library."""

ORDINARY = "macarena"
"""What dancers dance who do not say what."""


class DanceFile(Words):
    """A file that holds one dance."""

    pronk: Literal[1] = Field(description="Version of the scene language.")
    dance: Dance = Field(description="The dance.")


@dataclass(slots=True)
class DanceSearch:
    """Looks for the dances that a scene names and does not hold.

    Attributes:
        beside: folder of the scene, None where it has none.
        problems: what is wrong with the dances and their names.
        files: names of the files that were read, in this order.
    """

    beside: Path | None
    problems: list[Problem] = field(default_factory=list)
    files: list[str] = field(default_factory=list)

    def complete(self, scene: Table) -> Table:
        """Return the scene with the dances that its cast names and it does not hold."""
        dances, cast = scene.get("dances"), scene.get("cast")
        if not isinstance(cast, Row) or not (dances is None or isinstance(dances, Table)):
            return scene
        held = dances or Table(scene.place, {})
        for path, named in _named(cast, scene.get("script")):
            if not (isinstance(named, Leaf) and isinstance(named.value, str)):
                continue
            name = named.value
            if name not in held.entries and re.fullmatch(NAME_PATTERN, name):
                found = self._find(name) or self._not_found(path, name, named.place, held)
                held = held.having(name, found.place, found)
        return scene.having("dances", held.place, held) if held.entries else scene

    def _find(self, name: str) -> Tree | None:
        folders = [library() / DANCES]
        if self.beside is not None:
            folders = [self.beside, self.beside / DANCES, *folders]
        for path in (folder / (name + SUFFIX) for folder in folders):
            if not path.is_file():
                continue
            tree, problems = read_file(path)
            if tree is not None and "dance" not in tree.entries:
                # A scene may be called like the dance that is danced in it.
                continue
            self.files.append(str(path))
            if tree is not None:
                problems = [*problems, *check(DanceFile, tree)[1]]
            self.problems += problems
            dance = tree.get("dance") if tree is not None else None
            return _STAND_IN if problems or dance is None else dance
        return None

    def _not_found(self, path: Steps, name: str, place: Place, held: Table) -> Tree:
        known = {*held.entries, *names_in(library() / DANCES)}
        if self.beside is not None:
            known |= {*names_in(self.beside / DANCES)}
        message = f"no dance is called '{name}', {hint(name, known)}"
        self.problems.append(place.problem(path, message))
        return _STAND_IN


def _named(cast: Row, script: Tree | None) -> Iterator[tuple[Steps, Tree]]:
    """Yield the names of dances that dancers dance from the begin, and are told to, with paths."""
    for i, member in enumerate(cast.items):
        if isinstance(member, Table) and "dancer" in member.entries:
            yield ("cast", i, "dance"), member.get("dance") or Leaf(member.place, ORDINARY)
    for i, one in enumerate(script.items if isinstance(script, Row) else ()):
        do = one.get("do") if isinstance(one, Table) else None
        if isinstance(do, Table) and (dance := do.get("dance")) is not None:
            yield ("script", i, "do", "dance"), dance


_NOWHERE = Place("")
# Takes the place of a dance that is wrong or missing, which is reported once already.
_STAND_IN: Tree = Table(_NOWHERE, {}).having(
    "subtasks",
    _NOWHERE,
    Row(_NOWHERE, (Table(_NOWHERE, {}).having("touch", _NOWHERE, Leaf(_NOWHERE, "chest")),)),
)
