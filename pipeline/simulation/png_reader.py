"""PNG reader: the pixels of a grayscale picture, in a child process.

Only `reader_process` calls this function, because compiled code decodes the picture. It is imported
there without NumPy, which would take longer than the picture.
"""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import Any

from pipeline.foreign_files.reader_child import Reply
from pipeline.foreign_files.safe_file import HEIGHT_MAP, ForeignFileError, read_file

MAX_PIXELS, MIN_PIXELS = 4000, 3
"""Pixels along one side."""

SAMPLE_TYPES = {"1": "u1", "L": "u1", "I;16": "<u2", "I;16B": ">u2", "I": "=i4"}
"""NumPy types of pixels by Pillow's mode of the picture."""


def read_gray(path: Path, settings: dict[str, Any]) -> Reply:
    """Return the pixels of a grayscale picture, row by row, and its `mode` and `size`.

    Raises:
        ForeignFileError: the file is no such picture.
    """
    del settings
    from PIL import Image, UnidentifiedImageError

    content = io.BytesIO(read_file(path, HEIGHT_MAP))
    try:
        with warnings.catch_warnings():
            # Of pictures beyond 89 million pixels Pillow warns before it tells their size.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(content, formats=("PNG",))
        _check(picture)
        # Eight bits a pixel where the file has one.
        pixels = (picture.convert("L") if picture.mode == "1" else picture).tobytes()
    except UnidentifiedImageError:
        raise ForeignFileError("is no PNG picture") from None
    except Image.DecompressionBombError:
        raise ForeignFileError(f"is larger than {MAX_PIXELS} x {MAX_PIXELS} pixels") from None
    except (OSError, SyntaxError, ValueError) as error:
        raise ForeignFileError(f"cannot be read: {error}") from None
    return Reply({"mode": picture.mode, "size": picture.size}, len(pixels), [pixels])


def _check(picture: Any) -> None:
    width, height = picture.size
    if max(width, height) > MAX_PIXELS:
        size = f"{width} x {height} pixels, more than {MAX_PIXELS} x {MAX_PIXELS}"
        raise ForeignFileError(f"has {size}; make it smaller")
    if min(width, height) < MIN_PIXELS:
        size = f"{width} x {height} pixels, fewer than {MIN_PIXELS} x {MIN_PIXELS}"
        raise ForeignFileError(f"has {size}")
    if picture.mode not in SAMPLE_TYPES:
        kind = f"a picture of kind {picture.mode}"
        raise ForeignFileError(f"is {kind}; should be grayscale of 8 or 16 bits")
