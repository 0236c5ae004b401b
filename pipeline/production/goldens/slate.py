"""Slate: a picture that carries its frame number through an encoder."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

_BITS: Final = 20
"""Bits of the frame numbers of the longest film."""

_WIDTH: Final = 8
"""Of a stripe, wide enough for any encoder [pixels]."""

_HEIGHT: Final = 32


def slate(number: int) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3) whose stripes are the bits of a frame number, the lowest first."""
    bits = (number >> np.arange(_BITS)) & 1
    row = np.repeat(bits * 255, _WIDTH).astype(np.uint8)
    return np.broadcast_to(row[None, :, None], (_HEIGHT, row.size, 3)).copy()


def slate_number(grey: NDArray[Any]) -> int:
    """Return the frame number of a decoded slate (H, W)."""
    bits = grey.reshape(len(grey), _BITS, _WIDTH).mean(axis=(0, 2)) > 128
    return int((bits * (1 << np.arange(_BITS))).sum())
