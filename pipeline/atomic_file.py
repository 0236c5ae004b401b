"""Atomic files: a file or folder holds its old content or its new one, never a part.

The lowest module of the house: everything that writes files may import it, `render` and `audio`
included, and it imports nothing of the project.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PARTIAL = ".partial"
"""Part of the name of files and folders that are not complete."""

NAME_LENGTH = 64
"""Characters of a file's name that its temporary file keeps: long names stay below the limit."""

PRIVATE_MODE = 0o600
"""Mode of files for their owner alone."""


@contextmanager
def replaced_when_complete(path: Path) -> Iterator[Path]:
    """Yields a temporary path beside `path`, which replaces it when the block succeeds.

    The suffix stays, because encoders choose the container by it.

    Raises:
        OSError: if the file cannot be written; an earlier one is untouched.
    """
    name = f".{path.stem[:NAME_LENGTH]}.{os.getpid()}{PARTIAL}{path.suffix}"
    temporary = path.with_name(name)
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_if_changed(path: Path, data: bytes) -> bool:
    """Writes a file atomically unless it already holds these bytes.

    Returns:
        Whether the file was written; an equal file keeps its time stamp.

    Raises:
        OSError: if the file cannot be written; an earlier one is untouched.
    """
    if path.is_file() and path.stat().st_size == len(data) and path.read_bytes() == data:
        return False
    with replaced_when_complete(path) as temporary, temporary.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    return True


def write_private(path: Path, data: bytes) -> None:
    """Writes a file atomically that nobody but its owner can read, at no moment.

    Raises:
        OSError: if the file cannot be written, or its file system knows no owners; an earlier one
            is untouched.
    """
    with replaced_when_complete(path) as temporary:
        # A killed process of the same number may have left one, with any mode.
        temporary.unlink(missing_ok=True)
        file = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, PRIVATE_MODE)
        with open(file, "wb") as opened:
            if os.name == "posix" and os.fstat(file).st_mode & 0o077:
                raise OSError(errno.EPERM, "other users could read it there")
            opened.write(data)


def replace_folder(new: Path, place: Path) -> None:
    """Moves the folder `new` to `place`, replacing a folder there.

    A run that stops between the two renames leaves no folder; the next run makes it again.
    """
    old = place.with_name(f".{place.name}.old{PARTIAL}")
    with suppress(FileNotFoundError):
        os.replace(place, old)
    os.replace(new, place)
    remove(old)


def remove(path: Path) -> None:
    """Removes a file, a link or a folder, if there is one."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
