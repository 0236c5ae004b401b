"""Sustained tones: bowed strings, winds, voices, organs and pads, read from tables of one period.

A tone is a dark and a bright table of harmonics, mixed as its loudness goes: blown or bowed harder,
an instrument is brighter. Tables hold no harmonic above hearing, so nothing folds.

Source: Risset and Mathews 1969 for brightness that follows the loudness of brass.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from audio.dsp import SILENCE_EXPONENT, Signal, band_noise
from audio.time_grid import SAMPLE_RATE

Spectrum = Literal[
    "sawtooth", "square", "triangle", "reed", "flute", "brass", "organ", "double reed"
]

_TABLE_SIZE = 2048
_HIGHEST = 16_000.0
_VIBRATO_RATE, _VIBRATO_DELAY = 5.4, 0.35
# Loudness of all other players beside the one that is in tune.
_OTHERS = 0.5
_CENT = float(np.log(2) / 1200)

_SPECTRA: dict[str, Callable[[Signal], Signal]] = {
    "sawtooth": lambda n: 1 / n,
    "square": lambda n: (n % 2) / n,
    "triangle": lambda n: (n % 2) / n**2,
    # A closed tube has odd harmonics; the even ones grow with height.
    "reed": lambda n: np.where(n % 2 == 1, 1.0, 0.12 + 0.04 * np.minimum(n, 10)) / n**0.9,
    "flute": lambda n: np.select([n == 1, n == 2, n == 3], [1.0, 0.35, 0.12], 0.05 / n),
    "brass": lambda n: 1 / n**0.6 * np.exp(-n / 14),
    "organ": lambda n: np.select(
        [n == 1, n == 2, n == 3, n == 4, n == 6, n == 8], [1.0, 0.8, 0.6, 0.5, 0.25, 0.3], 0.0
    ),
    "double reed": lambda n: np.exp(-(((n - 4) / 4.0) ** 2)) + 0.3 / n,
}


@dataclass(frozen=True, slots=True)
class ToneVoice:
    """A sustained tone.

    Attributes:
        spectrum: of its harmonics.
        attack: time in which it rises [s].
        release: time in which it falls by 60 dB after its end [s].
        dark: frequency above which soft tones lose 12 dB an octave [Hz], of loud ones `bright`.
        bright: the same of loud ones [Hz].
        vibrato: depth [cents].
        players: number of them, 1 to 3; the first is in tune.
        spread: detuning of the others [cents].
        noise: of breath or bow, relative to the tone.
        formants: resonances of the body or mouth, each with centre, width [Hz] and gain.
        decay: time in which it falls by 60 dB while it is held [s]; 0 to sustain it.
        tremolo: strokes of the bow a second; 0 for none.
    """

    spectrum: Spectrum
    attack: float = 0.03
    release: float = 0.15
    dark: float = 1200.0
    bright: float = 5000.0
    vibrato: float = 0.0
    players: int = 1
    spread: float = 0.0
    noise: float = 0.0
    formants: tuple[tuple[float, float, float], ...] = ()
    decay: float = 0.0
    tremolo: float = 0.0


def sustained_tone(
    voice: ToneVoice, frequency: float, held: int, strength: float, rng: np.random.Generator
) -> Signal:
    """Return a tone with its release: (N,).

    Args:
        voice: of the instrument.
        frequency: of its fundamental [Hz].
        held: samples until its end.
        strength: 0 to 1; a stronger one is brighter.
        rng: of phases and noise.
    """
    samples = held + int(voice.release * SAMPLE_RATE)
    t = np.arange(samples) / SAMPLE_RATE
    envelope = _envelope(voice, t, held / SAMPLE_RATE)
    dark = harmonic_table(voice.spectrum, frequency, voice.dark, voice.formants)
    bright = harmonic_table(voice.spectrum, frequency, voice.bright, voice.formants)
    mix = np.clip(0.15 + 0.85 * strength, 0, 1) * np.minimum(envelope, 1.0)
    tone = np.zeros(samples)
    offsets = np.array((0.0, voice.spread, -voice.spread))[: voice.players]
    for number, cents in enumerate(offsets):
        cycles = frequency * np.exp(cents * _CENT) / SAMPLE_RATE
        phase = np.arange(samples) * cycles + (rng.uniform() if number else 0.0)
        if voice.vibrato:
            phase += _vibrato(voice, frequency, t, rng.uniform() * 2 * np.pi)
        place = (phase % 1.0) * _TABLE_SIZE
        whole = place.astype(np.int64)
        rest = place - whole
        # The one that is in tune is louder than all others, so that they never cancel it.
        weight = 1.0 if number == 0 else _OTHERS / (voice.players - 1)
        for table, share in ((dark, 1 - mix), (bright, mix)):
            tone += weight * share * (table[whole] + rest * (table[whole + 1] - table[whole]))
    if voice.noise:
        band = (0.8 * frequency, max(4 * frequency, 3000.0))
        tone += voice.noise * band_noise(samples, band, rng)
    if voice.tremolo:
        envelope = envelope * (0.62 + 0.38 * np.abs(np.sin(np.pi * voice.tremolo * t)))
    return np.asarray(tone * envelope)


def _envelope(voice: ToneVoice, t: Signal, held: float) -> Signal:
    rise = np.sin(0.5 * np.pi * np.minimum(t / voice.attack, 1.0)) ** 2
    fall = np.exp(-SILENCE_EXPONENT * np.maximum(t - held, 0.0) / voice.release)
    sustain = np.exp(-SILENCE_EXPONENT * t / voice.decay) if voice.decay else 1.0
    return np.asarray(rise * fall * sustain)


def _vibrato(voice: ToneVoice, frequency: float, t: Signal, phase: float) -> Signal:
    """Return the phase that a vibrato adds [cycles]; its mean is zero, so the pitch stays."""
    depth = voice.vibrato * _CENT * frequency / (2 * np.pi * _VIBRATO_RATE)
    grown = np.clip((t - _VIBRATO_DELAY) / _VIBRATO_DELAY, 0.0, 1.0)
    return np.asarray(depth * grown * np.sin(2 * np.pi * _VIBRATO_RATE * t + phase))


@lru_cache(maxsize=1024)
def harmonic_table(
    spectrum: Spectrum,
    frequency: float,
    corner: float,
    formants: tuple[tuple[float, float, float], ...] = (),
) -> Signal:
    """Return one period of a tone of RMS 1, with its first value again at the end: (K + 1,).

    Args:
        spectrum: of its harmonics.
        frequency: of the fundamental [Hz].
        corner: above which harmonics lose 12 dB an octave [Hz].
        formants: centre, width [Hz] and gain of resonances.
    """
    n = np.arange(1, max(min(int(_HIGHEST / frequency), _TABLE_SIZE // 2 - 1), 1) + 1, dtype=float)
    f = n * frequency
    level = _SPECTRA[spectrum](n) / (1 + (f / corner) ** 2)
    if formants:
        level = level * (0.08 + sum(g * np.exp(-(((f - c) / w) ** 2)) for c, w, g in formants))
    # Phases by a square law keep the peak of the sum low.
    spectrum_bins = np.zeros(_TABLE_SIZE // 2 + 1, complex)
    spectrum_bins[1 : n.size + 1] = level * np.exp(1j * np.pi * n**2 / n.size) * -1j
    table = np.fft.irfft(spectrum_bins, _TABLE_SIZE)
    table = table / np.sqrt(np.mean(table**2))
    return np.append(table, table[0])
