"""Watching: a picture of a scene that follows its file, and all files that it names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import watchfiles

from pipeline.errors import PronkError, SceneError
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.spec import Scene

PLACE = "watch"
"""Folder beside the scenes' own, so that nothing of a film is overwritten."""

SETTLE_MS = 120
"""Editors write a file in several steps; so long none may follow [ms]."""

LOOK_MS = 500
"""How often it is asked whether something changed before the system was watching [ms]."""

Stamps = Mapping[Path, tuple[int, int] | None]
"""When a file was written [ns] and how long it is [bytes]; None for one that is not there."""


def watch(
    file: Path,
    order_of: Callable[[], Order],
    make: Callable[[Order], Path],
    reporter: Reporter,
    say: Callable[[PronkError], None],
    changes: Callable[[Stamps], Iterator[object]] | None = None,
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
        changes: gives an item when files are no longer as they were; ends only if there is
            nothing to wait for.
    """
    named: set[Path] = set()
    while True:
        # What is written while a picture is made is not in it.
        seen = {**stamps(named), **stamps({file.absolute()})}
        try:
            order = order_of()
            named = files_of(order.scene)
            seen |= stamps(named - seen.keys())
            reporter.result(f"{make(order)}")
        except PronkError as error:
            if isinstance(error, SceneError):
                named |= {Path(p.file).absolute() for p in error.problems if p.file}
            say(error)
        reporter.note(f"watching {file}; Ctrl-C ends it")
        # A new watch each time, for the scene may name other files now.
        seen |= stamps(named - seen.keys())
        if next((changes or changes_of)(seen), None) is None:
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


def stamps(files: Iterable[Path]) -> dict[Path, tuple[int, int] | None]:
    """Return how files are now."""
    return {path: _stamp(path) for path in files}


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def changes_of(seen: Stamps) -> Iterator[object]:
    """Give an item whenever files are no longer as they were seen, or a figure beside one changes.

    Their folders are watched: editors put a new file in the place of the old one.
    """
    known = {path.resolve() for path in seen}
    folders = {path.parent for path in known}
    figures = {folder / "figures" for folder in folders}
    places = {*folders, *(folder for folder in figures if folder.is_dir())}

    def matters(change: watchfiles.Change, name: str) -> bool:
        path = Path(name)
        scene_or_figure = path.suffix == ".yaml" and path.parent in places
        return path in known or path.resolve() in known or scene_or_figure

    told = watchfiles.watch(
        *places,
        watch_filter=matters,
        recursive=False,
        step=SETTLE_MS,
        rust_timeout=LOOK_MS,
        yield_on_timeout=True,
    )
    for changes in told:
        if changes or stamps(seen) != seen:
            yield changes
