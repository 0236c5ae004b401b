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
from pipeline.spec.source_tree import (
    ListNode,
    MappingNode,
    ScalarNode,
    SourceLocation,
    SourceNode,
    tree_of,
    with_node,
)
from pipeline.spec.suggestions import close_names, hint, joined_choices
from pipeline.spec.validation import check
from pipeline.spec.yaml_reader import read_file

# --- Scene library: files of scenes and figures by their names, beside the author's and shipped

SUFFIX = ".yaml"
PATH_SUFFIXES = (SUFFIX, ".yml")
"""Suffixes that tell paths from names."""

SCENES = "scenes"
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
            if name not in entries.entries and re.fullmatch(NAME_PATTERN, name):
                file = self._file_of(name, block)
                if file is None:
                    self._report(path, name, place, entries, block)
                else:
                    names_by_file[file.resolve()] = name
                found = tree_of(block.stand_in) if file is None else self._entry(file, block)
                entries = entries.with_entry(name, found.place, found)
        # Files come after all names, none of which they may take.
        for path, text, place in references:
            if not is_path(text):
                continue
            file = self._file_at(path, text, place, block)
            whole = Path(text) if file is None else file.resolve()
            name = names_by_file.get(whole) or _unused_name(Path(text).stem, entries, block)
            if whole not in names_by_file:
                names_by_file[whole] = name
                found = tree_of(block.stand_in) if file is None else self._entry(file, block)
                entries = entries.with_entry(name, found.place, found)
            changed = with_node(scene, path, ScalarNode(place, name))
            assert isinstance(changed, MappingNode)
            scene = changed
        if not entries.entries:
            return scene
        return scene.with_entry(block.block, entries.place, entries)

    def _file_of(self, name: str, block: LibraryBlock) -> Path | None:
        """Return the file of a name, None where there is none."""
        folders = [library() / block.block]
        if self.beside is not None:
            folders = [self.beside, self.beside / block.block, *folders]
        for path in (folder / (name + SUFFIX) for folder in folders):
            if not path.is_file() or str(path) == self.scene_file:
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
        file = existing_file(self.beside or Path(), text)
        if file is None:
            message = missing_file_message(self.beside or Path(), text)
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
            own |= {*files_beside(self.beside, block)}
            files = f"{name}{SUFFIX} and {block.block}/{name}{SUFFIX}"
            searched = f"this file, {files} beside it, the library"
        shipped = names_in(library() / block.block)
        close = hint(name, shipped, block.block, own)
        message = f"no {block.key} is called '{name}', {close} (searched: {searched})"
        self.problems.append(place.problem(path, message))


def is_path(text: str) -> bool:
    """Return whether a reference is the path of a file, not a name."""
    return text.endswith(PATH_SUFFIXES) or "/" in text or "\\" in text


def existing_file(folder: Path, text: str) -> Path | None:
    """Return the file that a path leads to from a folder, None where there is none.

    The suffix of scene files may be left out.
    """
    try:
        files = (folder / text, folder / (text + SUFFIX))
        return next((file for file in files if file.is_file()), None)
    except (OSError, ValueError):
        return None


def missing_file_message(folder: Path, text: str) -> str:
    """Return a message about a path that leads to no file: the folder looked in and near names."""
    try:
        whole = (folder / text).parent.resolve() / Path(text).name
        if (folder / text).is_dir():
            return f"'{text}' is a folder, not a file"
        if not whole.parent.is_dir():
            return f"'{text}' is no file: there is no folder {whole.parent}"
        files = {p.stem: p.name for p in whole.parent.iterdir() if p.suffix in PATH_SUFFIXES}
    except (OSError, ValueError) as error:
        return f"'{text}' cannot be the name of a file: {error}"
    close = [files[stem] for stem in close_names(whole.stem, files)]
    held = f"which holds {', '.join(sorted(files.values())) or 'no YAML files'}"
    near = f"did you mean {joined_choices(close)}?" if close else held
    return f"'{text}' is no file in {whole.parent}, {near}"


def _unused_name(stem: str, entries: MappingNode, block: LibraryBlock) -> str:
    """Return a name for the entry of a file: its stem, numbered where that is taken."""
    name = first = stem if re.fullmatch(NAME_PATTERN, stem) else block.key
    number = 1
    while name in entries.entries:
        number += 1
        name = f"{first}_{number}"
    return name


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


def files_beside(folder: Path, block: LibraryBlock) -> dict[str, Path]:
    """Return the files of figures or dances that a scene in a folder finds beside it, by name."""
    files = {
        name: folder / block.block / (name + SUFFIX) for name in names_in(folder / block.block)
    }
    for name in names_in(folder):
        path = folder / (name + SUFFIX)
        tree, _ = read_file(path)
        if tree is not None and block.key in tree.entries:
            files[name] = path
    return dict(sorted(files.items()))


def scenes_in(folder: Path) -> dict[str, Path]:
    """Return the files of scenes in a folder by name."""
    paths = {name: folder / (name + SUFFIX) for name in names_in(folder)}
    trees = {name: read_file(path)[0] for name, path in paths.items()}
    return {name: paths[name] for name, tree in trees.items() if tree and "cast" in tree.entries}


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
    raise UsageError(_not_found(name))


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
        if is_path(name):
            raise UsageError(missing_file_message(Path(), name)) from None
    own = {*files_beside(Path(), FIGURE_BLOCK), *scenes_in(Path()), *shipped_scenes()}
    shipped = names_in(library() / FIGURES)
    raise UsageError(f"no figure or scene is called {name!r}, {hint(name, shipped, FIGURES, own)}")


def _not_found(name: str) -> str:
    if is_path(name):
        return missing_file_message(Path(), name)
    close = hint(name, shipped_scenes(), SCENES, scenes_in(Path()))
    return f"no scene is called '{name}', neither in this folder nor among the shipped; {close}"
