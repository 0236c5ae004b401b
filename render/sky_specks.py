"""Sky specks: single pixels of sky in dark crowns, and of leaves before the sky.

The few samples of a pixel may all pass gaps between leaves that are far smaller than the pixel, or
all meet leaves as small. Such pixels are not denoised, because the sky is taken for clean. What is
brighter or darker than all its neighbours but one becomes as that one; outlines, twigs and stars
stay, because they go on in neighbouring pixels or are no part of the sky.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from render.color import luminance
from render.frame import Image, LightLayers

AROUND = tuple((y, x) for y in (-1, 0, 1) for x in (-1, 0, 1) if (y, x) != (0, 0))
"""Steps to the neighbours of a pixel."""

CONTRAST = 1.25
"""Ratio of the light of the air from which on a pixel differs from the one that it becomes as."""

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


def without_specks(layers: LightLayers, softness: Image | None = None) -> LightLayers:
    """Return the layers of a frame without specks of sky among leaves and of leaves in the sky.

    Only single pixels change, by a share of the mean of their neighbours of the other kind. What is
    out of focus is noise, whose mean it would change.

    Args:
        layers: of the frame.
        softness: (H, W, 1) how far each pixel is out of focus, 0 to 1; None for nowhere.

    Source: Davies 1997, conservative smoothing, with the second extremum in place of the first.
    """
    air = luminance(layers.air).astype(np.float32)
    y, x = _candidates(air)
    if softness is not None:
        is_sharp = softness[y, x, 0] < SHARP
        y, x = y[is_sharp], x[is_sharp]
    if not len(y):
        return layers
    surface = layers.albedo.sum(axis=-1)
    height, width = air.shape
    near_y = np.stack([np.clip(y + dy, 0, height - 1) for dy, _ in AROUND])
    near_x = np.stack([np.clip(x + dx, 0, width - 1) for _, dx in AROUND])
    own, near = air[y, x], air[near_y, near_x]
    least, most = np.partition(near, (MOST_ALIKE, -1 - MOST_ALIKE), axis=0)[
        [MOST_ALIKE, -1 - MOST_ALIKE]
    ]
    is_sky = own > CONTRAST * most
    bound = np.where(is_sky, most, least)
    unlike = np.where(is_sky, near <= most, near >= least)
    count = unlike.sum(axis=0)
    other = (near * unlike).sum(axis=0) / count
    there = (surface[near_y, near_x] * unlike).sum(axis=0) / count
    here = surface[y, x]
    # Less air has more surface: else it is not the sky that makes the difference. A sample or two
    # of sky among many of leaves do not show so, but are no brighter than the sky.
    clear = air[surface == 0.0]
    brightest = np.quantile(clear, BRIGHTEST) if len(clear) else 0.0
    is_gap = (here < LESS_SURFACE * there) | ((own <= brightest) & (there > 0.0))
    is_leaf = (CONTRAST * own < least) & (there < LESS_SURFACE * here)
    of_sky = np.where(is_sky, is_gap, is_leaf)
    y, x, near_y, near_x = y[of_sky], x[of_sky], near_y[:, of_sky], near_x[:, of_sky]
    part = ((own - bound)[of_sky] / (own - other)[of_sky]).astype(np.float32)[:, None]
    share = (unlike / count)[:, of_sky].astype(np.float32)[..., None]

    def mended(image: Image) -> Image:
        result = image.copy()
        around = (image[near_y, near_x] * share).sum(axis=0)
        result[y, x] += part * (around - result[y, x])
        return result

    return replace(
        layers,
        direct=mended(layers.direct),
        albedo=mended(layers.albedo),
        air=mended(layers.air),
    )


def _candidates(air: NDArray[np.float32]) -> tuple[Indices, Indices]:
    """Return the pixels that differ from all neighbours in row and column but `MOST_ALIKE`."""
    apart = np.pad(air, 1, mode="edge")
    over, under = (np.zeros(air.shape, np.int8) for _ in range(2))
    for near in (apart[1:-1, :-2], apart[1:-1, 2:], apart[:-2, 1:-1], apart[2:, 1:-1]):
        over += CONTRAST * near < air
        under += near > CONTRAST * air
    least = 4 - MOST_ALIKE
    found = np.nonzero((over >= least) | (under >= least))
    return found[0], found[1]
