"""Completion of names in the shell: names of the library, and files beside them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from textwrap import shorten

MAX_TEXT_LENGTH = 60
"""Of the description beside a name [characters]."""

Completions = list[tuple[str, str]]
"""Names and their short descriptions."""


def completion(*kinds: str, with_files: bool = False) -> Callable[[str], Completions]:
    """Return the completion of an argument.

    Args:
        kinds: of names, as `pronk list` calls them.
        with_files: whether YAML files and folders are offered too.
    """

    def complete(incomplete: str) -> Completions:
        from pipeline.spec.name_catalogue import names_of

        entries = (entry for kind in kinds for entry in names_of(kind, Path()))
        # The shells take a second line for a name of its own.
        names = [(entry.name, shorten(entry.text, MAX_TEXT_LENGTH)) for entry in entries]
        files = [(name, "") for name in _files(incomplete)] if with_files else []
        return [pair for pair in names if pair[0].startswith(incomplete)] + files

    return complete


def complete_kind(incomplete: str) -> Completions:
    """Return the kinds of names that `pronk list` shows."""
    from pipeline.spec.name_catalogue import NAME_KINDS

    return [(name, kind.text) for name, kind in NAME_KINDS.items() if name.startswith(incomplete)]


def _files(incomplete: str) -> list[str]:
    """Return the paths of YAML files and folders that begin so; none that are hidden."""
    before, slash, start = incomplete.rpartition("/")
    try:
        paths = sorted(Path(before + slash).iterdir())
        found = [
            path.name + ("/" if path.is_dir() else "")
            for path in paths
            if path.name.startswith(start) and not path.name.startswith(".")
            if path.is_dir() or path.suffix in (".yaml", ".yml")
        ]
    except (OSError, ValueError):
        return []
    return [before + slash + name for name in found]
