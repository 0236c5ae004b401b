"""Palette: from how visible a difference is to a colour, dark for none, bright for all."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

_STOPS: Final = (
    (0.0, (0, 0, 4)),
    (0.15, (42, 17, 92)),
    (0.35, (130, 36, 128)),
    (0.55, (213, 70, 107)),
    (0.75, (250, 137, 96)),
    (1.0, (252, 253, 191)),
)
"""Lightness rises evenly, so that the map can be read in grey as well."""


def painted(errors: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3) of errors (H, W) from 0 to 1."""
    at = [place for place, _ in _STOPS]
    channels = [np.interp(errors, at, [color[c] for _, color in _STOPS]) for c in range(3)]
    return np.stack(channels, axis=-1).round().astype(np.uint8)
