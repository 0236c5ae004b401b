"""Verdict store: contents of foreign files that have been read whole without a fault.

A verdict is an empty file in the user's cache, named by a digest of the content, the reader's
source and the version of its library. That a file is wrong is not stored: the cause may have been
a busy machine, and its author wants to hear it again.
"""

from __future__ import annotations

import hashlib
import importlib.util
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from pipeline.foreign_files.reader_process import Reading, read_confined
from pipeline.foreign_files.safe_file import FileKind, content_digest
from pipeline.user_cache import user_cache_folder

FOLDER = "verdicts"


def confirm(reading: Reading, kind: FileKind, libraries: tuple[str, ...]) -> None:
    """Read a file to see that it is right, unless its content has been found right before.

    Args:
        reading: that succeeds only on a right file.
        kind: of the file.
        libraries: distributions that read it.

    Raises:
        ForeignFileError, ReaderMissing, ReaderProcessError: see `ReaderProcess.read`.
    """
    state = content_digest(reading.file, kind), reading.reader, *_reader_state(reading, libraries)
    name = hashlib.blake2b(repr(state).encode(), digest_size=16).hexdigest()
    verdict = user_cache_folder() / FOLDER / name
    if verdict.exists():
        return
    read_confined(reading)
    # The store only saves time.
    with suppress(OSError):
        verdict.parent.mkdir(parents=True, exist_ok=True)
        verdict.touch()


def _reader_state(reading: Reading, libraries: tuple[str, ...]) -> tuple[str, ...]:
    module, _, _ = reading.reader.partition(":")
    return _source_digest(module), *map(_version, libraries)


@cache
def _source_digest(module: str) -> str:
    found = importlib.util.find_spec(module)
    if found is None or found.origin is None:
        return ""
    return hashlib.blake2b(Path(found.origin).read_bytes(), digest_size=16).hexdigest()


@cache
def _version(library: str) -> str:
    try:
        return f"{library} {version(library)}"
    except PackageNotFoundError:
        return ""
