"""Panorama files: EXR and HDR files as light, read in a child process; see `panorama_reader`."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipeline.foreign_files.reader_process import (
    ReaderMissing,
    ReaderProcessError,
    Reading,
    read_confined,
)
from pipeline.foreign_files.safe_file import PANORAMA, ForeignFileError, content_digest
from pipeline.foreign_files.verdict_store import confirm
from render.errors import ShotError
from render.panorama_reader import MAX_WIDTH

if TYPE_CHECKING:
    from render.lights.environment_map import Map

SUFFIXES = (".exr", ".hdr")

# A panorama of the largest size as floats of four channels and of three, and its file.
_MEMORY = 6 * 2**30
_TIME = 60.0
_MAX_CONTENT_BYTES = MAX_WIDTH * MAX_WIDTH * 3 * 8


def panorama_fault(path: Path) -> str | None:
    """Return the error of a panorama file, to continue its name; None if it is usable.

    Raises:
        ShotError: no file can be read.
    """
    if path.suffix.lower() not in SUFFIXES:
        return f"is no {' or '.join(SUFFIXES)} file"
    try:
        confirm(_reading("examine", path), PANORAMA, ("OpenEXR", "mitsuba"))
    except ForeignFileError as error:
        return str(error)
    except (ReaderMissing, ReaderProcessError) as error:
        raise ShotError(f"{path}: cannot be read: {error}") from error
    return None


def file_digest(path: Path) -> str:
    """Return a digest of the content of a file, empty if it cannot be read."""
    try:
        found = path.stat()
        return _digest(path, found.st_mtime_ns, found.st_size)
    except (OSError, ForeignFileError):
        return ""


@lru_cache(maxsize=16)
def _digest(path: Path, changed: int, size: int) -> str:
    return content_digest(path, PANORAMA)


def read_panorama(path: Path) -> Map:
    """Return the light of a panorama (H, W, 3), reduced to `MAX_WIDTH`.

    Raises:
        ShotError: the file cannot be read.
    """
    return _read(path, file_digest(path))


@lru_cache(maxsize=1)
def _read(path: Path, digest: str) -> Map:
    content = bytearray()
    try:
        facts = read_confined(_reading("read", path, _MAX_CONTENT_BYTES), content.extend)
    except ForeignFileError as error:
        raise ShotError(f"{path}: {error}") from error
    except (ReaderMissing, ReaderProcessError) as error:
        raise ShotError(f"{path}: cannot be read: {error}") from error
    image = np.frombuffer(bytes(content), np.float64)
    return image.reshape(facts["height"], facts["width"], 3)


def _reading(function: str, path: Path, max_bytes: int = 0) -> Reading:
    reader = f"render.panorama_reader:{function}"
    return Reading(reader, path, _MEMORY, _TIME, max_bytes=max_bytes)
