"""Noise of loose and soft ground: grains that shift under a blow and settle.

Many small collisions at random times, fewer and softer as energy is spent.
Source: Cook 1997 (PhISM).
"""

from __future__ import annotations

import numpy as np

from audio.banks import Signal
from audio.grid import SAMPLE_RATE

_SILENT = float(np.log(1000.0))


def band_noise(samples: int, band: tuple[float, float], rng: np.random.Generator) -> Signal:
    """Return stationary noise between two frequencies with soft shoulders, RMS 1: (samples,).

    Args:
        samples: how many, at least one.
        band: lower and upper edge [Hz].
        rng: of the noise.
    """
    # A power of two above, since FFTs of prime lengths are slow.
    size = 1 << max(int(samples - 1).bit_length(), 6)
    spectrum = np.fft.rfft(rng.standard_normal(size))
    f = np.fft.rfftfreq(size, 1 / SAMPLE_RATE)
    low, high = band
    # Two Butterworth-like shoulders; exactly zero at 0 Hz.
    shape = (f / low) ** 2 / np.sqrt(1 + (f / low) ** 4) / np.sqrt(1 + (f / high) ** 6)
    noise = np.fft.irfft(spectrum * shape, size)[:samples]
    return np.asarray(noise / max(float(np.sqrt(np.mean(noise**2))), 1e-12))


def settling(
    band: tuple[float, float], settle: float, grains: float, rng: np.random.Generator
) -> Signal:
    """Return the noise of a blow on loose ground, full from its first sample: (N,).

    Args:
        band: of the grains [Hz].
        settle: time to fall by 60 dB [s].
        grains: a second, at the start; 0 for a smooth rustle.
        rng: of grains and noise.
    """
    samples = max(int(settle * SAMPLE_RATE), 64)
    t = np.arange(samples) / SAMPLE_RATE
    fall = np.exp(-_SILENT * t / settle)
    noise = band_noise(samples, band, rng)
    # The crunch of the blow itself, then the grains.
    envelope = np.exp(-t / 0.003)
    if grains > 0:
        envelope += fall * _bursts(samples, grains, rng)
    else:
        envelope += 0.6 * fall
    sound = noise * envelope
    # The onset must be heard at its sample, whatever the noise does there.
    sound[0] = np.copysign(max(abs(sound[0]), 0.3), sound[0])
    # What the envelope let through at 0 Hz is taken out again along the envelope.
    return np.asarray(sound - envelope * (sound.sum() / envelope.sum()))


def _bursts(samples: int, grains: float, rng: np.random.Generator) -> Signal:
    """Return the sum of short decays at random times, of random strength: (samples,)."""
    count = max(int(rng.poisson(grains * samples / SAMPLE_RATE)), 3)
    starts = (rng.random(count) ** 1.5 * samples).astype(np.int64)
    strengths = rng.exponential(1.0, count)
    impulses = np.zeros(samples)
    np.add.at(impulses, starts, strengths)
    t = np.arange(int(0.006 * SAMPLE_RATE)) / SAMPLE_RATE
    return np.convolve(impulses, np.exp(-t / 0.0012))[:samples]
