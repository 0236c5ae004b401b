"""Image files: PNG and EXR with the key of their frame, written atomically.

A file also holds a digest of its pixels, key and levels, so that it counts only as it was written.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import OpenEXR
from numpy.typing import NDArray
from PIL import Image, PngImagePlugin

from pipeline.atomic_file import replaced_when_complete
from render.errors import FrameFileError
from render.picture_levels import PictureLevels

KEY = "pronk-key"
"""Name of the text chunk or attribute that holds the key."""

LEVELS = "pronk-levels"
"""Name of the text chunk or attribute that holds the levels of the picture."""

DIGEST = "pronk-digest"
"""Name of the text chunk or attribute that holds the digest of all else."""

_LEVEL = 1
"""Deflate level: on rendered frames a tenth larger than level 3, in half the time."""

_PNG_END = b"\0\0\0\0IEND\xaeB`\x82"

_UNREADABLE = (
    *(OSError, SyntaxError, ValueError, KeyError, RuntimeError),
    Image.DecompressionBombError,
)
"""Exceptions of the libraries for a file that is missing or damaged."""

Pixels = NDArray[np.uint8] | NDArray[np.float16]


@dataclass(frozen=True, eq=False)
class _Content:
    """What a file holds.

    Attributes:
        pixels: (H, W, 3).
        key: None if it has none.
        levels: as text, "" if it has none.
        digest: None if it has none.
    """

    pixels: Pixels
    key: str | None
    levels: str
    digest: str | None

    @property
    def is_intact(self) -> bool:
        """Whether the file is as it was written; True for one without a digest."""
        return self.digest is None or self.digest == _digest(
            self.pixels, self.key or "", self.levels
        )


def _digest(pixels: Pixels, key: str, levels: str) -> str:
    state = hashlib.blake2b(f"{key}|{levels}|{pixels.shape}".encode(), digest_size=16)
    state.update(np.ascontiguousarray(pixels).data)
    return state.hexdigest()


def _texts(pixels: Pixels, key: str, levels: PictureLevels | None) -> dict[str, str]:
    """Return the texts that stand beside pixels."""
    level_text = "" if levels is None else str(levels)
    texts = {KEY: key, DIGEST: _digest(pixels, key, level_text)}
    return texts if levels is None else {**texts, LEVELS: level_text}


def write_png(
    path: Path,
    srgb8: NDArray[np.uint8],
    key: str,
    level: int = _LEVEL,
    levels: PictureLevels | None = None,
) -> None:
    """Write an 8-bit sRGB image (H, W, 3) as PNG, completely or not at all.

    Args:
        path: of the file.
        srgb8: the image.
        key: stored in the file, for `read_key`.
        level: of deflate, 9 for the smallest file.
        levels: stored in the file, for `read_levels`.

    Raises:
        FrameFileError: it could not be written.
    """
    info = PngImagePlugin.PngInfo()
    info.add(b"sRGB", b"\0")
    for name, text in _texts(srgb8, key, levels).items():
        info.add_text(name, text)
    with _image_file(path) as temporary:
        iio.imwrite(temporary, srgb8, plugin="pillow", compress_level=level, pnginfo=info)


def read_png(path: Path) -> NDArray[np.uint8]:
    """Return a PNG image as (H, W, 3) uint8.

    Raises:
        FrameFileError: it is missing, torn or not as it was written.
    """
    pixels = _intact_content(path).pixels
    return np.asarray(pixels, dtype=np.uint8)


def write_exr(
    path: Path, light: NDArray[np.float32], key: str, levels: PictureLevels | None = None
) -> None:
    """Write linear light (H, W, 3) as EXR of 16-bit floats, completely or not at all.

    Args:
        path: of the file.
        light: the image.
        key: stored in the file, for `read_key`.
        levels: stored in the file, for `read_levels`.

    Raises:
        FrameFileError: it could not be written.
    """
    half = np.clip(light, -65504, 65504).astype(np.float16)
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        **_texts(half, key, levels),
    }
    with _image_file(path) as temporary, OpenEXR.File(header, {"RGB": half}) as file:
        file.write(str(temporary))


def read_exr(path: Path) -> NDArray[np.float32]:
    """Return the linear light (H, W, 3) of an EXR image.

    Raises:
        FrameFileError: it is missing, torn or not as it was written.
    """
    return np.asarray(_intact_content(path).pixels, dtype=np.float32)


def read_key(path: Path) -> str | None:
    """Return the key of a PNG or EXR image.

    None if it has none, is torn, missing or not as it was written.
    """
    try:
        content = _content(path)
    except _UNREADABLE:
        return None
    return content.key if content.digest is not None and content.is_intact else None


def read_levels(path: Path) -> PictureLevels | None:
    """Return the levels stored in a PNG or EXR image; None if it has none or is missing."""
    try:
        text = _header(path).get(LEVELS)
        return PictureLevels.read(text) if isinstance(text, str) else None
    except _UNREADABLE:
        return None


def has_digest(path: Path) -> bool:
    """Return whether a PNG or EXR image holds a digest of itself, right or not."""
    try:
        return DIGEST in _header(path)
    except _UNREADABLE:
        return False


def _header(path: Path) -> Mapping[Any, Any]:
    """Return what stands before the pixels of an image."""
    if path.suffix == ".exr":
        # OpenEXR itself prints a message when a file is missing.
        path.stat()
        with OpenEXR.File(str(path), header_only=True) as file:
            return dict(file.header())
    with Image.open(path) as image:
        return dict(image.info)


@contextmanager
def _image_file(path: Path) -> Iterator[Path]:
    try:
        with replaced_when_complete(path) as temporary:
            yield temporary
    except (OSError, RuntimeError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise FrameFileError(path, f"could not be written: {reason}") from error


def _intact_content(path: Path) -> _Content:
    try:
        content = _content(path)
    except _UNREADABLE as error:
        raise FrameFileError(path, f"is no readable image: {error}; render it again") from error
    if not content.is_intact:
        raise FrameFileError(path, "is not as it was written; render it again")
    return content


def _content(path: Path) -> _Content:
    return _exr_content(path) if path.suffix == ".exr" else _png_content(path)


def _png_content(path: Path) -> _Content:
    with path.open("rb") as file, Image.open(file) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=np.uint8)
        # Pixels may be whole where the end of the file is missing.
        file.seek(-len(_PNG_END), os.SEEK_END)
        if file.read() != _PNG_END:
            raise ValueError("its end is missing")
        return _content_of(pixels, image.info)


def _exr_content(path: Path) -> _Content:
    # OpenEXR itself prints a message when a file is missing.
    path.stat()
    with OpenEXR.File(str(path)) as file:
        pixels = np.asarray(file.channels()["RGB"].pixels)
        return _content_of(pixels, file.header())


def _content_of(pixels: Pixels, members: Mapping[Any, Any]) -> _Content:
    key, levels, digest = (members.get(name) for name in (KEY, LEVELS, DIGEST))
    return _Content(
        pixels,
        key if isinstance(key, str) else None,
        levels if isinstance(levels, str) else "",
        digest if isinstance(digest, str) else None,
    )
