"""Pictures on disk: PNG and EXR files that carry the key they were made under.

A file is written beside its place and then renamed, so that a process that is
killed at any moment leaves the old picture or the new one, never a torn one.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from render.errors import FrameFileError

KEY = "pronk-key"
"""Name of the text chunk or attribute that holds the key."""

_PNG = b"\x89PNG\r\n\x1a\n"
_EXR = struct.pack("<II", 20000630, 2)
_LEVEL = 1
"""Of zlib: rendered frames are 5% larger than at level 6, in a quarter of the time."""


def write_png(path: Path, srgb8: NDArray[np.uint8], key: str) -> None:
    """Write an 8-bit sRGB picture (H, W, 3) as PNG, whole or not at all.

    Raises:
        FrameFileError: it could not be written.
    """
    height, width = srgb8.shape[:2]
    # Every row is told from the one above (filter 2), which packs well and costs one pass.
    rows = np.empty((height, 1 + width * 3), np.uint8)
    rows[:, 0] = 2
    flat = np.ascontiguousarray(srgb8).reshape(height, -1)
    rows[0, 1:] = flat[0]
    np.subtract(flat[1:], flat[:-1], out=rows[1:, 1:])
    with beside(path) as file:
        file.write(_PNG)
        _chunk(file, b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
        _chunk(file, b"sRGB", b"\0")
        _chunk(file, b"tEXt", KEY.encode("latin-1") + b"\0" + key.encode("latin-1", "replace"))
        _chunk(file, b"IDAT", zlib.compress(rows.data, _LEVEL))
        _chunk(file, b"IEND", b"")


def read_png(path: Path) -> NDArray[np.uint8]:
    """Return a PNG picture as (H, W, 3) uint8.

    Raises:
        FrameFileError: it is missing or torn.
    """
    from PIL import Image

    try:
        with Image.open(path) as image:
            return np.array(image.convert("RGB"))
    except (OSError, SyntaxError, ValueError) as error:
        raise FrameFileError(f"{path} is no readable picture: {error}; render it again") from error


def write_exr(path: Path, light: NDArray[np.float32], key: str) -> None:
    """Write linear light (H, W, 3) as EXR of 16-bit floats, whole or not at all.

    Raises:
        FrameFileError: it could not be written.
    """
    height, width = light.shape[:2]
    half = np.clip(light, -65504, 65504).astype("<f2")
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(c + b"\0" + struct.pack("<iB3xii", 1, 0, 1, 1) for c in (b"B", b"G", b"R"))
    header = b"".join(
        name.encode() + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value
        for name, kind, value in (
            ("channels", b"chlist", channels + b"\0"),
            ("compression", b"compression", b"\x02"),  # ZIPS: every row by itself
            ("dataWindow", b"box2i", box),
            ("displayWindow", b"box2i", box),
            ("lineOrder", b"lineOrder", b"\0"),
            ("pixelAspectRatio", b"float", struct.pack("<f", 1)),
            ("screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
            ("screenWindowWidth", b"float", struct.pack("<f", 1)),
            (KEY, b"string", key.encode()),
        )
    )
    blocks = [_exr_row(y, half[y]) for y in range(height)]
    first = len(_EXR) + len(header) + 1 + 8 * height
    offsets = first + np.cumsum([0, *(len(b) for b in blocks[:-1])], dtype="<u8")
    with beside(path) as file:
        file.write(_EXR + header + b"\0" + offsets.tobytes())
        file.writelines(blocks)


def read_key(path: Path) -> str | None:
    """Return the key of a PNG or EXR picture; None if it has none, is torn or is missing."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    try:
        if data[:8] == _PNG:
            return _png_key(data)
        return _exr_key(data) if data[:8] == _EXR else None
    except (struct.error, ValueError, IndexError):
        return None


@contextmanager
def beside(path: Path) -> Iterator[BinaryIO]:
    """Open a file beside `path` that takes its place when the block ends well.

    Raises:
        FrameFileError: it could not be written.
    """
    # The suffix stays, because encoders choose the container by it.
    temporary = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        with open(temporary, "wb") as file:
            yield file
        os.replace(temporary, path)
    except OSError as error:
        raise FrameFileError(f"{path} could not be written: {error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def _chunk(file: BinaryIO, name: bytes, data: bytes) -> None:
    crc = zlib.crc32(data, zlib.crc32(name))
    file.write(struct.pack(">I", len(data)) + name + data + struct.pack(">I", crc))


def _png_key(data: bytes) -> str | None:
    at, key, whole = 8, None, False
    while at + 12 <= len(data):
        (size,) = struct.unpack_from(">I", data, at)
        name, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        (crc,) = struct.unpack_from(">I", data, at + 8 + size)
        if crc != zlib.crc32(body, zlib.crc32(name)):
            return None
        if name == b"tEXt" and body.startswith(KEY.encode() + b"\0"):
            key = body.split(b"\0", 1)[1].decode("latin-1")
        whole = whole or name == b"IEND"
        at += 12 + size
    return key if whole else None


def _exr_row(y: int, row: NDArray[np.float16]) -> bytes:
    """Return one row of pixels as a ZIPS block: planes, bytes split, differences, deflate."""
    raw = np.ascontiguousarray(row[:, ::-1].T).view(np.uint8).ravel()
    split = np.concatenate([raw[0::2], raw[1::2]])
    told = split.copy()
    told[1:] = split[1:] - split[:-1] + np.uint8(128)
    packed = zlib.compress(told.data, _LEVEL)
    body = packed if len(packed) < raw.size else raw.tobytes()
    return struct.pack("<ii", y, len(body)) + body


def _exr_key(data: bytes) -> str | None:
    at, key, height = 8, None, 0
    while data[at] != 0:
        name, kind, _ = data[at : at + 512].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        (size,) = struct.unpack_from("<i", data, at)
        value = data[at + 4 : at + 4 + size]
        if name == KEY.encode():
            key = value.decode()
        if name == b"dataWindow":
            _, top, _, bottom = struct.unpack("<4i", value)
            height = bottom - top + 1
        at += 4 + size
    (last,) = struct.unpack_from("<Q", data, at + 1 + 8 * (height - 1))
    (size,) = struct.unpack_from("<i", data, last + 4)
    return key if last + 8 + size <= len(data) else None
