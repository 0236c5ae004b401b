"""Resizing: images of half and twice the size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]


def double_size(image: Image) -> Image:
    """Return an image (H, W, 3) of twice the size, linear between the centres of pixels."""
    return _doubled(_doubled(image, 0), 1)


def half_size(image: Image) -> Image:
    """Return an image (H, W, ...) of half the size, rounded up: means of two by two pixels."""
    height, width = image.shape[:2]
    if height % 2 or width % 2:
        rest = [(0, 0)] * (image.ndim - 2)
        image = np.pad(image, [(0, height % 2), (0, width % 2), *rest], "edge")
    rows = image[0::2] + image[1::2]
    return np.asarray(0.25 * (rows[:, 0::2] + rows[:, 1::2]), np.float32)


def _doubled(image: Image, axis: int) -> Image:
    """Return an image twice as long along an axis, linear between the centres of pixels."""
    near, n = image, image.shape[axis]
    before = near.take([0, *range(n - 1)], axis)
    after = near.take([*range(1, n), n - 1], axis)
    # In the order of rows, for what reads it next.
    twice = np.empty((*near.shape[:axis], n, 2, *near.shape[axis + 1 :]), np.float32)
    for k, beside in enumerate((before, after)):
        beside -= near
        beside *= np.float32(0.25)
        np.add(near, beside, out=twice[(slice(None),) * (axis + 1) + (k,)])
    return twice.reshape(*near.shape[:axis], 2 * n, *near.shape[axis + 1 :])
