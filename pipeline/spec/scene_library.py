"""Scene library: files of scenes and figures by name, beside the author's and shipped."""

from __future__ import annotations

from pathlib import Path

from pipeline.errors import UsageError
from pipeline.spec.suggestions import hint

SUFFIX = ".yaml"
FIGURES = "figures"
"""Folder of figure files beside a scene and in the library."""

DANCES = "dances"
"""Folder of dances beside a scene and in the library."""


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


def _not_found(name: str, beside: Path) -> str:
    if len(beside.parts) > 1:
        known = names_in(beside.parent)
        close = hint(beside.stem, known) if known else "the folder holds no scenes"
        return f"there is no file '{name}'; {close}"
    shipped = shipped_scenes()
    close = hint(beside.stem, [*names_in(Path()), *shipped])
    return f"no scene is called '{name}', neither in this folder nor among the shipped; {close}"


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
