"""Features: edges and points that one picture has and another one lacks.

Source: Andersson et al. 2020, section 4.2.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from render.comparison.opponent import Plane
from render.comparison.sweep import swept

_WIDTH: Final = 0.082
"""Of an edge or a point that the eye detects [degrees]."""


def feature_difference(one: Plane, two: Plane, ppd: float) -> Plane:
    """Return how much the features of two luminances differ, (H, W) from 0 to 1.

    Args:
        one: (H, W) luminance of YCxCz.
        two: likewise.
        ppd: pixels a degree.
    """
    edges, points = zip(_features(one, ppd), _features(two, ppd), strict=True)
    apart = np.maximum(np.abs(edges[0] - edges[1]), np.abs(points[0] - points[1]))
    return np.asarray(apart / math.sqrt(2.0))


def _features(luminance: Plane, ppd: float) -> tuple[Plane, Plane]:
    """Return how much of an edge and how much of a point every pixel is, each (H, W)."""
    grey = (luminance + 16.0) / 116.0
    sigma = 0.5 * _WIDTH * ppd
    radius = math.ceil(3.0 * sigma)
    x = np.arange(-radius, radius + 1.0)
    bell = np.exp(-(x**2) / (2.0 * sigma**2))
    bell /= bell.sum()
    slope = _balanced(-x * bell)
    bump = _balanced((x**2 / sigma**2 - 1.0) * bell)
    edge, point = (
        np.hypot(swept(grey, kernel, bell), swept(grey, bell, kernel)) for kernel in (slope, bump)
    )
    return edge, point


def _balanced(kernel: Plane) -> Plane:
    """Return a kernel whose positive weights add up to one, and its negative ones to minus one."""
    above, below = kernel[kernel > 0].sum(), -kernel[kernel < 0].sum()
    return np.asarray(np.where(kernel > 0, kernel / above, kernel / below))
