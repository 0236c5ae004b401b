"""PSNR: the ratio of the largest possible signal to the difference of two pictures."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def psnr(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> float:
    """Return the PSNR of two 8-bit pictures of one size [dB], infinite where they are equal."""
    apart = reference.astype(np.float64) - test.astype(np.float64)
    error = float(np.mean(apart**2))
    return 10.0 * math.log10(255.0**2 / error) if error else math.inf
