"""Motion: the input of a motion's synthesis, and the curves and tones that all of them use."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from audio.dsp import Signal
from audio.source_motion import SpeedProfile
from audio.time_grid import SAMPLE_RATE

MAX_FREQUENCY = 12_000.0
"""Greatest frequency of a tone [Hz]."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Input of a motion's synthesis.

    Attributes:
        profile: speed over time.
        pitch: at the greatest speed [Hz].
        speed: the greatest [m/s].
    """

    profile: SpeedProfile
    pitch: float
    speed: float


def arch(samples: int, peak: float) -> Signal:
    """Return an envelope that rises from its first sample to 1 and falls to 0: (samples,).

    Args:
        samples: length.
        peak: position of the maximum, 0 to 1.
    """
    x = (np.arange(samples) + 1.0) / (samples + 1.0)
    ramps = np.where(x < peak, x / peak, (1 - x) / (1 - peak))
    return np.asarray(np.sin(0.5 * np.pi * ramps) ** 2)


def tone(frequency: Signal, partials: tuple[float, ...]) -> Signal:
    """Return harmonics that start as rising sines: (N,).

    Args:
        frequency: (N,) of the fundamental [Hz].
        partials: amplitudes of the harmonics, from the fundamental up.
    """
    phase = 2 * np.pi * np.cumsum(frequency) / SAMPLE_RATE
    # Chebyshev's recurrence, because sines take five times as long.
    twice, before, harmonic = 2 * np.cos(phase), np.zeros_like(phase), np.sin(phase)
    whole = partials[0] * harmonic
    for amplitude in partials[1:]:
        before, harmonic = harmonic, twice * harmonic - before
        whole += amplitude * harmonic
    return np.asarray(whole)


def drift(samples: int, depth: float, rng: np.random.Generator) -> Signal:
    """Return a slow random variation around 1: (samples,)."""
    knots = 1 + depth * rng.uniform(-1, 1, 8)
    return np.interp(np.linspace(0, 7, samples), np.arange(8), knots)
