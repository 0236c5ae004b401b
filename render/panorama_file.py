"""Panorama files: checks of EXR and HDR files without Mitsuba, for when a scene is read."""

from __future__ import annotations

import hashlib
import re
from functools import lru_cache
from pathlib import Path

import OpenEXR

SUFFIXES = (".exr", ".hdr")
_MAX_HEADER_BYTES = 65536


def panorama_fault(path: Path) -> str | None:
    """Return the error of a panorama file, None if it is usable."""
    if path.suffix.lower() not in SUFFIXES:
        return f"'{path.name}' is no {' or '.join(SUFFIXES)} file"
    try:
        width, height = _size(path)
    except (OSError, RuntimeError, ValueError, KeyError, TypeError) as error:
        return f"'{path.name}' cannot be read as an image: {error}"
    if width != 2 * height:
        return f"'{path.name}' is {width} by {height} pixels; a panorama is twice as wide as high"
    return None


def file_digest(path: Path) -> str:
    """Return a digest of the content of a file, empty if it cannot be read."""
    try:
        found = path.stat()
        return _digest(path, found.st_mtime_ns, found.st_size)
    except OSError:
        return ""


@lru_cache(maxsize=16)
def _digest(path: Path, changed: int, size: int) -> str:
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()


def _size(path: Path) -> tuple[int, int]:
    if path.suffix.lower() == ".exr":
        path.stat()
        with OpenEXR.File(str(path), header_only=True) as file:
            low, high = file.header()["dataWindow"]
        return int(high[0] - low[0]) + 1, int(high[1] - low[1]) + 1
    with path.open("rb") as stream:
        head = stream.read(_MAX_HEADER_BYTES)
    if not head.startswith(b"#?"):
        raise ValueError("it does not start as an HDR file does")
    found = re.search(rb"\n\n[-+]Y (\d+) [-+]X (\d+)\n", head)
    if found is None:
        raise ValueError("its header gives no size")
    return int(found[2]), int(found[1])
