"""Contrast: what the eye sees of a picture from where it looks, by its contrast sensitivity.

Source: Andersson et al. 2020, section 4.1.1 and table 1.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from render.comparison.opponent import Plane
from render.comparison.sweep import swept

_SENSITIVITY: Final = (
    ((1.0, 0.0047),),
    ((1.0, 0.0053),),
    ((34.1, 0.04), (13.5, 0.025)),
)
"""Of luminance, red to green, blue to yellow: a and b of each Gaussian in its Fourier transform."""


def contrast_filtered(ycxcz: Plane, ppd: float) -> Plane:
    """Return a picture in YCxCz (H, W, 3) as it is seen at `ppd` pixels a degree."""
    widest = max(b for terms in _SENSITIVITY for _, b in terms)
    radius = math.ceil(3.0 * math.sqrt(widest / (2.0 * math.pi**2)) * ppd)
    degrees = np.arange(-radius, radius + 1) / ppd
    channels = []
    for i, terms in enumerate(_SENSITIVITY):
        weights, kernels = [], []
        for a, b in terms:
            kernel = np.exp(-(math.pi**2) * degrees**2 / b)
            # a·√(π/b) is of the transform in one dimension; the paper uses it in two as well.
            weights.append(a * math.sqrt(math.pi / b) * kernel.sum() ** 2)
            kernels.append(kernel / kernel.sum())
        whole = sum(weights)
        filtered = (
            weight / whole * swept(ycxcz[..., i], kernel, kernel)
            for weight, kernel in zip(weights, kernels, strict=True)
        )
        channels.append(np.asarray(sum(filtered)))
    return np.stack(channels, axis=-1)
