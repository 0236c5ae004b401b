"""Panorama reader: the pixels of an EXR or HDR file, in a child process.

Only `reader_process` calls these functions: the libraries trust the sizes and offsets that a file
claims. They are imported by the functions, so that the parent need not have them.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.foreign_files.reader_child import Reply
from pipeline.foreign_files.safe_file import PANORAMA, ForeignFileError, opened_file

if TYPE_CHECKING:
    from render.lights.environment_map import Map

MAX_FILE_WIDTH = 16_384
"""Width of the largest panorama that is read [pixels]."""

MAX_WIDTH = 2048
"""Width to which a larger panorama is reduced [pixels]."""

_MAX_HEADER_BYTES = 65_536


def read(path: Path, settings: dict[str, Any]) -> Reply:
    """Return the light of a panorama, at most `MAX_WIDTH` wide: (H, W, 3) 64-bit floats.

    Raises:
        ForeignFileError: the file is no panorama.
    """
    del settings
    image = reduced(_pixels(path))
    height, width, _ = image.shape
    content = np.ascontiguousarray(image, np.float64).tobytes()
    return Reply({"width": width, "height": height}, len(content), [content])


def examine(path: Path, settings: dict[str, Any]) -> Reply:
    """Read a panorama as `read` does and return nothing.

    Raises:
        ForeignFileError: the file is no panorama.
    """
    read(path, settings)
    return Reply()


def _pixels(path: Path) -> NDArray[np.float32]:
    """Return the linear light of a panorama (H, W, 3)."""
    width, height = _size(path)
    if width != 2 * height:
        raise ForeignFileError(
            f"is {width} by {height} pixels; a panorama is twice as wide as high"
        )
    if width > MAX_FILE_WIDTH:
        limit = f"{MAX_FILE_WIDTH} by {MAX_FILE_WIDTH // 2}"
        raise ForeignFileError(f"is {width} by {height} pixels, more than {limit}; make it smaller")
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    try:
        bitmap = mi.Bitmap(str(path)).convert(
            mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False
        )
    except RuntimeError as error:
        raise ForeignFileError(f"cannot be read as an image: {_last_line(error)}") from error
    image = np.asarray(bitmap)
    if image.shape != (height, width, 3):
        raise ForeignFileError("cannot be read as an image: it has another size than it says")
    if not np.isfinite(image).all():
        raise ForeignFileError("holds values that are not finite")
    return image


def _last_line(error: Exception) -> str:
    """Return the reason at the end of the message of a library, which describes all before it."""
    last = (str(error).strip().splitlines() or ["no reason given"])[-1]
    return last.rpartition(']". ')[2].strip()


def _size(path: Path) -> tuple[int, int]:
    """Return width and height as the header says them."""
    try:
        with opened_file(path, PANORAMA) as file:
            if path.suffix.lower() == ".hdr":
                return _hdr_size(file.read(_MAX_HEADER_BYTES))
        return _exr_size(path)
    except (OSError, RuntimeError, ValueError, KeyError, TypeError) as error:
        raise ForeignFileError(f"cannot be read as an image: {_last_line(error)}") from error


def _hdr_size(head: bytes) -> tuple[int, int]:
    if not head.startswith(b"#?"):
        raise ValueError("it does not start as an HDR file does")
    found = re.search(rb"\n\n[-+]Y (\d{1,20}) [-+]X (\d{1,20})\n", head)
    if found is None:
        raise ValueError("its header gives no size")
    return int(found[2]), int(found[1])


def _exr_size(path: Path) -> tuple[int, int]:
    import OpenEXR

    with OpenEXR.File(str(path), header_only=True) as file:
        low, high = file.header()["dataWindow"]
    return int(high[0]) - int(low[0]) + 1, int(high[1]) - int(low[1]) + 1


def reduced(image: NDArray[np.float32] | Map) -> Map:
    """Return a map at most `MAX_WIDTH` wide with the same light in every direction."""
    factor = math.ceil(image.shape[1] / MAX_WIDTH)
    height, width = image.shape[0] // factor, image.shape[1] // factor
    if factor == 1 or height == 0:
        return np.asarray(image, np.float64).clip(0.0, None)
    small = np.empty((height, width, 3))
    # Row by row: in the wider floats a large panorama would take as much again.
    for row in range(height):
        rows = image[row * factor : (row + 1) * factor, : width * factor]
        cut = np.asarray(rows, np.float64).clip(0.0, None).reshape(factor, width, factor, 3)
        # Not weighted by solid angle, which hardly changes within one pixel of the result.
        small[row] = cut.mean(axis=(0, 2))
    return small
