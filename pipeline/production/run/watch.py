"""Watch: a picture of a scene, made again when its file or a file that it names changes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import watchfiles

from pipeline.errors import PronkError, SceneError
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.spec import Scene, library
from pipeline.spec.scene_library import DANCES, FIGURES, SUFFIX

FOLDER = "watch"
"""Folder beside those of the scenes, so that no film is overwritten."""

QUIET_MS = 120
"""Time without changes after which a file counts as saved [ms]; editors write in steps."""

POLL_MS = 500
"""Interval of polling for changes from before the system watched [ms]."""

Stamps = Mapping[Path, tuple[int, int] | None]
"""Time [ns] and size [bytes] of each file; None for a missing one."""


def watch(
    file: Path,
    order_of: Callable[[], Order],
    make: Callable[[Order], Path],
    reporter: Reporter,
    report_error: Callable[[PronkError], None],
    changes: Callable[[Stamps], Iterator[object]] | None = None,
) -> None:
    """Make a picture now and after every change, as far as it is due.

    Args:
        file: of the scene.
        order_of: reads the scene.
        make: makes the picture and returns its file.
        reporter: of every picture.
        report_error: of every error; the picture is made once the scene is right.
        changes: yields an item when files are no longer as they were; ends only if there is
            nothing to wait for.
    """
    named: set[Path] = set()
    while True:
        # Changes while a picture is made are not in it.
        seen = {**stamps(named), **stamps({file.absolute()})}
        try:
            order = order_of()
            named = files_of(order.scene)
            seen |= stamps(named - seen.keys())
            reporter.result(f"{make(order)}")
        except PronkError as error:
            if isinstance(error, SceneError):
                named |= {Path(p.file).absolute() for p in error.problems if p.file}
            report_error(error)
        reporter.note(f"watching {file}; Ctrl-C ends it")
        # Each time anew, because the scene can name other files now.
        seen |= stamps(named - seen.keys())
        if next((changes or changes_of)(seen), None) is None:
            return


def files_of(scene: Scene) -> set[Path]:
    """Return the files of a scene, but those of the library.

    They are its own, those of its figures and dances, and the meshes, pictures and sound fonts
    that it names.
    """
    named = {path for text in _texts(scene.model_dump()) if (path := _file(text)) is not None}
    read = {Path(name).absolute() for name in scene.source_map.files}
    return named | {path for path in read if not path.resolve().is_relative_to(library())}


def _texts(value: Any) -> Iterator[str]:
    """Yield all texts within a value."""
    if isinstance(value, str | Path):
        yield str(value)
    elif isinstance(value, dict):
        for inner in value.values():
            yield from _texts(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _texts(inner)


def _file(text: str) -> Path | None:
    """Return the file that a text names, if any; scenes hold absolute paths."""
    try:
        path = Path(text)
        return path if path.is_absolute() and path.is_file() else None
    except (OSError, ValueError):
        return None


def stamps(files: Iterable[Path]) -> dict[Path, tuple[int, int] | None]:
    """Return the stamps of files."""
    return {path: _stamp(path) for path in files}


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def changes_of(seen: Stamps) -> Iterator[object]:
    """Yield an item when files differ from their stamps or a figure or dance beside them changes.

    Folders are watched because editors replace files.
    """
    known = {path.resolve() for path in seen}
    folders = {path.parent for path in known}
    shelves = {folder / name for folder in folders for name in (FIGURES, DANCES)}
    places = {*folders, *(shelf for shelf in shelves if shelf.is_dir())}

    def is_relevant(change: watchfiles.Change, name: str) -> bool:
        path = Path(name)
        scene_or_figure = path.suffix == SUFFIX and path.parent in places
        return path in {*known, *shelves} or path.resolve() in known or scene_or_figure

    batches = watchfiles.watch(
        *places,
        watch_filter=is_relevant,
        recursive=False,
        step=QUIET_MS,
        rust_timeout=POLL_MS,
        yield_on_timeout=True,
    )
    for changes in batches:
        if changes or stamps(seen) != seen:
            yield changes
