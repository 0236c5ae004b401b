"""Shadow smoothing: the shadows of one lamp without the noise of few samples.

What a lamp would give a pixel without shadows has no noise. What it gives, divided by that, is the
share of the lamp that the pixel sees, whose noise is that of the samples that met a shadow. So this
share alone is the mean of neighbouring pixels, weighted by the light that they would have, and the
light without shadows, with all relief and gloss, stays sharp.

Source: Heitz, Hill and McGuire 2018, Combining Analytic Direct Illumination and Stochastic
Shadows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from render.color import LUMINANCE

Image = NDArray[np.float32]

BAND_ROWS = 64
"""Rows that are smoothed together, so that they stay in the cache."""

DARKEST = 1e-6
"""Light below which a pixel has no shadow to see."""


def smooth_shadows(direct: Image, open_light: Image) -> Image:
    """Return direct light with smooth shadows, (H, W, 3).

    Args:
        direct: (H, W, 3) linear.
        open_light: the same without shadows.
    """
    found = np.empty_like(open_light)
    height = len(open_light)
    for top in range(0, height, BAND_ROWS):
        end = min(top + BAND_ROWS, height)
        # One row more on each side, which is the same again at the border.
        rows = np.arange(top - 1, end + 1).clip(0, height - 1)
        lit, whole = (_tent(_grey(image[rows])) for image in (direct, open_light))
        share = np.divide(lit, whole, out=np.zeros_like(lit), where=whole > DARKEST)
        np.multiply(open_light[top:end], share[..., None], out=found[top:end])
    return found


def _grey(light: Image) -> Image:
    """Return the luminance of an image, (H, W)."""
    r, g, b = (np.float32(weight) for weight in LUMINANCE)
    return np.asarray(r * light[..., 0] + g * light[..., 1] + b * light[..., 2], np.float32)


def _tent(grey: Image) -> Image:
    """Return an image (H, W) filtered by 1, 2, 1 both ways, without its first and last row."""
    rows = grey[:-2] + np.float32(2.0) * grey[1:-1] + grey[2:]
    wide = np.pad(rows, ((0, 0), (1, 1)), mode="edge")
    return wide[:, :-2] + np.float32(2.0) * wide[:, 1:-1] + wide[:, 2:]
