"""Loudness meter: integrated loudness and true peaks of a track.

Source: ITU-R BS.1770-5; loudness is measured by pyloudnorm.
"""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np

from audio.dsp import Signal
from audio.time_grid import SAMPLE_RATE

_BLOCK = int(0.4 * SAMPLE_RATE)
"""Samples of a block of the loudness gate."""

# Oversampling, and half the taps of its interpolators.
_PHASES, _HALF_TAPS = 4, 24
_KAISER_BETA = 9.0
_CHUNK = 1 << 10


def integrated_loudness(stereo: Signal) -> float:
    """Return the integrated loudness of a track [LUFS]; -inf for silence.

    Only whole blocks of 400 ms count. If none passes the gate, the track is measured with silence
    after it: that covers very short films, and impacts on the last frame.

    Args:
        stereo: (N, 2).
    """
    if stereo.shape[0] >= _BLOCK and np.isfinite(loudness := _gated_loudness(stereo)):
        return loudness
    return _gated_loudness(np.concatenate((stereo, np.zeros((_BLOCK, 2)))))


def _gated_loudness(stereo: Signal) -> float:
    # Imported here because it brings scipy, which no other sound needs.
    from pyloudnorm import Meter

    with np.errstate(divide="ignore", invalid="ignore"), warnings.catch_warnings():
        # pyloudnorm takes logarithms and means of silence.
        warnings.simplefilter("ignore", RuntimeWarning)
        loudness = float(Meter(SAMPLE_RATE).integrated_loudness(stereo))
    return loudness if np.isfinite(loudness) else -np.inf


def true_peak(stereo: Signal) -> float:
    """Return the largest magnitude of a track, between samples too."""
    top = float(np.abs(stereo).max(initial=0.0))
    # Between samples a track seldom reaches twice as high.
    return float(true_peaks(stereo, 0.5 * top).max(initial=0.0)) if top > 0 else 0.0


def true_peaks(stereo: Signal, threshold: float) -> Signal:
    """Return the larger magnitude of both sides around each sample, between samples too: (N,).

    Four times oversampled where samples exceed a threshold; elsewhere the samples themselves.

    Args:
        stereo: (N, 2).
        threshold: magnitude.
    """
    peaks: Signal = np.abs(stereo).max(axis=1)
    for start in range(0, peaks.size, _CHUNK):
        chunk = slice(start, min(start + _CHUNK, peaks.size))
        if peaks[chunk].max() <= threshold:
            continue
        for side in stereo.T:
            _raise_to_oversampled(peaks, side, chunk)
    return peaks


def _raise_to_oversampled(peaks: Signal, side: Signal, chunk: slice) -> None:
    first, last = chunk.start - _HALF_TAPS + 1, chunk.stop + _HALF_TAPS
    padded = np.zeros(last - first)
    inside = side[max(first, 0) : last]
    padded[max(-first, 0) : max(-first, 0) + inside.size] = inside
    for taps in _interpolators():
        between = np.abs(np.convolve(padded, taps, "valid"))
        np.maximum(peaks[chunk], between, out=peaks[chunk])


@cache
def _interpolators() -> tuple[Signal, ...]:
    """Return the windowed sincs that delay by 1/4, 2/4 and 3/4 of a sample: (48,) each."""
    taps = []
    for phase in range(1, _PHASES):
        x = np.arange(-_HALF_TAPS + 1, _HALF_TAPS + 1) - phase / _PHASES
        kaiser = np.i0(_KAISER_BETA * np.sqrt(np.maximum(1 - (x / _HALF_TAPS) ** 2, 0)))
        window = kaiser / np.i0(_KAISER_BETA)
        sinc = np.sinc(x) * window
        taps.append(sinc[::-1] / sinc.sum())
    return tuple(taps)
