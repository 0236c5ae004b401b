"""Image files: PNG and EXR with the key of their frame, written atomically.

A file also holds a digest of its pixels, key and levels, so that it counts only as it was written.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping, Sequence
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
from render.development import Development
from render.errors import FrameFileError
from render.passes.pass_images import PassPart
from render.picture_levels import PictureLevels

KEY = "pronk-key"
"""Name of the text chunk or attribute that holds the key."""

LEVELS = "pronk-levels"
"""Name of the text chunk or attribute that holds the levels of the picture."""

DEVELOPMENT = "pronk-development"
"""Name of the attribute that holds how the light of an EXR image is shown."""

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
        development: as text, "" if it has none.
        digest: None if it has none.
        passes: in the further parts of the file.
    """

    pixels: Pixels
    key: str | None
    levels: str
    development: str
    digest: str | None
    passes: tuple[PassPart, ...] = ()

    @property
    def is_intact(self) -> bool:
        """Whether the file is as it was written; True for one without a digest."""
        return self.digest is None or self.digest == _digest(
            self.pixels, self.key or "", self.levels, self.development, self.passes
        )


def _digest(
    pixels: Pixels, key: str, levels: str, development: str, passes: Sequence[PassPart] = ()
) -> str:
    shown = f"|{development}" if development else ""
    text = f"{key}|{levels}|{pixels.shape}{shown}"
    state = hashlib.blake2b(text.encode(), digest_size=16)
    state.update(np.ascontiguousarray(pixels).data)
    for part in passes:
        for name, values in sorted(part.channels.items()):
            state.update(f"{part.name}|{name}|{values.shape}".encode())
            state.update(np.ascontiguousarray(values).data)
    return state.hexdigest()


def _texts(
    pixels: Pixels,
    key: str,
    levels: PictureLevels | None,
    development: Development | None = None,
    passes: Sequence[PassPart] = (),
) -> dict[str, str]:
    """Return the texts that stand beside pixels."""
    given = {LEVELS: levels, DEVELOPMENT: development}
    texts = {name: str(value) for name, value in given.items() if value is not None}
    digest = _digest(pixels, key, texts.get(LEVELS, ""), texts.get(DEVELOPMENT, ""), passes)
    return {KEY: key, DIGEST: digest, **texts}


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
    path: Path,
    light: NDArray[np.float32],
    key: str,
    levels: PictureLevels | None = None,
    development: Development | None = None,
    passes: Sequence[PassPart] = (),
) -> None:
    """Write linear light (H, W, 3) as EXR of 16-bit floats, completely or not at all.

    Passes are further parts of the file, in 32-bit floats.

    Args:
        path: of the file.
        light: the image.
        key: stored in the file, for `read_key`.
        levels: stored in the file, for `read_levels`.
        development: stored in the file, for `read_development`; as it is by default.
        passes: written behind the light, which is the first part.

    Raises:
        FrameFileError: it could not be written.
    """
    # OpenEXR takes the memory as it lies, and frames of the denoiser lie column by column.
    half = np.ascontiguousarray(np.clip(light, -65504, 65504), np.float16)
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        **_texts(half, key, levels, development or Development(), passes),
    }
    parts = [OpenEXR.Part(header, {"RGB": half}, "light" if passes else "")]
    for part in passes:
        head = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        channels = {name: np.ascontiguousarray(x) for name, x in part.channels.items()}
        parts.append(OpenEXR.Part({**head, **part.attributes}, channels, part.name))
    with _image_file(path) as temporary, OpenEXR.File(parts) as file:
        file.write(str(temporary))


def read_exr(path: Path) -> NDArray[np.float32]:
    """Return the linear light (H, W, 3) of an EXR image.

    Raises:
        FrameFileError: it is missing, torn or not as it was written.
    """
    return np.asarray(_intact_content(path).pixels, dtype=np.float32)


def read_passes(path: Path) -> tuple[PassPart, ...]:
    """Return the passes of an EXR image.

    Raises:
        FrameFileError: it is missing, torn or not as it was written.
    """
    return _intact_content(path).passes


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


def read_development(path: Path) -> Development:
    """Return how the light of an EXR image is shown.

    Raises:
        FrameFileError: it is missing or does not say so.
    """
    try:
        return Development.read(_header(path)[DEVELOPMENT])
    except _UNREADABLE as error:
        text = f"does not say how it is developed ({error}); render it again"
        raise FrameFileError(path, text) from error


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
        # Copied: the file takes its memory with it.
        pixels = np.array(file.channels()["RGB"].pixels)
        passes = tuple(_read_pass(part) for part in file.parts[1:])
        return _content_of(pixels, file.header(), passes)


def _read_pass(part: Any) -> PassPart:
    channels: dict[str, NDArray[np.float32]] = {}
    for name, channel in part.channels.items():
        values = np.array(channel.pixels, np.float32)
        if values.ndim == 2:
            channels[name] = values
            continue
        # Channels that differ only in R, G, B and A are read as one.
        for i, letter in enumerate("RGBA"[: values.shape[2]]):
            channels[f"{name}.{letter}"] = np.ascontiguousarray(values[..., i])
    texts = {name: x for name, x in part.header.items() if name.startswith("cryptomatte/")}
    return PassPart(part.name(), channels, texts)


def _content_of(
    pixels: Pixels, members: Mapping[Any, Any], passes: tuple[PassPart, ...] = ()
) -> _Content:
    key, levels, shown, digest = (members.get(name) for name in (KEY, LEVELS, DEVELOPMENT, DIGEST))
    return _Content(
        pixels,
        key if isinstance(key, str) else None,
        levels if isinstance(levels, str) else "",
        shown if isinstance(shown, str) else "",
        digest if isinstance(digest, str) else None,
        passes,
    )
