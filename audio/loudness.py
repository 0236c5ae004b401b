"""How loud a track is to the ear, and how high it reaches between its samples.

Source: ITU-R BS.1770-5.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from audio.banks import Signal
from audio.convolution import convolved
from audio.grid import SAMPLE_RATE

# The two filters at 48 kHz: a shelf for the head, a high-pass for what is not felt as loud.
_SHELF = (
    (1.53512485958697, -2.69169618940638, 1.19839281085285),
    (1.0, -1.69065929318241, 0.73248077421585),
)
_HIGH_PASS = ((1.0, -2.0, 1.0), (1.0, -1.99004745483398, 0.99007225036621))
# The slower pole has fallen to e^-40 by then.
_RINGING = 8192
_HOP = SAMPLE_RATE // 10
_HOPS_A_BLOCK = 4
_ABSOLUTE_GATE, _RELATIVE_GATE = -70.0, -10.0
_OFFSET = -0.691
_PHASES, _REACH = 4, 24
_CHUNK = 1 << 14


def integrated(stereo: Signal) -> float:
    """Return the integrated loudness of a track [LUFS]; -inf for one that no gate lets through.

    Only whole blocks of 400 ms count. Where none is loud enough, a track is taken to be followed
    by silence: of a very short film or a blow on its last frame, that is heard, too.

    Args:
        stereo: (N, 2).
    """
    energy = _energy(stereo)
    loud = _gated(energy[: max(stereo.shape[0] // _HOP, _HOPS_A_BLOCK)])
    return loud if np.isfinite(loud) else _gated(energy)


def _energy(stereo: Signal) -> Signal:
    """Return the weighted energy of every tenth of a second, the last one filled up: (H,)."""
    hops = max(-(-stereo.shape[0] // _HOP), _HOPS_A_BLOCK)
    energy = np.zeros(hops)
    for side in stereo.T:
        weighted = np.zeros(hops * _HOP)
        weighted[: side.size] = convolved(side, _k_weighting())
        energy += (weighted.reshape(hops, _HOP) ** 2).sum(axis=1)
    return energy


def _gated(energy: Signal) -> float:
    """Return the loudness of the blocks that pass both gates [LUFS]."""
    summed = np.concatenate(([0.0], np.cumsum(energy)))
    blocks = (summed[_HOPS_A_BLOCK:] - summed[:-_HOPS_A_BLOCK]) / (_HOPS_A_BLOCK * _HOP)
    blocks = blocks[blocks > _power(_ABSOLUTE_GATE)]
    if blocks.size == 0:
        return -np.inf
    gate = float(blocks.mean()) * 10 ** (_RELATIVE_GATE / 10)
    return float(_OFFSET + 10 * np.log10(blocks[blocks > gate].mean()))


def _power(lufs: float) -> float:
    return float(10 ** ((lufs - _OFFSET) / 10))


@cache
def _k_weighting() -> Signal:
    """Return the response of both filters to one sample: (K,)."""
    # On a circle four times as long what wraps around is nothing.
    z = np.exp(-2j * np.pi * np.arange(2 * _RINGING + 1) / (4 * _RINGING))
    response = np.ones_like(z)
    for above, below in (_SHELF, _HIGH_PASS):
        response *= np.polyval(above[::-1], z) / np.polyval(below[::-1], z)
    whole: Signal = np.fft.irfft(response)[:_RINGING]
    return whole


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
