"""Atomic files: a file or folder holds its old content or its new one, never a part.

That holds after a loss of power too: content is on the disk before it gets its name, and the name
before the call returns.

The lowest module of the house: everything that writes files may import it, `render` and `audio`
included, and it imports nothing of the project.
"""

from __future__ import annotations

import ctypes
import errno
import hashlib
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PARTIAL = ".partial"
"""Part of the name of files and folders that are not complete."""

NAME_LENGTH = 64
"""Characters of a file's name that its temporary file keeps: long names stay below the limit."""

SEAL_BYTES = 16
"""Length of the digest that a sealed file begins with."""

PRIVATE_MODE = 0o600
"""Mode of files for their owner alone."""

NOT_SUPPORTED = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)
"""Errors of file systems that cannot do what is asked, such as some that networks share."""

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2
"""Constants of Linux: paths count from the current folder; both paths get the other's file."""


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
        _sync_file(temporary)
        os.replace(temporary, path)
        _sync_folder(path.parent)
    except OSError as error:
        # Failed writes name no file, and nobody knows the temporary one. A new error, because
        # those of PyAV let nobody set the name.
        if error.filename in (None, str(temporary)):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        raise
    finally:
        with suppress(OSError):
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
    with replaced_when_complete(path) as temporary:
        temporary.write_bytes(data)
    return True


def write_sealed(path: Path, data: bytes) -> None:
    """Writes a file of a cache, with a digest of its name and data before the data.

    Raises:
        OSError: if the file cannot be written; an earlier one is untouched.
    """
    write_if_changed(path, _seal(path, data) + data)


def read_sealed(path: Path) -> bytes | None:
    """Returns the data of a file of a cache; None if it is missing, damaged or another file."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    seal, data = content[:SEAL_BYTES], content[SEAL_BYTES:]
    return data if seal == _seal(path, data) else None


def _seal(path: Path, data: bytes) -> bytes:
    named = os.fsencode(path.name) + b"\0" + data
    return hashlib.blake2b(named, digest_size=SEAL_BYTES).digest()


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


def make_folder(path: Path) -> None:
    """Makes a folder and those above it, unless they exist.

    Raises:
        OSError: if it cannot be made.
    """
    missing = [folder for folder in (path, *path.parents) if not folder.exists()]
    path.mkdir(parents=True, exist_ok=True)
    for folder in missing:
        _sync_folder(folder.parent)


def replace_folder(new: Path, place: Path) -> None:
    """Moves the folder `new` to `place`, replacing what is there.

    Where the system cannot exchange two folders in one step, a run that stops between two renames
    leaves none; the next run makes it again.

    Raises:
        OSError: if it cannot be moved; what is there is untouched.
    """
    for folder, _, files in os.walk(new):
        for name in files:
            _sync_file(Path(folder, name))
        _sync_folder(Path(folder))
    if not os.path.lexists(place):
        os.replace(new, place)
    elif not exchange(new, place):
        _replace_in_two_steps(new, place)
    _sync_folder(place.parent)
    remove(new)


def exchange(one: Path, two: Path) -> bool:
    """Exchanges two folders in one step; returns False where the system cannot.

    Raises:
        OSError: if they cannot be moved.
    """
    if sys.platform != "linux":
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    if not hasattr(libc, "renameat2"):
        return False
    paths = os.fsencode(one), os.fsencode(two)
    if libc.renameat2(_AT_FDCWD, paths[0], _AT_FDCWD, paths[1], _RENAME_EXCHANGE) == 0:
        return True
    code = ctypes.get_errno()
    if code in NOT_SUPPORTED:
        return False
    raise OSError(code, os.strerror(code), str(two))


def remove(path: Path) -> None:
    """Removes a file, a link or a folder, if there is one."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def _replace_in_two_steps(new: Path, place: Path) -> None:
    old = place.with_name(f".{place.name}.old{PARTIAL}")
    remove(old)
    os.replace(place, old)
    try:
        os.replace(new, place)
    except OSError:
        os.replace(old, place)
        raise
    remove(old)


def _sync_file(path: Path) -> None:
    """Waits until the content of a file is on the disk."""
    # Windows syncs only files that are open for writing.
    with path.open("r+b") as file:
        os.fsync(file.fileno())


def _sync_folder(path: Path) -> None:
    """Waits until the names in a folder are on the disk, where the system can tell."""
    if os.name == "nt":
        return
    folder = os.open(path, os.O_RDONLY)
    try:
        os.fsync(folder)
    except OSError as error:
        if error.errno not in NOT_SUPPORTED:
            raise
    finally:
        os.close(folder)
