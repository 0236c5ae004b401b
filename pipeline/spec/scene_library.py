"""Scene library: files of scenes and figures by name, beside the author's and shipped."""

from __future__ import annotations

import os
from pathlib import Path

from pipeline.errors import UsageError
from pipeline.foreign_files.confinement import Confinement
from pipeline.spec.suggestions import close_names, hint, joined_choices
from pipeline.spec.yaml_reader import read_file
from pipeline.terminal_text import escaped_line

SUFFIX = ".yaml"
PATH_SUFFIXES = (SUFFIX, ".yml")
"""Suffixes that tell paths from names."""

SCENES = "scenes"
FIGURE = "figure"
FIGURES = "figures"
"""Folder of figure files beside a scene and in the library."""

DANCES = "dances"
"""Folder of dances beside a scene and in the library."""


SEQUENCE = "sequence"
"""Key of a file that joins scenes."""

SEQUENCES = "sequences"
"""Folder of sequences in the library."""


def library() -> Path:
    """Return the folder of the shipped scenes; its folder `figures` holds the shipped figures."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "scenes"
    # A wheel carries the library inside the package, a checkout beside it.
    return installed if installed.is_dir() else package.parent / "scenes"


def shipped_scenes() -> list[str]:
    """Return the names of the shipped scenes."""
    return names_in(library())


def shipped_file(name: str) -> Path | None:
    """Return the file of a shipped scene or sequence, None where none is called so."""
    file = Path(name if name.endswith(SUFFIX) else name + SUFFIX)
    shelves = (library(), library() / SEQUENCES) if len(file.parts) == 1 else ()
    return next((shelf / file for shelf in shelves if is_file(shelf / file)), None)


def names_in(folder: Path) -> list[str]:
    """Return the names of the files in a folder that may hold a scene or a figure."""
    try:
        return sorted(path.stem for path in folder.glob("*" + SUFFIX) if path.is_file())
    except OSError:
        return []


def files_beside(
    folder: Path, block: str, key: str, confinement: Confinement | None = None
) -> dict[str, Path]:
    """Return the files of figures or dances that a scene in a folder finds beside it, by name.

    Args:
        folder: of the scene.
        block: `figures` or `dances`: the folder beside the scene.
        key: of the entry in a file, `figure` or `dance`.
        confinement: of an untrusted scene, without which no file is read.
    """
    files = {name: folder / block / (name + SUFFIX) for name in names_in(folder / block)}
    if confinement is not None:
        files = {name: path for name, path in files.items() if confinement.holds(path)}
    for name in names_in(folder):
        path = folder / (name + SUFFIX)
        if confinement is not None and not confinement.holds(path):
            continue
        tree, _ = read_file(path)
        if tree is not None and key in tree.entries:
            files[name] = path
    return dict(sorted(files.items()))


def scenes_in(folder: Path) -> dict[str, Path]:
    """Return the files of scenes in a folder by name."""
    paths = {name: folder / (name + SUFFIX) for name in names_in(folder)}
    trees = {name: read_file(path)[0] for name, path in paths.items()}
    return {name: paths[name] for name, tree in trees.items() if tree and "cast" in tree.entries}


def is_file(path: Path) -> bool:
    """Return whether there is such a file; no file has a name that the system does not allow."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_path(text: str) -> bool:
    """Return whether a reference is the path of a file, not a name."""
    return text.endswith(PATH_SUFFIXES) or "/" in text or "\\" in text


def existing_file(folder: Path, text: str, confinement: Confinement | None = None) -> Path | None:
    """Return the file that a path leads to from a folder, None where there is none.

    The suffix of scene files may be left out.

    Raises:
        ForeignFileError: the path leads out of the confinement.
    """
    files = [folder / text, folder / (text + SUFFIX)]
    if confinement is not None:
        files = [confinement.located(file) for file in files]
    return next((file for file in files if is_file(file)), None)


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


MAX_NAME_BYTES = 200
"""Length of a scene's name: those of its outputs are longer, and most systems take 255."""


def name_fault(name: str) -> str | None:
    """Return why a name cannot be that of a folder of outputs and of the files in it."""
    if name != escaped_line(name):
        return "holds characters that cannot be printed"
    if not name or name.startswith("."):
        return "begins with a dot" if name else "is empty"
    if name != name.strip() or name.endswith("."):
        return "ends with a dot" if name.endswith(".") else "begins or ends with a blank"
    if len(os.fsencode(name)) > MAX_NAME_BYTES:
        return f"is longer than {MAX_NAME_BYTES} bytes"
    return None


def find_scene(name: str) -> Path:
    """Return the file of a scene, given its path or its name.

    A name stands for a file in the current folder, else for a shipped scene.

    Raises:
        UsageError: there is no such scene, or its outputs cannot be named by it.
    """
    path = _scene_file(name)
    fault = name_fault(path.stem)
    if fault is not None:
        stem = escaped_line(path.stem)
        message = f"a scene's file names its outputs, and '{stem}' {fault}; rename the file"
        raise UsageError(f"'{escaped_line(name)}': {message}")
    return path


def _scene_file(name: str) -> Path:
    given = Path(name)
    beside = given if name.endswith(SUFFIX) else Path(name + SUFFIX)
    try:
        # A folder `bug` does not hide the scene `bug.yaml`.
        for path in (given, beside):
            if path.exists() and not path.is_dir():
                return path
        shipped = shipped_file(name)
        if shipped is not None:
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
    own = {*files_beside(Path(), FIGURES, FIGURE), *scenes_in(Path())}
    figures, scenes = names_in(library() / FIGURES), shipped_scenes()
    close = close_names(name, {*figures, *scenes, *own})
    if close and close[0] in scenes:
        near = hint(name, scenes, SCENES, {*figures, *own})
    else:
        near = hint(name, figures, FIGURES, {*own, *(scenes if close else ())})
    raise UsageError(f"no figure or scene is called {name!r}, {near}")


def _not_found(name: str) -> str:
    if is_path(name):
        return missing_file_message(Path(), name)
    close = hint(name, shipped_scenes(), SCENES, scenes_in(Path()))
    return f"no scene is called '{name}', neither in this folder nor among the shipped; {close}"
