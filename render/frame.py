"""Frame: a finished picture, as light and as it is shown."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from render.color import developed


@dataclass(frozen=True, eq=False)
class Frame:
    """One finished picture.

    Attributes:
        light: (H, W, 3) float32, linear sRGB before exposure and tone.
        exposure: stops by which it is shown brighter.
    """

    light: NDArray[np.float32]
    exposure: float = 0.0

    @cached_property
    def srgb8(self) -> NDArray[np.uint8]:
        """(H, W, 3) uint8, ready to show."""
        return developed(self.light, self.exposure)
