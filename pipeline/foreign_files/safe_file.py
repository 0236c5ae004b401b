"""Safe files: regular files of bounded size, whatever links and devices their names lead to."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

CHUNK_BYTES = 2**20

_SPECIAL_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


class ForeignFileError(Exception):
    """A foreign file cannot be used; the message continues its name, such as "is a folder"."""


@dataclass(frozen=True, slots=True)
class FileKind:
    """A kind of foreign file.

    Attributes:
        name: with its article, for messages.
        max_bytes: size of the largest file that is read.
        untrusted_bytes: the same of a file that an untrusted scene names; `max_bytes` by default.
    """

    name: str
    max_bytes: int
    untrusted_bytes: int | None = None

    def for_untrusted(self) -> FileKind:
        """Return the kind with the limit of untrusted scenes."""
        limit = self.max_bytes if self.untrusted_bytes is None else self.untrusted_bytes
        return FileKind(f"{self.name} with --untrusted", limit)


SOUNDFONT = FileKind("a SoundFont", 2 * 2**30, 256 * 2**20)
SONG = FileKind("a song", 16 * 2**20, 2**20)
PANORAMA = FileKind("a panorama", 2 * 2**30, 128 * 2**20)
HEIGHT_MAP = FileKind("a height map", 128 * 2**20, 32 * 2**20)
TERRAIN_MESH = FileKind("the mesh of a terrain", 2**30, 128 * 2**20)
BODY_MESH = FileKind("the mesh of a body", 256 * 2**20, 32 * 2**20)


@contextmanager
def opened_file(path: Path, kind: FileKind) -> Iterator[BinaryIO]:
    """Open a regular file of bounded size, through links.

    Raises:
        ForeignFileError: there is no such file, or it is not regular, too large or unreadable.
    """
    with _translated_errors(path):
        # Before it is opened, which some devices notice, and of what was opened.
        _require_regular(_found(path), kind)
        file = open(path, "rb", opener=_open_without_waiting)
    with file, _translated_errors(path):
        _require_regular(os.fstat(file.fileno()), kind)
        yield file


@contextmanager
def _translated_errors(path: Path) -> Iterator[None]:
    """Translate errors of the system into those of the file."""
    try:
        yield
    except FileNotFoundError:
        raise ForeignFileError(f"is no file in {path.parent}") from None
    except OSError as error:
        raise ForeignFileError(f"cannot be read: {error.strerror or error}") from None


def _found(path: Path) -> os.stat_result:
    try:
        return os.stat(path)
    except ValueError:
        raise ForeignFileError("cannot be the name of a file: it holds a zero byte") from None


def _require_regular(found: os.stat_result, kind: FileKind) -> None:
    for is_kind, name in _SPECIAL_KINDS:
        if is_kind(found.st_mode):
            raise ForeignFileError(f"is {name}, not a file")
    if not stat.S_ISREG(found.st_mode):
        raise ForeignFileError("is no regular file")
    if found.st_size > kind.max_bytes:
        raise _too_large(kind)


def _open_without_waiting(path: str, flags: int) -> int:
    """Open a file at once: a named pipe would wait for its writer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0))


def _too_large(kind: FileKind) -> ForeignFileError:
    limit = kind.max_bytes // 2**20
    size = f"{limit} MiB" if limit % 1024 else f"{limit // 1024} GiB"
    return ForeignFileError(f"is larger than {size}, the limit of {kind.name}")


def require_file(path: Path, kind: FileKind) -> None:
    """Refuse what is no regular file of bounded size.

    Raises:
        ForeignFileError: it is none.
    """
    with opened_file(path, kind):
        pass


def read_file(path: Path, kind: FileKind) -> bytes:
    """Return the content of a file.

    Raises:
        ForeignFileError: there is no such file, or it is not regular, too large or unreadable.
    """
    return b"".join(_chunks(path, kind))


def content_digest(path: Path, kind: FileKind) -> str:
    """Return a digest of the content of a file.

    Raises:
        ForeignFileError: there is no such file, or it is not regular, too large or unreadable.
    """
    state = hashlib.blake2b(digest_size=20)
    for chunk in _chunks(path, kind):
        state.update(chunk)
    return state.hexdigest()


def _chunks(path: Path, kind: FileKind) -> Iterator[bytes]:
    """Yield the content of a file, which may grow meanwhile, up to the limit of its kind."""
    with opened_file(path, kind) as file:
        left = kind.max_bytes
        while chunk := file.read(CHUNK_BYTES):
            left -= len(chunk)
            if left < 0:
                raise _too_large(kind)
            yield chunk
