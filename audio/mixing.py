"""Many sounds into one of two sides."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from audio.banks import Signal


def sides(pan: float) -> tuple[float, float]:
    """Return the gains of left and right for a pan of -1 to 1; their squares add to 1."""
    angle = (pan + 1) * pi / 4
    # cos(π/2) is 6e-17, which would keep the far side from being silent.
    return max(cos(angle), 0.0) * (pan < 1), max(sin(angle), 0.0) * (pan > -1)


Gain = float | Signal


def add(stereo: Signal, start: int, sound: Signal, gains: tuple[Gain, Gain]) -> None:
    """Add a sound at a sample; what reaches past the end is cut.

    Args:
        stereo: (N, 2), changed.
        start: sample of the onset.
        sound: (M,).
        gains: of left and right; (M,) where they change on the way.
    """
    size = min(max(stereo.shape[0] - start, 0), sound.size)
    for side, gain in enumerate(gains):
        if isinstance(gain, np.ndarray):
            stereo[start : start + size, side] += gain[:size] * sound[:size]
        elif gain:
            stereo[start : start + size, side] += gain * sound[:size]


def faded(stereo: Signal, samples: int) -> None:
    """Let the last samples of a mix fall to silence, so that the cut at its end does not click."""
    fade = min(samples, stereo.shape[0])
    stereo[stereo.shape[0] - fade :] *= (np.cos(0.5 * np.pi * (np.arange(fade) + 1) / fade) ** 2)[
        :, None
    ]
