"""Lettering: words drawn over a developed picture.

The letters are those of the DejaVu fonts, which are packaged. They are laid over the picture as it
is shown, after exposure and look, so that white stays white. Pillow draws them, a plain layout of
its own that no library of the system changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter, ImageFont

Integer = TypeVar("Integer", np.uint8, np.uint16)

FONTS = {"serif": "DejaVuSerif.ttf", "sans": "DejaVuSans.ttf"}

FOLDER = Path(__file__).parent / "fonts"

LEADING = 1.35
"""Distance of lines, in the height of one."""

SOFTNESS = 0.12
"""Radius of the blur of a shadow, in the height of a line."""

Align = Literal["left", "center", "right"]


@dataclass(frozen=True)
class Lettering:
    """Words in one frame.

    Attributes:
        text: lines.
        place: of the anchor from the left and from above, in the frame's width and height.
        align: of the lines, to the anchor.
        size: height of a line, in the frame's height.
        font: key of `FONTS`.
        color: sRGB.
        opacity: 0 to 1.
        shadow: its darkness, 0 to 1.
    """

    text: str
    place: tuple[float, float]
    align: Align
    size: float
    font: str
    color: tuple[float, float, float]
    opacity: float
    shadow: float

    def as_list(self) -> list[Any]:
        """Return it as plain values."""
        return [*(getattr(self, name) for name in self.__dataclass_fields__)]

    @staticmethod
    def of_list(values: Sequence[Any]) -> Lettering:
        """Return the lettering of `as_list`.

        Raises:
            ValueError: these are other values.
        """
        if len(values) != len(Lettering.__dataclass_fields__):
            raise ValueError("not a lettering")
        text, (x, y), align, size, font, (r, g, b), opacity, shadow = values
        place, color = (float(x), float(y)), (float(r), float(g), float(b))
        return Lettering(text, place, align, size, font, color, opacity, shadow)


def text_extent(text: str, font: str, size: float, frame: tuple[int, int]) -> tuple[float, float]:
    """Return width and height of words, in those of the frame.

    Args:
        text: lines.
        font: key of `FONTS`.
        size: height of a line, in the frame's height.
        frame: its width and height [pixels].
    """
    lines, letters = text.split("\n"), _font(font, _pixels(size, frame[1]))
    wide = max(letters.getlength(line) for line in lines)
    return wide / frame[0], LEADING * size * len(lines)


def lettered(picture: NDArray[Integer], words: Sequence[Lettering]) -> NDArray[Integer]:
    """Return a picture (H, W, 3) with words over it."""
    top = float(np.iinfo(picture.dtype).max)
    for one in words:
        if one.opacity <= 0.0:
            continue
        letters, shade = _masks(one, (picture.shape[1], picture.shape[0]))
        rows = np.flatnonzero(shade.any(axis=1) | letters.any(axis=1))
        if not len(rows):
            continue
        band = slice(rows[0], rows[-1] + 1)
        dark = (one.opacity * one.shadow * shade[band])[..., None]
        light = (one.opacity * letters[band])[..., None]
        seen = picture[band].astype(np.float32) * (1.0 - dark)
        seen += light * (np.array(one.color, np.float32) * top - seen)
        picture = picture.copy()
        picture[band] = np.clip(seen + 0.5, 0.0, top).astype(picture.dtype)
    return picture


def _masks(
    one: Lettering, frame: tuple[int, int]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the cover of letters and of their shadow in each pixel, (H, W) each, 0 to 1."""
    letters = _drawn(one.text, one.place, one.align, one.size, one.font, frame)
    radius = max(SOFTNESS * one.size * frame[1], 0.7)
    blurred = letters.filter(ImageFilter.GaussianBlur(radius))
    shade = np.minimum(np.asarray(blurred, np.float32) / 255.0 * 1.8, 1.0)
    return np.asarray(letters, np.float32) / 255.0, shade


def _drawn(
    text: str,
    place: tuple[float, float],
    align: Align,
    size: float,
    font: str,
    frame: tuple[int, int],
) -> Image.Image:
    mask = Image.new("L", frame, 0)
    draw, letters = ImageDraw.Draw(mask), _font(font, _pixels(size, frame[1]))
    anchor = {"left": "ls", "center": "ms", "right": "rs"}[align]
    lines = text.split("\n")
    step = LEADING * size * frame[1]
    # The middle of the lines is at the place; a baseline is a third of a line below its middle.
    first = place[1] * frame[1] - 0.5 * step * (len(lines) - 1) + 0.33 * size * frame[1]
    for k, line in enumerate(lines):
        y = first + k * step
        if line and -step < y < frame[1] + step:
            draw.text((place[0] * frame[0], y), line, fill=255, font=letters, anchor=anchor)
    return mask


def _pixels(size: float, height: int) -> float:
    return max(size * height, 4.0)


@lru_cache(maxsize=16)
def _font(name: str, pixels: float) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(FOLDER / FONTS[name], pixels, layout_engine=ImageFont.Layout.BASIC)
