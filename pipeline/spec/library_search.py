"""Library search: figures and dances that a scene names and that stand in files of their own."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from pipeline.errors import Problem
from pipeline.foreign_files.confinement import Confinement
from pipeline.foreign_files.safe_file import ForeignFileError
from pipeline.spec.dance import Dance
from pipeline.spec.figure import Figure
from pipeline.spec.model_base import MAX_NAME_LENGTH, NAME_PATTERN, ConfigModel, PathSegment
from pipeline.spec.scene_library import (
    DANCES,
    FIGURES,
    SUFFIX,
    existing_file,
    files_beside,
    is_file,
    is_path,
    library,
    missing_file_message,
    names_in,
)
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
    with_node,
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
    yield from _danced(scene, "script", ())
    story = scene.get("story")
    for b, beat in _mappings(story, "beats") if isinstance(story, MappingNode) else ():
        path: Steps = ("story", "beats", b)
        yield from _danced(beat, "do", path)
        for c, choice in _mappings(beat, "choices"):
            yield from _danced(choice, "do", (*path, "choices", c))


def _danced(holder: MappingNode, key: str, path: Steps) -> References:
    """Yield the dances of a list of instructions."""
    for i, instruction in _mappings(holder, key):
        do = instruction.get("do")
        if isinstance(do, MappingNode):
            yield (*path, key, i, "do", "dance"), do.get("dance")


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
        confinement: of an untrusted scene.
        problems: of the entries and their names.
        files: names of the files that were read, in this order.
    """

    beside: Path | None
    scene_file: str
    confinement: Confinement | None = None
    problems: list[Problem] = field(default_factory=list)
    files: list[str] = field(default_factory=list)
    _trees: dict[Path, tuple[MappingNode | None, list[Problem]]] = field(default_factory=dict)

    def complete(self, scene: MappingNode, block: LibraryBlock) -> MappingNode:
        """Return the scene with the entries of a block that it names and does not hold.

        Paths of files become names of entries, so that `./g3.yaml` is the same as `g3`.
        """
        held = scene.get(block.block)
        if not isinstance(scene.get("cast"), ListNode):
            return scene
        if not (held is None or isinstance(held, MappingNode)):
            return scene
        entries = held or MappingNode(scene.place, {})
        references = [
            (path, reference.value, reference.place)
            for path, reference in block.references(scene)
            if isinstance(reference, ScalarNode) and isinstance(reference.value, str)
        ]
        names_by_file: dict[Path, str] = {}
        for path, name, place in references:
            if _is_name(name) and name not in entries.entries:
                file = self._file_called(path, name, place, entries, block)
                if file is not None:
                    names_by_file[file.resolve()] = name
                entries = self._with_file(entries, name, file, block)
        # Files come after all names, none of which they may take.
        for path, text, place in references:
            if not is_path(text):
                continue
            file = self._file_at(path, text, place, block)
            whole = Path(text) if file is None else file.resolve()
            name = names_by_file.get(whole) or _unused_name(Path(text).stem, entries, block)
            if whole not in names_by_file:
                names_by_file[whole] = name
                entries = self._with_file(entries, name, file, block)
            scene = with_node(scene, path, ScalarNode(place, name))
        if not entries.entries:
            return scene
        return scene.with_entry(block.block, entries.place, entries)

    def _with_file(
        self, entries: MappingNode, name: str, file: Path | None, block: LibraryBlock
    ) -> MappingNode:
        found = tree_of(block.stand_in) if file is None else self._entry(file, block)
        return entries.with_entry(name, found.place, found)

    def _file_called(
        self,
        path: Steps,
        name: str,
        place: SourceLocation,
        entries: MappingNode,
        block: LibraryBlock,
    ) -> Path | None:
        """Return the file of a name in the scene; that there is none becomes a problem."""
        try:
            file = self._file_of(name, block)
        except ForeignFileError as error:
            self.problems.append(place.problem(path, f"'{name}' {error}"))
            return None
        if file is None:
            self._report(path, name, place, entries, block)
        return file

    def _file_of(self, name: str, block: LibraryBlock) -> Path | None:
        """Return the file of a name, None where there is none.

        Raises:
            ForeignFileError: the scene is untrusted, and the file leads out of its folder.
        """
        folders = [library() / block.block]
        if self.beside is not None:
            folders = [self.beside, self.beside / block.block, *folders]
        for path in (folder / (name + SUFFIX) for folder in folders):
            if str(path) == self.scene_file:
                continue
            # The library is not the author's.
            if self.confinement is not None and path.parent != folders[-1]:
                path = self.confinement.located(path)
            if not is_file(path):
                continue
            tree, _ = self._read(path)
            # A scene may be called like the figure or the dance in it.
            if tree is None or block.key in tree.entries:
                return path
        return None

    def _file_at(
        self, path: Steps, text: str, place: SourceLocation, block: LibraryBlock
    ) -> Path | None:
        """Return the file that a path in the scene leads to; what is wrong becomes a problem."""
        folder = self.beside or Path()
        try:
            file = existing_file(folder, text, self.confinement)
        except ForeignFileError as error:
            self.problems.append(place.problem(path, f"'{text}' {error}"))
            return None
        if file is None:
            message = missing_file_message(folder, text)
        elif (tree := self._read(file)[0]) is not None and block.key not in tree.entries:
            message = f"'{text}' holds no {block.key}; it lacks the key '{block.key}'"
        else:
            return file
        self.problems.append(place.problem(path, message))
        return None

    def _read(self, file: Path) -> tuple[MappingNode | None, list[Problem]]:
        if file not in self._trees:
            self._trees[file] = read_file(file)
        return self._trees[file]

    def _entry(self, file: Path, block: LibraryBlock) -> SourceNode:
        """Return the entry in a file; what is wrong with it becomes problems."""
        tree, problems = self._read(file)
        self.files.append(str(file))
        if tree is not None:
            problems = [*problems, *check(block.model, tree)[1]]
        self.problems += problems
        entry = tree.get(block.key) if tree is not None else None
        return tree_of(block.stand_in) if problems or entry is None else entry

    def _report(
        self,
        path: Steps,
        name: str,
        place: SourceLocation,
        entries: MappingNode,
        block: LibraryBlock,
    ) -> None:
        own = {*entries.entries}
        searched = "this file, the library"
        if self.beside is not None:
            own |= {*files_beside(self.beside, block.block, block.key, self.confinement)}
            files = f"{name}{SUFFIX} and {block.block}/{name}{SUFFIX}"
            searched = f"this file, {files} beside it, the library"
        shipped = names_in(library() / block.block)
        close = hint(name, shipped, block.block, own)
        message = f"no {block.key} is called '{name}', {close} (searched: {searched})"
        self.problems.append(place.problem(path, message))


def _is_name(text: str) -> bool:
    """Return whether a text can be a name; the model refuses others at their place."""
    return len(text) <= MAX_NAME_LENGTH and re.fullmatch(NAME_PATTERN, text) is not None


def _unused_name(stem: str, entries: MappingNode, block: LibraryBlock) -> str:
    """Return a name for the entry of a file: its stem, unless too long; numbered if taken."""
    name = first = stem if _is_name(stem) and len(stem) < MAX_NAME_LENGTH - 4 else block.key
    number = 1
    while name in entries.entries:
        number += 1
        name = f"{first}_{number}"
    return name
