"""Limiter: a gain that keeps peaks below a ceiling, without a step and without delay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from audio.dsp import Signal
from audio.time_grid import SAMPLE_RATE


@dataclass(frozen=True, slots=True)
class _Limiter:
    """Envelope of the limiter's gain, in blocks of a millisecond.

    Attributes:
        block: samples per step of the gain.
        lookahead: blocks within which the gain falls ahead of a peak.
        hold: blocks for which it stays.
        release_db: recovery [dB/s], soon enough to leave the ring after the peak.
    """

    block: int = 48
    lookahead: int = 2
    hold: int = 4
    release_db: float = 300.0

    @property
    def release(self) -> float:
        """Factor by which the gain recovers from block to block."""
        return float(10 ** (self.release_db / 20 * self.block / SAMPLE_RATE))


_LIMITER = _Limiter()


def limiter_gain(peaks: Signal, ceiling: float) -> Signal:
    """Return a gain that keeps peaks (N,) below a ceiling: (N,).

    It falls within 2 ms ahead of a peak, holds, and recovers.
    """
    blocks = -(-peaks.size // _LIMITER.block)
    padded = np.zeros(blocks * _LIMITER.block)
    padded[: peaks.size] = peaks
    needed = ceiling / np.maximum(padded.reshape(blocks, _LIMITER.block).max(axis=1), ceiling)
    # The window of the minimum is wider than that of the mean, so the mean reaches it in time.
    wide = np.pad(needed, (_LIMITER.hold, 2 * _LIMITER.lookahead), constant_values=1.0)
    lowest = sliding_window_view(wide, _LIMITER.hold + 2 * _LIMITER.lookahead + 1).min(axis=1)
    smooth = np.pad(_with_release(lowest), (_LIMITER.lookahead, _LIMITER.lookahead), mode="edge")
    mean = sliding_window_view(smooth, 2 * _LIMITER.lookahead + 1).mean(axis=1)
    centers = (np.arange(blocks) + 0.5) * _LIMITER.block
    return np.asarray(np.interp(np.arange(peaks.size), centers, mean))


def _with_release(needed: Signal) -> Signal:
    """Return a gain that falls at once and recovers at the release rate: (B,)."""
    gain, out, release = 1.0, needed.tolist(), _LIMITER.release
    for block, most in enumerate(out):
        gain = min(most, gain * release)
        out[block] = gain
    return np.array(out)
