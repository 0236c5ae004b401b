"""Box filter: the mean over squares of pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def box_mean(image: NDArray[np.float64], radius: int) -> NDArray[np.float64]:
    """Return the mean of an image (H, W) over squares of `2 radius + 1` pixels; borders repeat."""
    side = 2 * radius + 1
    for axis in (0, 1):
        n = image.shape[axis]
        border = [(radius + 1, radius) if k == axis else (0, 0) for k in (0, 1)]
        sums = np.pad(image, border, "edge").cumsum(axis)
        image = (sums.take(range(side, side + n), axis) - sums.take(range(n), axis)) / side
    return image
