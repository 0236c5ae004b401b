"""Shadow fill: shade is exposed more than what lies in the sun, as photographers dodge a print.

The contrast that brings the brightest parts of a picture near white leaves shade too dark, and so
does a bright sky behind what is in its own shade. So the exposure of wide dark areas is raised.
Their detail keeps its contrast, because the exposure follows the light smoothed by a guided
filter, which stops at edges.

Source: K. He, J. Sun and X. Tang, Guided Image Filtering, IEEE Transactions on Pattern Analysis and
Machine Intelligence 35(6), 2013, with the image as its own guide; as a base layer for tone mapping
as in F. Durand and J. Dorsey, Fast Bilateral Filtering for the Display of High-Dynamic-Range
Images, SIGGRAPH 2002.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from render.box_filter import box_mean
from render.color import luminance

Image = NDArray[np.float32]

_FULL_CONTRAST = 0.8
"""Contrast that was added to a picture from which on shade is opened as far as the look says."""

_BACKLIT, _BACKLIT_LIGHT = 0.9, (1.4, 2.4)
"""Share of that by which shade is opened before a bright sky, without any contrast that was added;
light of the brightest tenth of the picture from which on that begins, and is full [stops over
middle grey]. A night has no such sky and stays dark."""

_PIVOT = -0.7
"""Light below which shade begins [stops over middle grey]."""

_KNEE = 1.0
"""Stops below the pivot over which the fill grows to its share."""

_MOST = 1.6
"""Most that is added to the exposure [stops]."""

_EDGE = 0.6
"""Variance of light above which the filter takes it for an edge [stops squared]."""

_WIDTHS = 20
"""Width of the picture, in radii of the filter."""

_DARKEST, _BRIGHTEST = -7.0, 5.0
"""Range of light that is told apart [stops over middle grey]."""


def fill_stops(small: Image, stops: float, contrast: float, share: float) -> Image:
    """Return the exposure that is added to each pixel of a small picture (H, W, 1) [stops].

    Args:
        small: (H, W, 3) scene light, some pixels of the full picture wide.
        stops: of exposure of the whole picture.
        contrast: that was added to the picture.
        share: of the difference to the pivot, 0 to 1.
    """
    light = np.log2(np.maximum(luminance(small), 1e-5) / np.float32(0.18)) + np.float32(stops)
    low, high = _BACKLIT_LIGHT
    sky = float(np.clip((np.percentile(light, 90.0) - low) / (high - low), 0.0, 1.0))
    added = min(max((contrast - 1.0) / _FULL_CONTRAST, 0.0), 1.0)
    strength = share * max(added, _BACKLIT * sky)
    wide = _smoothed(np.clip(light, _DARKEST, _BRIGHTEST), max(small.shape[1] // _WIDTHS, 2))
    below = np.maximum(_PIVOT - wide, 0.0)
    fill = np.minimum(strength * below * below / (below + _KNEE), _MOST)
    return np.asarray(fill[..., None], np.float32)


def _smoothed(image: NDArray[np.floating], radius: int) -> NDArray[np.float64]:
    """Return an image (H, W) smoothed but for its edges."""
    exact = np.asarray(image, np.float64)
    mean = box_mean(exact, radius)
    variance = np.maximum(box_mean(exact * exact, radius) - mean * mean, 0.0)
    kept = variance / (variance + _EDGE)
    return box_mean(kept, radius) * exact + box_mean(mean - kept * mean, radius)
