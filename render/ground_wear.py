"""Ground wear: where ground is worn down to bare soil, seen from above."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

TEXELS = 1024
"""Texels along a side, a power of two."""


@dataclass(frozen=True, eq=False)
class GroundWear:
    """Bare soil on ground around a scene.

    Attributes:
        corner: least x and z [m].
        size: of the square [m].
        texels: (TEXELS, TEXELS) uint8 shares of soil, 255 for all; rows go along Z.
        color: linear, of the soil.
    """

    corner: tuple[float, float]
    size: float
    texels: NDArray[np.uint8]
    color: tuple[float, float, float]

    @cached_property
    def bytes(self) -> bytes:
        """All of it as bytes, for a digest."""
        return repr((self.corner, self.size, self.color)).encode() + self.texels.tobytes()
