"""Film file: the key of a finished film, and whether the file is whole."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import BinaryIO

import av

_EBML, _SEGMENT = 0x1A45DFA3, 0x18538067
"""Identifiers of the two elements of a WebM file."""


def film_key(path: Path) -> str | None:
    """Return the key that a film was written with; None if it has none or is torn."""
    try:
        is_complete = _is_complete_webm if path.suffix == ".webm" else _is_complete_quicktime
        if not is_complete(path):
            return None
        with av.open(str(path)) as container:
            # Matroska writes names of tags in capitals.
            return container.metadata.get("comment", container.metadata.get("COMMENT"))
    except (OSError, ValueError, av.FFmpegError):
        return None


def _is_complete_quicktime(path: Path) -> bool:
    """Return whether the boxes of an MP4 or MOV file add up to its length.

    Its index stands at its start, so that FFmpeg opens a torn film as well.
    """
    length, at = path.stat().st_size, 0
    with path.open("rb") as file:
        while at + 8 <= length:
            file.seek(at)
            (size,) = struct.unpack(">I", file.read(4))
            if size == 1:  # a 64-bit size follows the name
                (size,) = struct.unpack(">4xQ", file.read(12))
            if size < 8:
                return False
            at += size
    return at == length


def _is_complete_webm(path: Path) -> bool:
    """Return whether the header and the segment of a WebM file add up to its length."""
    with path.open("rb") as file:
        for expected in (_EBML, _SEGMENT):
            identifier = int.from_bytes(file.read(4), "big")
            size = _element_size(file)
            if identifier != expected or size is None:
                return False
            end = file.seek(size, 1)
    return end == path.stat().st_size


def _element_size(file: BinaryIO) -> int | None:
    """Read the size of an element: as many bytes as the first has leading zeros, and one.

    Returns:
        The size, None if it is not known or the file ends.
    """
    first = file.read(1)
    if not first or not first[0]:
        return None
    more = 8 - first[0].bit_length()
    rest = file.read(more)
    bits = 7 * (more + 1)
    size = int.from_bytes(first + rest, "big") & (1 << bits) - 1
    return None if len(rest) < more or size == (1 << bits) - 1 else size
