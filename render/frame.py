"""Frames: the layers of light of a traced frame, and the finished frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from render.development import Development, developed
from render.image_resizing import double_size
from render.passes.pass_images import PassImages

Image = NDArray[np.float32]

ALBEDO_BIAS = 0.05
"""Added to albedos, because light is divided by them: black and bare metal have a gleam, too."""


@dataclass(frozen=True, eq=False)
class LightLayers:
    """One frame as traced, before denoising, in linear sRGB.

    Attributes:
        direct: (H, W, 3) light of lamps, sun and sampled sky, reflected by the visible surface.
        albedo: (H, W, 3) diffuse albedo of the visible surface plus `ALBEDO_BIAS`, as dim as the
            haze makes it, and as its turn to the sky does (`sky_relief`); 0 in the sky.
        indirect: (H, W, 3) all other reflected light, of the sky and from surface to surface; or,
            at half the size, (H / 2, W / 2, 3).
        indirect_albedo: the albedo as the samples of `indirect` met it, and of its size.
        air: (H, W, 3) light that no surface reflects: of the sky, of haze, and of visible lamps.
        open_light: (H, W, 3) what `direct` would be without shadows, None where it is not traced.
    """

    direct: Image
    albedo: Image
    indirect: Image
    indirect_albedo: Image
    air: Image
    open_light: Image | None = None

    @property
    def light(self) -> Image:
        """The sum of all light."""
        return self.direct + self.full_size(self.indirect) + self.air

    def full_size(self, soft: Image) -> Image:
        """Return an image of the size of indirect light at that of the frame."""
        return soft if soft.shape == self.direct.shape else double_size(soft)


@dataclass(frozen=True, eq=False)
class LensBlur:
    """Where a picture is out of focus, as shares (H, W, 1) from 0 to 1.

    Attributes:
        soft: how far each pixel is out of focus.
        coarse: how far pictures of half and of a quarter of the size hold all that is seen there.
    """

    soft: Image
    coarse: tuple[Image, ...]


@dataclass(frozen=True, eq=False)
class Frame:
    """One finished frame.

    Attributes:
        light: (H, W, 3) float32, linear sRGB before exposure and tone mapping.
        development: exposure and look.
        passes: for compositing.
    """

    light: Image
    development: Development = field(default_factory=Development)
    passes: PassImages = field(default_factory=PassImages)

    @cached_property
    def srgb8(self) -> NDArray[np.uint8]:
        """(H, W, 3) uint8, ready to show."""
        return developed(self.light, self.development)
