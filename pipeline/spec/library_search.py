"""Library search: figures and dances that a scene names and that stand in files of their own."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from pipeline.errors import Problem, UsageError
from pipeline.spec.dance import Dance
from pipeline.spec.figure import Figure
from pipeline.spec.model_base import NAME_PATTERN, ConfigModel, PathSegment
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

# --- Scene library: files of scenes and figures by their names, beside the author's and shipped

SUFFIX = ".yaml"
FIGURES = "figures"
"""Folder of figure files beside a scene and in the library."""

Steps = tuple[PathSegment, ...]
References = Iterator[tuple[Steps, SourceNode | None]]

DANCES = "dances"
"""Folder of dances beside a scene and in the library."""

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
    """

    key: str
    block: str
    model: type[ConfigModel]
    stand_in: Mapping[str, Any]

    def references(self, scene: MappingNode) -> References:
        """Yield the names that the scene uses, with their paths."""
        cast, script = scene.get("cast"), scene.get("script")
        for i, member in enumerate(cast.items if isinstance(cast, ListNode) else ()):
            if not isinstance(member, MappingNode):
                continue
            name = member.get(self.key)
            if self.key == "dance" and "dancer" not in member.entries:
                continue
            if self.key == "dance" and name is None:
                name = ScalarNode(member.place, DEFAULT_DANCE)
            yield ("cast", i, self.key), name
        if self.key == "dance":
            for i, order in enumerate(script.items if isinstance(script, ListNode) else ()):
                do = order.get("do") if isinstance(order, MappingNode) else None
                if isinstance(do, MappingNode):
                    yield ("script", i, "do", "dance"), do.get("dance")


FIGURE_BLOCK = LibraryBlock("figure", FIGURES, FigureFile, {"nodes": {"node": (0, 0)}})
DANCE_BLOCK = LibraryBlock("dance", DANCES, DanceFile, {"subtasks": ({"touch": "chest"},)})


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


def library() -> Path:
    """Return the folder of the shipped scenes; its folder `figures` holds the shipped figures."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "scenes"
    # A wheel carries the library inside the package, a checkout beside it.
    return installed if installed.is_dir() else package.parent / "scenes"


def shipped_scenes() -> list[str]:
    """Return the names of the shipped scenes."""
    return names_in(library())


def names_in(folder: Path) -> list[str]:
    """Return the names of the files in a folder that may hold a scene or a figure."""
    try:
        return sorted(path.stem for path in folder.glob("*" + SUFFIX) if path.is_file())
    except OSError:
        return []


def find_scene(name: str) -> Path:
    """Return the file of a scene, given its path or its name.

    A name stands for a file in the current folder, else for a shipped scene.

    Raises:
        UsageError: there is no such scene.
    """
    given = Path(name)
    beside = given if name.endswith(SUFFIX) else Path(name + SUFFIX)
    try:
        # A folder `bug` does not hide the scene `bug.yaml`.
        for path in (given, beside):
            if path.exists() and not path.is_dir():
                return path
        shipped = library() / beside
        if len(beside.parts) == 1 and shipped.is_file():
            return shipped
        if given.is_dir():
            raise UsageError(f"'{name}' is a folder; give the file of a scene")
    except (OSError, ValueError) as error:
        raise UsageError(f"no scene can be called {name!r}: {error}") from None
    raise UsageError(_not_found(name, beside))


def find_figure(name: str) -> tuple[Path, str]:
    """Return the file of a figure's name, and the figure in that file.

    A name stands for a file in the current folder, for one in its folder `figures`, for a
    shipped figure, or for a shipped scene. `scene:figure` names a figure of a scene.

    Returns:
        The file, and what stands after the colon, empty if there is none.

    Raises:
        UsageError: there is nothing of that name.
    """
    file, colon, figure = name.rpartition(":")
    # On Windows a path may begin with the letter of a drive.
    if colon and not figure.startswith(("/", "\\")):
        return find_scene(file), figure
    beside = name if name.endswith(SUFFIX) else name + SUFFIX
    try:
        for path in (
            Path(name),
            Path(beside),
            Path(FIGURES) / beside,
            library() / FIGURES / beside,
        ):
            if path.is_file():
                return path, ""
        return find_scene(name), ""
    except (OSError, ValueError) as error:
        raise UsageError(f"no figure can be called {name!r}: {error}") from None
    except UsageError:
        known = {*shipped_scenes(), *names_in(library() / FIGURES)}
        known |= {*names_in(Path()), *names_in(Path(FIGURES))}
    raise UsageError(f"no figure or scene is called {name!r}, {hint(name, known)}")


def _not_found(name: str, beside: Path) -> str:
    if len(beside.parts) > 1:
        known = names_in(beside.parent)
        close = hint(beside.stem, known) if known else "the folder holds no scenes"
        return f"there is no file '{name}'; {close}"
    shipped = shipped_scenes()
    close = hint(beside.stem, [*names_in(Path()), *shipped])
    return f"no scene is called '{name}', neither in this folder nor among the shipped; {close}"
