"""Image files: PNG and EXR with the key of their frame, written atomically."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

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

_LEVEL = 1
"""Deflate level: on rendered frames a tenth larger than level 3, in half the time."""

_PNG_END = b"\0\0\0\0IEND\xaeB`\x82"


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
    info.add_text(KEY, key)
    if levels is not None:
        info.add_text(LEVELS, str(levels))
    with _image_file(path) as temporary:
        iio.imwrite(temporary, srgb8, plugin="pillow", compress_level=level, pnginfo=info)


def read_png(path: Path) -> NDArray[np.uint8]:
    """Return a PNG image as (H, W, 3) uint8.

    Raises:
        FrameFileError: it is missing or torn.
    """
    try:
        return np.asarray(iio.imread(path, plugin="pillow", mode="RGB"), dtype=np.uint8)
    except (OSError, SyntaxError, ValueError) as error:
        raise FrameFileError(f"{path} is no readable image: {error}; render it again") from error


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
        KEY: key,
    }
    if levels is not None:
        header[LEVELS] = str(levels)
    with _image_file(path) as temporary, OpenEXR.File(header, {"RGB": half}) as file:
        file.write(str(temporary))


def read_exr(path: Path) -> NDArray[np.float32]:
    """Return the linear light (H, W, 3) of an EXR image.

    Raises:
        FrameFileError: it is missing or torn.
    """
    try:
        path.stat()
        with OpenEXR.File(str(path)) as file:
            return np.asarray(file.channels()["RGB"].pixels, dtype=np.float32)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise FrameFileError(f"{path} is no readable image: {error}; render it again") from error


def read_key(path: Path) -> str | None:
    """Return the key of a PNG or EXR image; None if it has none, is torn or is missing."""
    try:
        return _exr_key(path) if path.suffix == ".exr" else _png_key(path)
    except (OSError, SyntaxError, ValueError, RuntimeError):
        return None


def read_levels(path: Path) -> PictureLevels | None:
    """Return the levels stored in a PNG or EXR image; None if it has none or is missing."""
    try:
        if path.suffix == ".exr":
            path.stat()
            with OpenEXR.File(str(path), header_only=True) as file:
                text = file.header().get(LEVELS)
        else:
            with Image.open(path) as image:
                text = image.info.get(LEVELS)
        return PictureLevels.read(text) if isinstance(text, str) else None
    except (OSError, SyntaxError, ValueError, RuntimeError):
        return None


@contextmanager
def _image_file(path: Path) -> Iterator[Path]:
    try:
        with replaced_when_complete(path) as temporary:
            yield temporary
    except (OSError, RuntimeError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise FrameFileError(f"{path} could not be written: {reason}") from error


def _png_key(path: Path) -> str | None:
    with path.open("rb") as file, Image.open(file) as image:
        file.seek(-len(_PNG_END), os.SEEK_END)
        if file.read() != _PNG_END:
            return None
        file.seek(0)
        key = image.info.get(KEY)
        # Checks the CRC of all chunks without decompressing the pixels.
        image.verify()
    return key if isinstance(key, str) else None


def _exr_key(path: Path) -> str | None:
    # OpenEXR itself prints a message when a file is missing.
    if not path.is_file():
        return None
    # Only reading the pixels reveals a torn file, because its header stands at its start.
    with OpenEXR.File(str(path)) as file:
        key = file.header().get(KEY)
        file.channels()
    return key if isinstance(key, str) else None
