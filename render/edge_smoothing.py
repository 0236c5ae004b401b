"""Edge smoothing: edges of frames with few samples, drawn out along themselves.

Two samples of a pixel leave steps along each outline, which hair and leaves show most. Each pixel
of an edge becomes the mean of those along the edge, so that steps are smooth and what lies across
stays sharp. It works on compressed light, as bright as it is shown; the mean of light itself would
be that of the sky alone.

Source: Andreev 2011; Karis 2013, for the mean of compressed light.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from render.color import luminance

Image = NDArray[np.float32]

LEAST_SLOPE = 0.045
"""Slope of brightness, the root of compressed luminance, from which on pixels are an edge."""

TAPS = ((0.9, 0.85), (1.9, 0.45))
"""Distances along an edge at which a pixel takes from others, to both sides [pixels], and weights
in its own."""

BAND_ROWS = 128
"""Rows that are smoothed together, so that they stay in the cache."""


def smoothed_edges(light: Image, stops: float) -> Image:
    """Return light with smooth edges; all else stays as it is.

    Args:
        light: (H, W, 3) linear.
        stops: of exposure with which it is shown.
    """
    gain = np.float32(2.0**stops)
    exposed = np.maximum(light, np.float32(0.0)) * gain
    shown = exposed / (exposed + np.float32(1.0))
    grey = np.pad(np.sqrt(luminance(shown).astype(np.float32)), 1, mode="edge")
    found = light.copy()
    for top in range(0, len(light), BAND_ROWS):
        rows = grey[top : top + BAND_ROWS + 2]
        # Sobel's slopes, in those of one pixel.
        along_x = (rows[:-2] + 2.0 * rows[1:-1] + rows[2:]) * np.float32(0.125)
        along_y = (rows[:, :-2] + 2.0 * rows[:, 1:-1] + rows[:, 2:]) * np.float32(0.125)
        slope_x, slope_y = along_x[:, 2:] - along_x[:, :-2], along_y[2:] - along_y[:-2]
        steep = np.sqrt(slope_x * slope_x + slope_y * slope_y)
        y, x = np.nonzero(steep > LEAST_SLOPE)
        if not len(y):
            continue
        size = steep[y, x]
        way = -slope_y[y, x] / size, slope_x[y, x] / size
        mean = _mean_along(shown, y + top, x, way)
        found[y + top, x] = mean / (np.float32(1.0) - mean) / gain
    return found


def _mean_along(
    image: Image,
    y: NDArray[np.intp],
    x: NDArray[np.intp],
    way: tuple[NDArray[np.float32], NDArray[np.float32]],
) -> Image:
    """Return the means (n, 3) of an image along lines through pixels, to both sides."""
    total, weights = image[y, x], 1.0
    for distance, weight in TAPS:
        for sign in (distance, -distance):
            there = _between(image, y + np.float32(sign) * way[1], x + np.float32(sign) * way[0])
            total = total + np.float32(weight) * there
            weights += weight
    return np.asarray(total / np.float32(weights), np.float32)


def _between(image: Image, y: NDArray[np.floating], x: NDArray[np.floating]) -> Image:
    """Return the image (n, 3) at places between pixels, linear; the border goes on beyond it."""
    height, width = image.shape[:2]
    y, x = np.clip(y, 0.0, height - 1.0), np.clip(x, 0.0, width - 1.0)
    top, left = y.astype(np.int32), x.astype(np.int32)
    down = (y - top).astype(np.float32)[:, None]
    across = (x - left).astype(np.float32)[:, None]
    # One index for row and column: numpy takes rows of a table several times as fast.
    table = image.reshape(-1, image.shape[-1])
    here = (top * width + left).astype(np.intp)
    right = (left < width - 1).astype(np.intp)
    below = np.where(top < height - 1, width, 0).astype(np.intp)
    first = table.take(here, axis=0)
    first += across * (table.take(here + right, axis=0) - first)
    here += below
    second = table.take(here, axis=0)
    second += across * (table.take(here + right, axis=0) - second)
    second -= first
    second *= down
    second += first
    return second
