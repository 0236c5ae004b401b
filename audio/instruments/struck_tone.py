"""Struck tones: pianos, bars, bells and drumheads, as sums of modes that decay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from audio.dsp import SILENCE_EXPONENT, Signal, band_noise
from audio.harmony import MIDDLE_C, frequency_of
from audio.modal_bank import bank_of, ring
from audio.time_grid import SAMPLE_RATE

_HIGHEST = 14_000.0
_STRIKE_SECONDS = 0.006


@dataclass(frozen=True, slots=True)
class StruckVoice:
    """A struck tone.

    Attributes:
        ratios: frequencies of its modes, relative to that of the note.
        levels: of the modes.
        seconds: in which the mode of the note falls by 60 dB at C4.
        height_exponent: by which higher notes die away sooner.
        damping: by which higher modes do, as a power of their ratio.
        hardness: of the mallet or hammer; by how much strength brightens, as an exponent.
        strike: level of the noise of the blow.
        release: time in which it falls by 60 dB when it is let go [s]; 0 if nothing damps it.
    """

    ratios: tuple[float, ...]
    levels: tuple[float, ...]
    seconds: float
    height_exponent: float = 0.5
    damping: float = 0.7
    hardness: float = 0.6
    strike: float = 0.04
    release: float = 0.0


# Stiffness of a piano string of C4, by which its partials are sharp: f = n f0 √(1 + B n²).
# Source: Fletcher and Rossing 1998, table 12.1.
_INHARMONICITY = 4e-4
_PIANO_PARTIALS = 24
_HAMMER_SPOT = 1 / 8


def piano_voice(seconds: float, tilt: float, strike: float, release: float = 0.12) -> StruckVoice:
    """Return a string struck by a hammer.

    Args:
        seconds: in which C4 falls by 60 dB.
        tilt: power by which partials get softer.
        strike: level of the hammer's noise.
        release: of the damper [s].
    """
    n = np.arange(1, _PIANO_PARTIALS + 1)
    # The pitch that is heard is that of the first partial.
    stretch = np.sqrt((1 + _INHARMONICITY * n**2) / (1 + _INHARMONICITY))
    levels = np.abs(np.sin(np.pi * n * _HAMMER_SPOT)) / n**tilt + 1e-3 / n
    return StruckVoice(
        ratios=tuple((n * stretch).tolist()),
        levels=tuple((levels / levels[0]).tolist()),
        seconds=seconds,
        damping=0.55,
        hardness=0.9,
        strike=strike,
        release=release,
    )


def struck_tone(
    voice: StruckVoice, frequency: float, held: int, strength: float, rng: np.random.Generator
) -> Signal:
    """Return a struck tone from its blow on: (N,).

    Args:
        voice: of the instrument.
        frequency: of the note [Hz].
        held: samples until it is let go.
        strength: of the blow, 0 to 1; a stronger one is brighter.
        rng: of the blow's noise.
    """
    ratio, level = np.array(voice.ratios), np.array(voice.levels)
    seconds = voice.seconds * (frequency_of(MIDDLE_C) / frequency) ** voice.height_exponent
    partial = ratio * frequency
    audible = partial < _HIGHEST
    ratio, level, partial = ratio[audible], level[audible], partial[audible]
    times = seconds / np.maximum(ratio, 0.5) ** voice.damping
    level = level * np.maximum(ratio, 1.0) ** (-voice.hardness * (1.1 - strength))
    samples = int(min(seconds, 8.0) * SAMPLE_RATE)
    if voice.release:
        samples = min(samples, held + int(voice.release * SAMPLE_RATE))
    bank = bank_of(partial, SILENCE_EXPONENT / times, level * rng.choice((-1.0, 1.0), level.size))
    signal = ring([bank], samples)
    if voice.release and samples > held:
        after = np.arange(samples - held) / SAMPLE_RATE
        signal[held:] *= np.exp(-SILENCE_EXPONENT * after / voice.release)
    if voice.strike:
        size = min(int(4 * _STRIKE_SECONDS * SAMPLE_RATE), samples)
        noise = band_noise(size, (400.0, 6000.0), rng)
        noise *= np.exp(-np.arange(size) / (_STRIKE_SECONDS * SAMPLE_RATE))
        signal[:size] += voice.strike * strength * float(np.abs(level).sum()) * noise
    return signal
