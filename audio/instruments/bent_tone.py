"""Bent tone: a tone whose pitch slides, as the same tone read at a varying rate."""

from __future__ import annotations

import numpy as np

from audio.dsp import Signal, resample
from audio.time_grid import SAMPLE_RATE

BendInTime = tuple[tuple[float, float], ...]
"""(time after the onset [s], semitones), with lines between; empty for none."""


def _rate(bend: BendInTime, seconds: Signal) -> Signal:
    """Return the rate at which the tone is read at times (N,): (N,)."""
    times, semitones = zip(*bend, strict=True)
    return np.asarray(2.0 ** (np.interp(seconds, times, semitones) / 12))


def read_seconds(bend: BendInTime, seconds: float) -> float:
    """Return for how long a tone has to be held that is read for a time [s]."""
    if not bend:
        return seconds
    times = (np.arange(1000) + 0.5) / 1000 * seconds
    return float(_rate(bend, times).mean() * seconds)


def bent(tone: Signal, bend: BendInTime) -> Signal:
    """Return a tone that slides, from its onset on and as long as it has samples: (M,).

    Args:
        tone: (N,), which may be nobody's to change.
        bend: of its pitch.
    """
    if not bend:
        return tone
    least = 2.0 ** (min(semitones for _, semitones in bend) / 12)
    rate = _rate(bend, np.arange(int(tone.size / least) + 1) / SAMPLE_RATE)
    samples = int(np.searchsorted(np.cumsum(rate), tone.size - 1))
    return resample(tone, rate[:samples])
