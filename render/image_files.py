"""Pictures on disk: PNG and EXR files that carry the key they were made under.

A file is written beside its place and then renamed, so that a process that is
killed at any moment leaves the old picture or the new one, never a torn one.
"""

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

from render.errors import FrameFileError

KEY = "pronk-key"
"""Name of the text chunk or attribute that holds the key."""

_LEVEL = 1
"""Of deflate: on rendered frames a tenth larger than level 3 at half the time."""

_PNG_END = b"\0\0\0\0IEND\xaeB`\x82"


def write_png(path: Path, srgb8: NDArray[np.uint8], key: str, level: int = _LEVEL) -> None:
    """Write an 8-bit sRGB picture (H, W, 3) as PNG, whole or not at all.

    Args:
        path: where it goes.
        srgb8: the picture.
        key: kept in the file, for `read_key`.
        level: of deflate, 9 for the smallest file.

    Raises:
        FrameFileError: it could not be written.
    """
    words = PngImagePlugin.PngInfo()
    words.add(b"sRGB", b"\0")
    words.add_text(KEY, key)
    with beside(path) as temporary:
        iio.imwrite(temporary, srgb8, plugin="pillow", compress_level=level, pnginfo=words)


def read_png(path: Path) -> NDArray[np.uint8]:
    """Return a PNG picture as (H, W, 3) uint8.

    Raises:
        FrameFileError: it is missing or torn.
    """
    try:
        return np.asarray(iio.imread(path, plugin="pillow", mode="RGB"), dtype=np.uint8)
    except (OSError, SyntaxError, ValueError) as error:
        raise FrameFileError(f"{path} is no readable picture: {error}; render it again") from error


def write_exr(path: Path, light: NDArray[np.float32], key: str) -> None:
    """Write linear light (H, W, 3) as EXR of 16-bit floats, whole or not at all.

    Raises:
        FrameFileError: it could not be written.
    """
    half = np.clip(light, -65504, 65504).astype(np.float16)
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        KEY: key,
    }
    with beside(path) as temporary, OpenEXR.File(header, {"RGB": half}) as file:
        file.write(str(temporary))


def read_exr(path: Path) -> NDArray[np.float32]:
    """Return the linear light (H, W, 3) of an EXR picture.

    Raises:
        FrameFileError: it is missing or torn.
    """
    try:
        path.stat()
        with OpenEXR.File(str(path)) as file:
            return np.asarray(file.channels()["RGB"].pixels, dtype=np.float32)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise FrameFileError(f"{path} is no readable picture: {error}; render it again") from error


def read_key(path: Path) -> str | None:
    """Return the key of a PNG or EXR picture; None if it has none, is torn or is missing."""
    try:
        return _exr_key(path) if path.suffix == ".exr" else _png_key(path)
    except (OSError, SyntaxError, ValueError, RuntimeError):
        return None


@contextmanager
def beside(path: Path) -> Iterator[Path]:
    """Give a place beside `path`, whose file takes its place when the block ends well.

    Raises:
        FrameFileError: it could not be written.
    """
    # The suffix stays, because encoders choose the container by it.
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    except (OSError, RuntimeError) as error:
        raise FrameFileError(f"{path} could not be written: {error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def _png_key(path: Path) -> str | None:
    with path.open("rb") as file, Image.open(file) as image:
        file.seek(-len(_PNG_END), os.SEEK_END)
        if file.read() != _PNG_END:
            return None
        file.seek(0)
        key = image.info.get(KEY)
        # Checks the sums of all chunks up to the last without unpacking the pixels.
        image.verify()
    return key if isinstance(key, str) else None


def _exr_key(path: Path) -> str | None:
    # The library itself says on the terminal that a file is missing.
    if not path.is_file():
        return None
    # A torn file is known by reading it, for its header stands at its begin.
    with OpenEXR.File(str(path)) as file:
        key = file.header().get(KEY)
        file.channels()
    return key if isinstance(key, str) else None
