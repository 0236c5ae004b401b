"""Slates: pictures that say which frame they are, for films that nobody looks at."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

_BITS: Final = 20
"""As many as the longest film's frames need."""

_WIDTH: Final = 8
"""Of a stripe [pixels]: wide enough to outlast any encoder."""

_HEIGHT: Final = 32


def slate(number: int) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3) whose stripes are the bits of a number, the lowest first."""
    bits = (number >> np.arange(_BITS)) & 1
    row = np.repeat(bits * 255, _WIDTH).astype(np.uint8)
    return np.broadcast_to(row[None, :, None], (_HEIGHT, row.size, 3)).copy()


def number_on(grey: NDArray[Any]) -> int:
    """Return the number on a slate (H, W) as it was decoded."""
    bits = grey.reshape(len(grey), _BITS, _WIDTH).mean(axis=(0, 2)) > 128
    return int((bits * (1 << np.arange(_BITS))).sum())
