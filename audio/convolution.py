"""Long sounds through filters, a block at a time."""

from __future__ import annotations

import numpy as np

from audio.banks import Signal

_SMALLEST = 1 << 14


def convolved(sound: Signal, response: Signal) -> Signal:
    """Return a sound after a filter, as long as the sound itself: (N,).

    Blocks of silence are left out, and so are exactly silent where nothing rings into them.

    Args:
        sound: (N,).
        response: (K,) of the filter to one sample of 1.
    """
    size = max(_SMALLEST, 1 << (4 * response.size - 1).bit_length())
    step = size - response.size + 1
    spectrum = np.fft.rfft(response, size)
    whole = np.zeros(sound.size + size)
    for start in range(0, sound.size, step):
        block = sound[start : start + step]
        if block.any():
            whole[start : start + size] += np.fft.irfft(np.fft.rfft(block, size) * spectrum, size)
    return whole[: sound.size]
