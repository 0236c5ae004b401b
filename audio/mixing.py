"""Many sounds into one of two sides, below the ceiling."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from audio.banks import Signal

# The loudest sample ever written is 0.885, -1.06 dBFS; below 0.6 nothing is bent.
_CEILING = 0.885
_KNEE = 0.6
# Gain falls within 4 ms ahead of a crash and comes back within 60 ms.
_BLOCK = 48
_AHEAD, _RELEASE = 4, 60


def sides(pan: float) -> tuple[float, float]:
    """Return the gains of left and right for a pan of -1 to 1; their squares add to 1."""
    angle = (pan + 1) * pi / 4
    # cos(π/2) is 6e-17, which would keep the far side from being silent.
    return max(cos(angle), 0.0) * (pan < 1), max(sin(angle), 0.0) * (pan > -1)


def add(stereo: Signal, start: int, sound: Signal, gains: tuple[float, float]) -> None:
    """Add a sound at a sample; what reaches past the end is cut.

    Args:
        stereo: (N, 2), changed.
        start: sample of the onset.
        sound: (M,).
        gains: of left and right.
    """
    part = sound[: max(stereo.shape[0] - start, 0)]
    for side, gain in enumerate(gains):
        if gain:
            stereo[start : start + part.size, side] += gain * part


def limited(stereo: Signal) -> tuple[Signal, float]:
    """Return the mix below its ceiling, and the most that its loudest place was lowered [dB].

    First a slow gain common to both sides, then a soft knee that nothing passes. Silence stays
    silence, and what is below the knee far from any crash is not touched at all.

    Args:
        stereo: (N, 2).
    """
    peaks = np.abs(stereo).max(axis=1)
    if peaks.max(initial=0.0) <= _KNEE:
        return stereo, 0.0
    gain = _slow_gain(peaks)
    out = stereo * gain[:, None]
    over = np.abs(out) > _KNEE
    room = _CEILING - _KNEE
    bent = _KNEE + room * np.tanh((np.abs(out[over]) - _KNEE) / room)
    out[over] = np.copysign(bent, out[over])
    return out, float(-20 * np.log10(gain.min()))


def _slow_gain(peaks: Signal) -> Signal:
    """Return a gain under which peaks stay near the ceiling: (N,)."""
    blocks = -(-peaks.size // _BLOCK)
    padded = np.zeros(blocks * _BLOCK)
    padded[: peaks.size] = peaks
    wanted = np.minimum(
        1.0, _CEILING / np.maximum(padded.reshape(blocks, _BLOCK).max(axis=1), 1e-9)
    )
    # The window of the minimum is wider than that of the mean, so the mean reaches it in time.
    wide = np.pad(wanted, (_RELEASE, 2 * _AHEAD), constant_values=1.0)
    least = sliding_window_view(wide, _RELEASE + 2 * _AHEAD + 1).min(axis=1)
    smooth = np.pad(least, (_AHEAD, _AHEAD), mode="edge")
    mean = sliding_window_view(smooth, 2 * _AHEAD + 1).mean(axis=1)
    centres = (np.arange(blocks) + 0.5) * _BLOCK
    return np.asarray(np.interp(np.arange(peaks.size), centres, mean))


def faded(stereo: Signal, samples: int) -> None:
    """Let the last samples of a mix fall to silence, so that the cut at its end does not click."""
    fade = min(samples, stereo.shape[0])
    stereo[stereo.shape[0] - fade :] *= (np.cos(0.5 * np.pi * (np.arange(fade) + 1) / fade) ** 2)[
        :, None
    ]
