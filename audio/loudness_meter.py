"""Loudness meter: integrated loudness and true peaks of a track.

Source: ITU-R BS.1770-5; the filters are pyloudnorm's.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.signal import lfilter

from audio.dsp import Signal
from audio.time_grid import SAMPLE_RATE

_BLOCK = int(0.4 * SAMPLE_RATE)
"""Samples of a block of the loudness gate."""

# Steps of a block, from one to the next; gates of blocks below, in LUFS and beside the mean [LU];
# loudness of a weighted power of 1.
_HOPS, _LEAST, _RELATIVE_GATE, _OFFSET = 4, -70.0, -10.0, -0.691

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
    hops = max(round((stereo.shape[0] / _BLOCK - 1) * _HOPS), 0) + _HOPS
    samples = hops * _BLOCK // _HOPS
    energy = np.zeros(hops)
    for side in stereo.T:
        heard = np.zeros(samples)
        heard[: side.size] = lfilter(*_weighting(), side[:samples])
        steps = heard.reshape(hops, -1)
        energy += np.einsum("ij,ij->i", steps, steps)
    power = np.convolve(energy, np.ones(_HOPS), "valid") / _BLOCK
    power = power[power > _power(_LEAST)]
    if not power.size:
        return -np.inf
    power = power[power > power.mean() * 10 ** (_RELATIVE_GATE / 10)]
    return float(_OFFSET + 10 * np.log10(power.mean()))


def _power(lufs: float) -> float:
    """Return the weighted power of a loudness."""
    return float(10 ** ((lufs - _OFFSET) / 10))


@cache
def _weighting() -> tuple[Signal, Signal]:
    """Return numerator and denominator of the K-weighting, shelf and high-pass in one."""
    # Imported here because it brings scipy, which no other sound needs.
    from pyloudnorm.iirfilter import IIRfilter

    shelf = IIRfilter(4.0, 1 / np.sqrt(2), 1500.0, SAMPLE_RATE, "high_shelf")
    low_cut = IIRfilter(0.0, 0.5, 38.0, SAMPLE_RATE, "high_pass")
    return np.convolve(shelf.b, low_cut.b), np.convolve(shelf.a, low_cut.a)


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
