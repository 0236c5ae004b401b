"""Specks: single pixels of sky in dark crowns, of leaves before the sky, of petals in the grass.

The few samples of a pixel may all pass gaps between leaves that are far smaller than the pixel, or
all meet leaves, petals or bark as small. Such pixels are not denoised, because the sky and the
colours of surfaces are taken for clean. What is brighter or darker than all its neighbours but one
becomes as that one; outlines, twigs and stars stay, because they go on in neighbouring pixels or
are no part of the sky.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from render.color import luminance
from render.frame import Image, LightLayers

AROUND = tuple((y, x) for y in (-1, 0, 1) for x in (-1, 0, 1) if (y, x) != (0, 0))
"""Steps to the neighbours of a pixel."""

CONTRAST = 1.25
"""Ratio of the light of the air, or of albedos, from which on a pixel differs from the one that it
becomes as."""

SHARP = 0.05
"""How far a pixel may be out of focus."""

MOST_ALIKE = 1
"""Neighbours of a speck that may be as bright, or as dark, as it."""

LESS_SURFACE = 0.9
"""Albedo of a speck of sky, or around a speck of leaf, in the other's, below which the difference
is that of sky and not of a visible lamp or a star."""

BRIGHTEST = 0.98
"""Quantile of the light of the sky up to which a speck may be a part of it."""

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Specks:
    """N pixels that are brighter or darker than all their neighbours but `MOST_ALIKE`.

    Attributes:
        y: (N,) rows.
        x: (N,) columns.
        near_y: (8, N) rows of their neighbours.
        near_x: (8, N) columns of them.
        share: (8, N) of each neighbour in what a pixel becomes as; their sum is 1.
        part: (N,) how far it becomes as those.
        is_bright: (N,) whether it is too bright, else too dark.
    """

    y: Indices
    x: Indices
    near_y: Indices
    near_x: Indices
    share: Image
    part: Image
    is_bright: NDArray[np.bool_]

    @staticmethod
    def of(values: Image, softness: Image | None) -> _Specks:
        """Return the specks of values (H, W) that are in focus."""
        y, x = _candidates(values)
        if softness is not None:
            is_sharp = softness[y, x, 0] < SHARP
            y, x = y[is_sharp], x[is_sharp]
        height, width = values.shape
        near_y = np.stack([np.clip(y + dy, 0, height - 1) for dy, _ in AROUND])
        near_x = np.stack([np.clip(x + dx, 0, width - 1) for _, dx in AROUND])
        own, near = values[y, x], values[near_y, near_x]
        least, most = np.partition(near, (MOST_ALIKE, -1 - MOST_ALIKE), axis=0)[
            [MOST_ALIKE, -1 - MOST_ALIKE]
        ]
        found = np.flatnonzero((own > CONTRAST * most) | (CONTRAST * own < least))
        own, near, least, most = own[found], near[:, found], least[found], most[found]
        is_bright = own > most
        bound = np.where(is_bright, most, least)
        unlike = np.where(is_bright, near <= most, near >= least)
        share = (unlike / unlike.sum(axis=0)).astype(np.float32)
        part = (own - bound) / (own - (near * share).sum(axis=0))
        return _Specks(
            *(y[found], x[found], near_y[:, found], near_x[:, found], share, part, is_bright)
        )

    def chosen(self, which: NDArray[np.bool_]) -> _Specks:
        """Return some of them (N,)."""
        return _Specks(
            *(self.y[which], self.x[which], self.near_y[:, which], self.near_x[:, which]),
            *(self.share[:, which], self.part[which], self.is_bright[which]),
        )

    def around(self, image: Image) -> Image:
        """Return the means (N, C) of what they become as in an image (H, W, C)."""
        return np.asarray((image[self.near_y, self.near_x] * self.share[..., None]).sum(axis=0))

    def mended(self, image: Image) -> Image:
        """Return an image (H, W, C) without them."""
        result = image.copy()
        own = image[self.y, self.x]
        result[self.y, self.x] = own + self.part[:, None] * (self.around(image) - own)
        return result


def without_specks(layers: LightLayers, softness: Image | None = None) -> LightLayers:
    """Return the layers of a frame without specks of sky, of leaves in the sky and of colour.

    Only single pixels change, by a share of the mean of their neighbours of the other kind. What is
    out of focus is noise, whose mean it would change.

    Args:
        layers: of the frame.
        softness: (H, W, 1) how far each pixel is out of focus, 0 to 1; None for nowhere.

    Source: Davies 1997, conservative smoothing, with the second extremum in place of the first.
    """
    return _without_color_specks(_without_sky_specks(layers, softness), softness)


def _without_sky_specks(layers: LightLayers, softness: Image | None) -> LightLayers:
    air = luminance(layers.air).astype(np.float32)
    specks = _Specks.of(air, softness)
    surface = layers.albedo.sum(axis=-1)
    own, here = air[specks.y, specks.x], surface[specks.y, specks.x]
    there = specks.around(surface[..., None])[:, 0]
    # Less air has more surface: else it is not the sky that makes the difference. A sample or two
    # of sky among many of leaves do not show so, but are no brighter than the sky.
    clear = air[surface == 0.0]
    brightest = np.quantile(clear, BRIGHTEST) if len(clear) else 0.0
    is_gap = (here < LESS_SURFACE * there) | ((own <= brightest) & (there > 0.0))
    is_leaf = there < LESS_SURFACE * here
    specks = specks.chosen(np.where(specks.is_bright, is_gap, is_leaf))
    return replace(
        layers,
        direct=specks.mended(layers.direct),
        albedo=specks.mended(layers.albedo),
        air=specks.mended(layers.air),
    )


def _without_color_specks(layers: LightLayers, softness: Image | None) -> LightLayers:
    """Return layers without specks of another albedo; the light on them stays."""
    specks = _Specks.of(luminance(layers.albedo).astype(np.float32), softness)
    # The sky in or around a pixel tells nothing of colours.
    is_surface = layers.albedo[..., 1] > 0.0
    near = is_surface[specks.near_y, specks.near_x].all(axis=0)
    specks = specks.chosen(near & is_surface[specks.y, specks.x])
    at = specks.y, specks.x
    old, albedo, direct = layers.albedo[at], specks.mended(layers.albedo), layers.direct.copy()
    direct[at] *= np.divide(albedo[at], old, out=np.ones_like(old), where=old > 0)
    return replace(layers, albedo=albedo, direct=direct)


def _candidates(values: Image) -> tuple[Indices, Indices]:
    """Return the pixels that differ from all neighbours in row and column but `MOST_ALIKE`."""
    apart = np.pad(values, 1, mode="edge")
    over, under = (np.zeros(values.shape, np.int8) for _ in range(2))
    for near in (apart[1:-1, :-2], apart[1:-1, 2:], apart[:-2, 1:-1], apart[2:, 1:-1]):
        over += CONTRAST * near < values
        under += near > CONTRAST * values
    least = 4 - MOST_ALIKE
    found = np.nonzero((over >= least) | (under >= least))
    return found[0], found[1]
