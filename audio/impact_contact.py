"""Contact of an impact: how long two bodies touch, and the spectrum of the force.

Source: Hertz 1881; Johnson 1985, 11.4, for the duration of an elastic impact.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from audio.acoustic_materials import Solid
from audio.dsp import Signal
from audio.time_grid import SAMPLE_RATE

# The onset of a sound is on its frame: the force itself lasts under a millisecond, and a longer
# contact weakens what is higher.
_MAX_CONTACT = 44 / SAMPLE_RATE
# Bounds of durations [s].
_SHORTEST, _LONGEST = 1e-6, 0.05


def contact_seconds(solids: tuple[Solid, Solid], radius: float, mass: float, speed: float) -> float:
    """Return the duration of an impact, 2.87 (m² / (R E*² v))^(1/5) [s].

    Args:
        solids: materials of both bodies.
        radius: relative radius of curvature R of the two surfaces [m].
        mass: reduced mass m of the two [kg].
        speed: of the approach v [m/s].
    """
    compliance = sum((1 - solid.poisson**2) / solid.young for solid in solids)
    seconds = 2.87 * (mass**2 * compliance**2 / (radius * speed)) ** 0.2
    return min(max(seconds, _SHORTEST), _LONGEST)


@lru_cache(maxsize=128)
def force_pulse(seconds: float) -> Signal:
    """Return a half-sine force of unit impulse, its mean over each sample: (N,)."""
    length = max(min(seconds, _MAX_CONTACT) * SAMPLE_RATE, 1.0)
    edges = np.minimum(np.arange(int(np.ceil(length)) + 1) / length, 1.0)
    force = np.asarray(-0.5 * np.diff(np.cos(np.pi * edges)))
    force.setflags(write=False)
    return force


@lru_cache(maxsize=128)
def force_matrix(seconds: float) -> Signal:
    """Return the matrix that convolves K samples with a force pulse of K samples: (K, K)."""
    force = force_pulse(seconds)
    matrix = np.zeros((force.size, force.size))
    for k in range(force.size):
        matrix[k, k:] = force[: force.size - k]
    matrix.setflags(write=False)
    return matrix


def contact_attenuation(frequency: Signal, seconds: float) -> Signal:
    """Return what the part of a contact beyond the longest force pulse leaves of modes: (M,).

    Args:
        frequency: (M,) of the modes [Hz].
        seconds: of the whole contact.
    """
    if seconds <= _MAX_CONTACT:
        return np.ones_like(frequency)
    return _envelope(frequency * seconds) / _envelope(frequency * _MAX_CONTACT)


def _envelope(cycles: Signal) -> Signal:
    """Return the spectrum of a half sine without its zeros, by cycles of the mode it lasts."""
    return np.asarray(1 / np.sqrt(1 + (2 * cycles) ** 4))
