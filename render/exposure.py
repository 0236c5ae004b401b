"""Exposure: the light that fell on the film, in the parts that a denoiser treats differently."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]

GLEAM = 0.05
"""Added to the colours of surfaces: light is divided by them, and what is black or bare metal has a
gleam yet."""


@dataclass(frozen=True, eq=False)
class Exposure:
    """One frame as it was traced, before its noise is removed.

    Attributes:
        direct: (H, W, 3) light of lamps, seen or by way of the surface that is seen; linear sRGB.
        color: (H, W, 3) diffuse colour of the surface that is seen and `GLEAM`; 0 in the sky.
        indirect: (H, W, 3) all other light: of the sky, and from surface to surface; or, at half
            the size, (H / 2, W / 2, 3).
        dye: the colour again, as the samples of `indirect` have met it, and of its size.
    """

    direct: Image
    color: Image
    indirect: Image
    dye: Image

    @property
    def light(self) -> Image:
        """All of it."""
        return self.direct + self.enlarged(self.indirect)

    def enlarged(self, soft: Image) -> Image:
        """Return a picture of the size of soft light at that of the whole."""
        return soft if soft.shape == self.direct.shape else _doubled(_doubled(soft, 0), 1)


def _doubled(picture: Image, axis: int) -> Image:
    """Return a picture twice as long along an axis, straight between the middles of pixels."""
    near = np.moveaxis(picture, axis, 0)
    before = np.concatenate([near[:1], near[:-1]])
    after = np.concatenate([near[1:], near[-1:]])
    twice = np.empty((2 * len(near), *near.shape[1:]), np.float32)
    twice[0::2] = near + np.float32(0.25) * (before - near)
    twice[1::2] = near + np.float32(0.25) * (after - near)
    return np.moveaxis(twice, 0, axis)
