"""Bubbles: air that water closes over, each a short tone that rises.

Source: van den Doel 2005.
"""

from __future__ import annotations

import numpy as np

from audio.dsp import Signal
from audio.time_grid import SAMPLE_RATE

PITCHES = (420.0, 2100.0)
"""Lowest and highest pitch at the start [Hz]."""


def bubble(rng: np.random.Generator) -> Signal:
    """Return the tone of one bubble, of peak about 1: (N,)."""
    pitch = np.exp(rng.uniform(*np.log(PITCHES)))
    t = np.arange(round(0.06 * SAMPLE_RATE)) / SAMPLE_RATE
    phase = 2.0 * np.pi * pitch * (t + 1.7 * t**2)
    return np.asarray(np.sin(phase) * np.exp(-0.022 * pitch * t) * np.minimum(t / 0.002, 1.0))
