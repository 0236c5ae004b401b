"""Exposure: the light that fell on the film, in the parts that a denoiser treats differently."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Exposure:
    """One frame as it was traced, before its noise is removed.

    Attributes:
        direct: (H, W, 3) light of lamps, seen or by way of the surface that is seen; linear sRGB.
        color: (H, W, 3) diffuse colour of the surface that is seen, 0 to 1, black in the sky.
        indirect: (H, W, 3) all other light: of the sky, and from surface to surface.
        dye: (H, W, 3) the colour again, as the samples of `indirect` have met it.
    """

    direct: Image
    color: Image
    indirect: Image
    dye: Image

    @property
    def light(self) -> Image:
        """All of it."""
        return self.direct + self.indirect

    @staticmethod
    def mean(exposures: Sequence[Exposure]) -> Exposure:
        """Return the mean of exposures that are equally long."""
        if len(exposures) == 1:
            return exposures[0]
        count = np.float32(len(exposures))
        parts = [[e.direct, e.color, e.indirect, e.dye] for e in exposures]
        return Exposure(*(np.asarray(sum(p[1:], p[0]) / count) for p in zip(*parts, strict=True)))
