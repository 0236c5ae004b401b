"""Plucked strings: guitars, basses, harps and their relatives.

A string is a delay line of one period that is low-passed at each turn. The low-pass is symmetric,
so that it delays all partials alike, and a linear interpolation adds the fraction of a sample that
the period needs.

Sources: Karplus and Strong 1983; Jaffe and Smith 1983 for tuning, decay and the place of the pluck.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi

import numpy as np

from audio.dsp import SILENCE_EXPONENT, Signal
from audio.harmony import MIDDLE_C, frequency_of
from audio.time_grid import SAMPLE_RATE

# Damping of the low-pass at each turn is at most that of three equal taps.
_MOST_DAMPING = 1 / 3


@dataclass(frozen=True, slots=True)
class StringVoice:
    """A plucked string.

    Attributes:
        seconds: in which the fundamental of C4 falls by 60 dB; lower strings last longer.
        bright_seconds: in which a partial of 3 kHz does.
        spot: place of the pluck, as a share of the string.
        softness: share of a period over which the pluck is smoothed; a finger's is wide.
        drive: by which the string is overdriven; 0 for none.
    """

    seconds: float
    bright_seconds: float
    spot: float = 0.2
    softness: float = 0.02
    drive: float = 0.0


_BRIGHT_FREQUENCY = 3000.0


def plucked_string(
    voice: StringVoice, frequency: float, samples: int, strength: float, rng: np.random.Generator
) -> Signal:
    """Return a plucked string from its pluck on: (samples,).

    Args:
        voice: the string.
        frequency: of its fundamental [Hz].
        samples: length.
        strength: of the pluck, 0 to 1; a stronger one is brighter.
        rng: of the noise of the pluck.
    """
    period = SAMPLE_RATE / frequency
    # The filter delays by one sample, the interpolation by a fraction.
    delay = max(int(period - 1), 2)
    fraction = period - 1 - delay
    seconds = voice.seconds * (frequency_of(MIDDLE_C) / frequency) ** 0.5
    loss = float(np.exp(-SILENCE_EXPONENT * period / (SAMPLE_RATE * seconds)))
    fade = float(np.exp(-SILENCE_EXPONENT * period / (SAMPLE_RATE * voice.bright_seconds)))
    turn = 1 - cos(2 * pi * min(_BRIGHT_FREQUENCY / SAMPLE_RATE, 0.5))
    damping = min(max((1 - fade / loss) / (2 * turn), 0.0), _MOST_DAMPING)
    low_pass = loss * np.array([damping, 1 - 2 * damping, damping])
    taps = np.convolve(low_pass, [1 - fraction, fraction])
    line = np.zeros(samples + delay + taps.size)
    first = delay + taps.size - 1
    excitation = _pluck(voice, delay + 1, strength, rng)
    line[first : first + excitation.size] = excitation[:samples]
    # Of a turn of the line no sample depends on another of the same turn.
    for start in range(first, first + samples, delay):
        end = min(start + delay, first + samples)
        for k, tap in enumerate(taps):
            line[start:end] += tap * line[start - delay - k : end - delay - k]
    string = line[first : first + samples]
    if voice.drive:
        string = np.tanh(voice.drive * string)
    return np.asarray(string)


def _pluck(voice: StringVoice, size: int, strength: float, rng: np.random.Generator) -> Signal:
    """Return the displacement along a string at its pluck, as one turn of the line: (size,)."""
    noise = rng.uniform(-1.0, 1.0, size)
    # The bend at the pluck has all partials but those with a node there; noise makes it rough.
    place = np.arange(size) / size
    bend = np.where(place < voice.spot, 1.0, -voice.spot / (1 - voice.spot))
    shape = bend + 0.35 * noise
    width = max(int(voice.softness * (1.6 - strength) * size), 1)
    kernel = np.hanning(width + 2)[1:-1]
    shape = np.convolve(np.concatenate((shape[-width:], shape, shape[:width])), kernel, "same")
    shape = shape[width : width + size] / kernel.sum()
    return np.asarray(shape - shape.mean())
