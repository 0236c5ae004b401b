"""Sky specks: single pixels of sky in dark crowns, and of leaves before the sky.

The few samples of a pixel may all pass a gap between leaves that is far smaller than the pixel, or
all meet a leaf as small. Such pixels are not denoised, because the sky is taken for clean. One by
itself among pixels of the other kind becomes as these are; outlines, twigs and stars stay, because
they go on in neighbouring pixels.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from render.color import luminance
from render.frame import Image, LightLayers

AROUND = tuple((y, x) for y in (-1, 0, 1) for x in (-1, 0, 1) if (y, x) != (0, 0))
"""Steps to the neighbours of a pixel."""

CONTRAST = 2.0
"""Ratio of the light of the air from which on two pixels differ in what share of them is sky."""

MOST_ALIKE = 1
"""Neighbours of a speck that are like it."""

LESS_SURFACE = 0.8
"""Albedo of a speck of sky, or around a speck of leaf, in the other's, below which the difference
is that of sky and not of a visible lamp or a star."""

Indices = NDArray[np.intp]


def without_specks(layers: LightLayers) -> LightLayers:
    """Return the layers of a frame without specks of sky among leaves and of leaves in the sky."""
    air = luminance(layers.air).astype(np.float32)
    surface = layers.albedo.sum(axis=-1)
    y, x = _candidates(air)
    if not len(y):
        return layers
    height, width = air.shape
    near_y = np.stack([np.clip(y + dy, 0, height - 1) for dy, _ in AROUND])
    near_x = np.stack([np.clip(x + dx, 0, width - 1) for _, dx in AROUND])
    own, near = air[y, x], air[near_y, near_x]
    is_sky = near * CONTRAST < own
    is_leaf = near > own * CONTRAST
    unlike = np.where(is_sky.sum(axis=0) >= is_leaf.sum(axis=0), is_sky, is_leaf)
    count = unlike.sum(axis=0)
    there = (surface[near_y, near_x] * unlike).sum(axis=0) / np.maximum(count, 1)
    here = surface[y, x]
    less, more = np.minimum(here, there), np.maximum(here, there)
    # Less air has more surface: else it is not the sky that makes the difference.
    of_sky = (here < there) == (is_sky.sum(axis=0) >= is_leaf.sum(axis=0))
    is_speck = (count >= len(AROUND) - MOST_ALIKE) & of_sky & (less < LESS_SURFACE * more)
    if not is_speck.any():
        return layers
    y, x, unlike, count = y[is_speck], x[is_speck], unlike[:, is_speck], count[is_speck]
    near_y, near_x = near_y[:, is_speck], near_x[:, is_speck]
    share = (unlike / count).astype(np.float32)[..., None]

    def mended(image: Image) -> Image:
        result = image.copy()
        result[y, x] = (image[near_y, near_x] * share).sum(axis=0)
        return result

    return replace(
        layers,
        direct=mended(layers.direct),
        albedo=mended(layers.albedo),
        air=mended(layers.air),
    )


def _candidates(air: NDArray[np.float32]) -> tuple[Indices, Indices]:
    """Return the pixels that differ from a neighbour in their row and from one in their column."""
    apart = np.pad(air, 1, mode="edge")
    over, under = air > 0.0, air > 0.0
    for first, second in (
        (apart[1:-1, :-2], apart[1:-1, 2:]),
        (apart[:-2, 1:-1], apart[2:, 1:-1]),
    ):
        over &= CONTRAST * np.minimum(first, second) < air
        under &= np.maximum(first, second) > CONTRAST * air
    found = np.nonzero(over | under)
    return found[0], found[1]
