"""Watching: a picture of a scene that follows its file, and all files that it names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import watchfiles

from pipeline.errors import PronkError, SceneError
from pipeline.production.order import Order
from pipeline.production.reporting import Reporter
from pipeline.spec import Scene

PLACE = "watch"
"""Folder beside the scenes' own, so that nothing of a film is overwritten."""

SETTLE_MS = 120
"""Editors write a file in several steps; so long none may follow [ms]."""


def watch(
    file: Path,
    order_of: Callable[[], Order],
    make: Callable[[Order], Path],
    reporter: Reporter,
    say: Callable[[PronkError], None],
    changes: Callable[[set[Path]], Iterator[object]] | None = None,
) -> None:
    """Make a picture now, and again whenever something that it is made of has changed.

    A scene that is wrong is told so, and made once it is right. Only what has to be is done
    again: a changed light simulates nothing.

    Args:
        file: of the scene.
        order_of: reads the scene.
        make: makes the picture and returns its file.
        reporter: told of every picture.
        say: told of every mistake.
        changes: gives an item a change of some files; ends only if there is nothing to wait for.
    """
    named: set[Path] = set()
    while True:
        try:
            order = order_of()
            named = files_of(order.scene)
            reporter.result(f"{make(order)}")
        except PronkError as error:
            if isinstance(error, SceneError):
                named |= {Path(p.file).absolute() for p in error.problems if p.file}
            say(error)
        reporter.note(f"watching {file}; Ctrl-C ends it")
        # A new watch each time, for the scene may name other files now.
        if next((changes or changes_of)({file.absolute(), *named}), None) is None:
            return


def files_of(scene: Scene) -> set[Path]:
    """Return the files that a scene names, its own left out."""
    return {path for word in _words(scene.model_dump()) if (path := _file(word)) is not None}


def _words(value: Any) -> Iterator[str]:
    """Give all texts within a value."""
    if isinstance(value, str | Path):
        yield str(value)
    elif isinstance(value, dict):
        for inner in value.values():
            yield from _words(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _words(inner)


def _file(word: str) -> Path | None:
    """Return the file that a word names, if it does; files are kept with their whole path."""
    try:
        path = Path(word)
        return path if path.is_absolute() and path.is_file() else None
    except (OSError, ValueError):
        return None


def changes_of(files: Iterable[Path]) -> Iterator[object]:
    """Give an item whenever one of some files has changed, or a figure beside one.

    Their folders are watched: editors put a new file in the place of the old one.
    """
    known = {path.resolve() for path in files}
    folders = {path.parent for path in known}
    figures = {folder / "figures" for folder in folders}
    places = {*folders, *(folder for folder in figures if folder.is_dir())}

    def matters(change: watchfiles.Change, name: str) -> bool:
        path = Path(name)
        scene_or_figure = path.suffix == ".yaml" and path.parent in places
        return path in known or path.resolve() in known or scene_or_figure

    yield from watchfiles.watch(
        *places, watch_filter=matters, recursive=False, debounce=1600, step=SETTLE_MS
    )
