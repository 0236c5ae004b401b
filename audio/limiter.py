"""The limiter: a gain that falls ahead of what is too loud and comes back after it."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from audio.banks import Signal
from audio.grid import SAMPLE_RATE
from audio.loudness import true_peaks

_BLOCK = 48
# Gain falls within 2 ms ahead of a crash, stays for 4 ms and comes back by 300 dB a second: soon
# enough to leave the ring of what it caught.
_AHEAD, _HOLD = 2, 4
_RISE = 10 ** (300.0 / 20 * _BLOCK / SAMPLE_RATE)


def limited(stereo: Signal, ceiling: float) -> tuple[Signal, float]:
    """Return the mix below its ceiling, and the most that its loudest place was lowered [dB].

    One gain for both sides, and no wave is bent: silence stays silence, every onset its sample,
    and what is far from anything too loud is not touched at all.

    Args:
        stereo: (N, 2).
        ceiling: which no peak passes, between samples neither.
    """
    peaks = true_peaks(stereo, 0.5 * ceiling)
    if peaks.max(initial=0.0) <= ceiling:
        return stereo, 0.0
    gain = _gain(peaks, ceiling)
    return stereo * gain[:, None], float(-20 * np.log10(gain.min()))


def _gain(peaks: Signal, ceiling: float) -> Signal:
    """Return a gain under which peaks stay below the ceiling: (N,)."""
    blocks = -(-peaks.size // _BLOCK)
    padded = np.zeros(blocks * _BLOCK)
    padded[: peaks.size] = peaks
    wanted = ceiling / np.maximum(padded.reshape(blocks, _BLOCK).max(axis=1), ceiling)
    # The window of the minimum is wider than that of the mean, so the mean reaches it in time.
    wide = np.pad(wanted, (_HOLD, 2 * _AHEAD), constant_values=1.0)
    least = sliding_window_view(wide, _HOLD + 2 * _AHEAD + 1).min(axis=1)
    smooth = np.pad(_rising(least), (_AHEAD, _AHEAD), mode="edge")
    mean = sliding_window_view(smooth, 2 * _AHEAD + 1).mean(axis=1)
    centres = (np.arange(blocks) + 0.5) * _BLOCK
    return np.asarray(np.interp(np.arange(peaks.size), centres, mean))


def _rising(least: Signal) -> Signal:
    """Return a gain that falls at once where it must, and rises no faster than it may: (B,)."""
    gain, out = 1.0, least.tolist()
    for block, most in enumerate(out):
        gain = min(most, gain * _RISE)
        out[block] = gain
    return np.array(out)
