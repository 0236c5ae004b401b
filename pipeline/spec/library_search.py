"""Library search: figures and dances that a scene names and that stand in files of their own."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from pipeline.errors import Problem
from pipeline.spec.dance import Dance
from pipeline.spec.figure import Figure
from pipeline.spec.model_base import NAME_PATTERN, ConfigModel, PathSegment
from pipeline.spec.scene_library import DANCES, FIGURES, SUFFIX, library, names_in
from pipeline.spec.suggestions import hint
from pipeline.spec.validation import check
from pipeline.spec.yaml_reader import read_file
from pipeline.spec.yaml_tree import (
    ListNode,
    MappingNode,
    ScalarNode,
    SourceLocation,
    SourceNode,
    tree_of,
)

Steps = tuple[PathSegment, ...]
References = Iterator[tuple[Steps, SourceNode | None]]

DEFAULT_DANCE = "macarena"


class FigureFile(ConfigModel):
    """A file that holds one figure."""

    pronk: Literal[1] = Field(description="Version of the scene language.")
    figure: Figure = Field(description="The drawing.")


class DanceFile(ConfigModel):
    """A file that holds one dance."""

    pronk: Literal[1] = Field(description="Version of the scene language.")
    dance: Dance = Field(description="The dance.")


@dataclass(frozen=True, slots=True)
class LibraryBlock:
    """A block of the scene whose entries may stand in files of their own.

    Attributes:
        key: key of the entry in its file.
        block: key of the block in a scene, and name of the folder.
        model: the whole file.
        stand_in: replaces an entry that is wrong or missing, which is reported once already.
        references: yields the names that a scene uses, with their paths.
    """

    key: str
    block: str
    model: type[ConfigModel]
    stand_in: Mapping[str, Any]
    references: Callable[[MappingNode], References]


def _mappings(scene: MappingNode, block: str) -> Iterator[tuple[int, MappingNode]]:
    """Yield the entries of a list of the scene that are mappings, with their indices."""
    held = scene.get(block)
    for i, entry in enumerate(held.items if isinstance(held, ListNode) else ()):
        if isinstance(entry, MappingNode):
            yield i, entry


def _figure_references(scene: MappingNode) -> References:
    for i, member in _mappings(scene, "cast"):
        yield ("cast", i, "figure"), member.get("figure")


def _dance_references(scene: MappingNode) -> References:
    for i, member in _mappings(scene, "cast"):
        if "dancer" in member.entries:
            name = member.get("dance") or ScalarNode(member.place, DEFAULT_DANCE)
            yield ("cast", i, "dance"), name
    for i, order in _mappings(scene, "script"):
        do = order.get("do")
        if isinstance(do, MappingNode):
            yield ("script", i, "do", "dance"), do.get("dance")


FIGURE_BLOCK = LibraryBlock(
    "figure", FIGURES, FigureFile, {"nodes": {"node": (0, 0)}}, _figure_references
)
DANCE_BLOCK = LibraryBlock(
    "dance", DANCES, DanceFile, {"subtasks": ({"touch": "chest"},)}, _dance_references
)


@dataclass(slots=True)
class LibrarySearch:
    """Completes a scene by the figures and dances that it names and does not hold.

    Attributes:
        beside: folder of the scene, None where it has none.
        scene_file: name of the file of the scene.
        problems: what is wrong with the entries and their names.
        files: names of the files that were read, in this order.
    """

    beside: Path | None
    scene_file: str
    problems: list[Problem] = field(default_factory=list)
    files: list[str] = field(default_factory=list)

    def complete(self, scene: MappingNode, block: LibraryBlock) -> MappingNode:
        """Return the scene with the entries of a block that it names and does not hold."""
        held = scene.get(block.block)
        if not isinstance(scene.get("cast"), ListNode):
            return scene
        if not (held is None or isinstance(held, MappingNode)):
            return scene
        entries = held or MappingNode(scene.place, {})
        for path, reference in block.references(scene):
            if not (isinstance(reference, ScalarNode) and isinstance(reference.value, str)):
                continue
            name = reference.value
            if name not in entries.entries and re.fullmatch(NAME_PATTERN, name):
                found = self._find(name, block)
                if found is None:
                    self._report(path, name, reference.place, entries, block)
                    found = tree_of(block.stand_in)
                entries = entries.with_entry(name, found.place, found)
        if not entries.entries:
            return scene
        return scene.with_entry(block.block, entries.place, entries)

    def _find(self, name: str, block: LibraryBlock) -> SourceNode | None:
        folders = [library() / block.block]
        if self.beside is not None:
            folders = [self.beside, self.beside / block.block, *folders]
        for path in (folder / (name + SUFFIX) for folder in folders):
            if not path.is_file() or str(path) == self.scene_file:
                continue
            tree, problems = read_file(path)
            if tree is not None and block.key not in tree.entries:
                # A scene may be called like the figure or the dance in it.
                continue
            self.files.append(str(path))
            if tree is not None:
                problems = [*problems, *check(block.model, tree)[1]]
            self.problems += problems
            entry = tree.get(block.key) if tree is not None else None
            return tree_of(block.stand_in) if problems or entry is None else entry
        return None

    def _report(
        self,
        path: Steps,
        name: str,
        place: SourceLocation,
        entries: MappingNode,
        block: LibraryBlock,
    ) -> None:
        known = {*entries.entries, *names_in(library() / block.block)}
        searched = "this file, the library"
        if self.beside is not None:
            known |= {*names_in(self.beside / block.block)}
            files = f"{name}{SUFFIX} and {block.block}/{name}{SUFFIX}"
            searched = f"this file, {files} beside it, the library"
        message = f"no {block.key} is called '{name}', {hint(name, known)} (searched: {searched})"
        self.problems.append(place.problem(path, message))
