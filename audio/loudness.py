"""How loud a track is to the ear, and how high it reaches between its samples.

Loudness is measured by pyloudnorm, the meter of this field.

Source: ITU-R BS.1770-5.
"""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np

from audio.banks import Signal
from audio.grid import SAMPLE_RATE

_LEAST = int(0.4 * SAMPLE_RATE)
"""Samples of one block; a meter has no word on less."""

_PHASES, _REACH = 4, 24
_CHUNK = 1 << 14


def integrated(stereo: Signal) -> float:
    """Return the integrated loudness of a track [LUFS]; -inf for one that no gate lets through.

    Only whole blocks of 400 ms count. Where none is loud enough, a track is taken to be followed
    by silence: of a very short film or a blow on its last frame, that is heard, too.

    Args:
        stereo: (N, 2).
    """
    if stereo.shape[0] >= _LEAST and np.isfinite(loud := _metered(stereo)):
        return loud
    return _metered(np.concatenate((stereo, np.zeros((_LEAST, 2)))))


def _metered(stereo: Signal) -> float:
    # Imported here because it brings scipy, which no other sound needs.
    from pyloudnorm import Meter

    with np.errstate(divide="ignore", invalid="ignore"), warnings.catch_warnings():
        # It takes logarithms and means of silence on its way to the gates.
        warnings.simplefilter("ignore", RuntimeWarning)
        loud = float(Meter(SAMPLE_RATE).integrated_loudness(stereo))
    return loud if np.isfinite(loud) else -np.inf


def true_peak(stereo: Signal) -> float:
    """Return the largest magnitude of a track between its samples, too."""
    top = float(np.abs(stereo).max(initial=0.0))
    # Between samples a track seldom reaches twice as high; where all is soft none is higher.
    return float(true_peaks(stereo, 0.5 * top).max(initial=0.0)) if top > 0 else 0.0


def true_peaks(stereo: Signal, above: float) -> Signal:
    """Return the larger magnitude of both sides about each sample, between samples too: (N,).

    Four times oversampled where the samples themselves pass a level; elsewhere theirs.

    Args:
        stereo: (N, 2).
        above: the level.
    """
    peaks: Signal = np.abs(stereo).max(axis=1)
    for start in range(0, peaks.size, _CHUNK):
        here = slice(start, min(start + _CHUNK, peaks.size))
        if peaks[here].max() <= above:
            continue
        for side in stereo.T:
            _raise_between(peaks, side, here)
    return peaks


def _raise_between(peaks: Signal, side: Signal, here: slice) -> None:
    """Raise peaks to what a side reaches between each sample and the next."""
    first, last = here.start - _REACH + 1, here.stop + _REACH
    around = np.zeros(last - first)
    inside = side[max(first, 0) : last]
    around[max(-first, 0) : max(-first, 0) + inside.size] = inside
    for taps in _interpolators():
        between = np.abs(np.convolve(around, taps, "valid"))
        np.maximum(peaks[here], between, out=peaks[here])


@cache
def _interpolators() -> tuple[Signal, ...]:
    """Return filters that give a track 1/4, 2/4 and 3/4 of a sample later: (2 REACH,) each."""
    taps = []
    for phase in range(1, _PHASES):
        x = np.arange(-_REACH + 1, _REACH + 1) - phase / _PHASES
        window = np.i0(9.0 * np.sqrt(np.maximum(1 - (x / _REACH) ** 2, 0))) / np.i0(9.0)
        sinc = np.sinc(x) * window
        taps.append(sinc[::-1] / sinc.sum())
    return tuple(taps)
