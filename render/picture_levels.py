"""Picture levels: by which a black or a blown-out picture is known."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from render.color import luminance
from render.development import Development, developed

Value = TypeVar("Value", np.uint8, np.float32)

BRIGHT_PERCENTILE = 99.0
"""Percentile of the luma that tells a black picture: a few fireflies are no picture."""

TOP = 0.9
"""Luma from which a pixel is white: AgX rolls highlights off, and hardly anything reaches 1."""

MEASURED_PIXELS = 10_000
"""Number of pixels that are measured, about; a grid of them tells as much as all."""


@dataclass(frozen=True, slots=True)
class PictureLevels:
    """Two levels of a picture.

    Attributes:
        bright: 99th percentile of the luma, 0 to 1.
        white: share of the pixels at the top.
    """

    bright: float
    white: float

    @classmethod
    def of(cls, light: NDArray[np.float32], how: Development) -> Self:
        """Return the levels of linear light (H, W, 3), developed without words over it."""
        return cls.of_srgb8(developed(_thinned(light), replace(how, words=())))

    @classmethod
    def of_srgb8(cls, picture: NDArray[np.uint8]) -> Self:
        """Return the levels of an sRGB picture (H, W, 3)."""
        luma = luminance(_thinned(picture).astype(np.float32) / np.float32(255.0))
        bright = float(np.percentile(luma, BRIGHT_PERCENTILE))
        return cls(round(bright, 4), round(float((luma >= TOP).mean()), 4))

    @classmethod
    def read(cls, text: str) -> Self:
        """Return the levels that `str` wrote.

        Raises:
            ValueError: it is another text.
        """
        bright, white = (float(word) for word in text.split())
        return cls(bright, white)

    def __str__(self) -> str:
        return f"{self.bright:.4f} {self.white:.4f}"


def _thinned(picture: NDArray[Value]) -> NDArray[Value]:
    step = max(1, math.isqrt(picture.shape[0] * picture.shape[1] // MEASURED_PIXELS))
    return picture[::step, ::step]
