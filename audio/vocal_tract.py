"""Vocal tract: voices of people and creatures, as harmonics of a source through formants.

The pitch of creatures follows their mass, f = 1000 Hz (M / 1 kg)^-0.4. Moods differ in tone as
animals' do: hostile sounds are low and harsh, friendly or fearful ones high and pure. A laugh is a
row of short notes, each begun with a breath, that sink and fade; a fright is breathed in.

Source: Fletcher 2004 for the pitch of creatures; Morton 1977 for moods; Bachorowski, Smoski and
Owren 2001 for laughs; Peterson and Barney 1952 for the vowel of an open mouth.
"""

from __future__ import annotations

import numpy as np

from audio.dsp import Signal, band_noise, without_offset
from audio.motion import MAX_FREQUENCY, Motion, arch, drift, tone
from audio.time_grid import SAMPLE_RATE

PERSON_PITCH = 450.0
"""Pitch of a child's cry, whose throat is 0.1 m [Hz]."""

ANIMAL_PITCH, ANIMAL_SLOPE = 1000.0, 1.2
"""Pitch of a creature of 1 kg, 0.1 m as a cube of water [Hz], and by what power it falls."""

# Formants of the vowel of an open mouth of a child, and their width [Hz].
_FORMANTS, _FORMANT_WIDTH = (1030.0, 1370.0, 3170.0), 160.0
# Frequencies of the vibrato of a cry, the notes of a laugh and the roughness of a growl [Hz].
_VIBRATO, _LAUGH_RATE, _ROUGHNESS = (5.0, 7.0), (4.2, 5.4), (24.0, 38.0)
# Resonances of an animal's throat, in pitches, and their width.
_THROAT, _THROAT_WIDTH = (2.2, 4.6, 7.5), 0.8


def _harmonics(pitch: float, tilt: float) -> tuple[float, ...]:
    """Return the amplitudes of the harmonics of a person's open mouth, of sum 1.

    Args:
        pitch: [Hz]; a smaller throat raises the formants too.
        tilt: power of the number of a harmonic by which it is weaker.
    """
    formants = np.array(_FORMANTS) * (pitch / PERSON_PITCH) ** 0.4
    harmonic = np.arange(1, max(int(MAX_FREQUENCY / (2 * pitch)), 2))
    offset = (harmonic[:, None] * pitch - formants) / _FORMANT_WIDTH
    amplitudes = (1 / (1 + offset**2)).sum(axis=1) / harmonic**tilt
    return tuple((amplitudes / amplitudes.sum()).tolist())


def breath(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return a puff of air."""
    samples, pitch = motion.profile.samples, motion.pitch
    puff = arch(samples, 0.3)
    return without_offset(puff * band_noise(samples, (0.6 * pitch, 2 * pitch), rng), puff)


def cry(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return a voice that rises, breaks and falls: glottal harmonics through formants."""
    samples, t = motion.profile.samples, np.linspace(0.0, 1.0, motion.profile.samples)
    bend = 0.82 + 0.36 * np.sin(np.pi * t**0.6) - 0.12 * t
    vibrato = 1 + 0.02 * np.sin(
        2 * np.pi * rng.uniform(*_VIBRATO) * np.arange(samples) / SAMPLE_RATE
    )
    frequency = motion.pitch * bend * vibrato * drift(samples, 0.015, rng)
    # A louder voice has stronger upper harmonics.
    voice = tone(frequency, _harmonics(motion.pitch, 1.2 - 0.08 * min(motion.speed, 5.0)))
    breath = 0.06 * band_noise(samples, (1500.0, 6000.0), rng)
    envelope = arch(samples, 0.25)
    return without_offset((voice + breath) * envelope, envelope)


def laugh(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return short notes that sink and fade, each begun with a breath."""
    samples, pitch = motion.profile.samples, 0.9 * motion.pitch
    t = np.arange(samples) / SAMPLE_RATE
    notes = max(round(rng.uniform(*_LAUGH_RATE) * samples / SAMPLE_RATE), 2)
    # The number of the note, and the place within it.
    place = t / t[-1] * notes
    within = np.minimum(place - np.floor(place), 1.0)
    later = np.floor(place) / notes
    bend = 1.25 - 0.45 * later + 0.12 * np.sin(np.pi * within)
    frequency = pitch * bend * drift(samples, 0.03, rng)
    voiced = np.sin(np.pi * np.clip((within - 0.18) / 0.5, 0.0, 1.0)) ** 1.5
    breathed = np.exp(-(((within - 0.16) / 0.12) ** 2))
    air = band_noise(samples, (900.0, 5000.0), rng)
    voice = tone(frequency, _harmonics(pitch, 1.1))
    fall = (1.0 - 0.75 * later) * np.minimum(1.0, (samples - np.arange(samples)) / 480.0)
    # The first breath begins on the first sample.
    envelope = fall * np.maximum(voiced + 0.05, np.exp(-t / 0.02))
    return without_offset(fall * (voice * voiced + 0.12 * air * breathed), envelope)


def gasp(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return a breath that is drawn in, over a thin voice that slides up."""
    samples, pitch = motion.profile.samples, motion.pitch
    x = np.arange(samples) / samples
    # Air that is drawn in rises in pitch as the mouth opens.
    low, high = (band_noise(samples, band, rng) for band in ((500.0, 1500.0), (1500.0, 5200.0)))
    air = (1 - x) * low + x * high
    voice = tone(1.5 * pitch * (1 + 0.5 * x) * drift(samples, 0.02, rng), (1.0, 0.25, 0.1))
    envelope = arch(samples, 0.65)
    loud = 0.15 + 0.12 * min(motion.speed, 5.0)
    return without_offset(envelope * (0.3 * air + loud * voice * x), envelope)


def _throaty(pitch: float, tilt: float) -> tuple[float, ...]:
    """Return the amplitudes of the harmonics of an animal's throat, of sum 1."""
    harmonic = np.arange(1, int(np.clip(MAX_FREQUENCY / (2 * pitch), 2, 24)))
    offset = (harmonic[:, None] - np.array(_THROAT)) / _THROAT_WIDTH
    amplitudes = (0.15 + (1 / (1 + offset**2)).sum(axis=1)) / harmonic**tilt
    return tuple((amplitudes / amplitudes.sum()).tolist())


def call(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return the call of a creature at ease: a full tone that rises and falls."""
    samples = motion.profile.samples
    x = np.arange(samples) / samples
    frequency = motion.pitch * (0.85 + 0.3 * np.sin(np.pi * x**0.8)) * drift(samples, 0.02, rng)
    voice = tone(frequency, _throaty(motion.pitch, 1.0))
    envelope = arch(samples, 0.3)
    return without_offset(
        (voice + 0.02 * band_noise(samples, (800.0, 4000.0), rng)) * envelope, envelope
    )


def growl(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return the growl of an angry creature: an octave lower, rough and full of air."""
    samples, pitch = motion.profile.samples, 0.5 * motion.pitch
    t = np.arange(samples) / SAMPLE_RATE
    rate = rng.uniform(*_ROUGHNESS) * drift(samples, 0.2, rng)
    beat = 0.5 + 0.5 * np.sin(2 * np.pi * np.cumsum(rate) / SAMPLE_RATE)
    voice = tone(pitch * (1 - 0.1 * t / t[-1]) * drift(samples, 0.05, rng), _throaty(pitch, 0.5))
    air = band_noise(samples, (2 * pitch, 12 * pitch), rng)
    envelope = arch(samples, 0.35) * (0.25 + 0.75 * beat**2)
    return without_offset((voice + 0.12 * air) * envelope, envelope)


def whine(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return the whine of a sad or frightened creature: high, pure and sinking."""
    samples = motion.profile.samples
    x = np.arange(samples) / samples
    tremble = 1 + 0.015 * np.sin(2 * np.pi * rng.uniform(8.0, 11.0) * samples / SAMPLE_RATE * x)
    frequency = 1.5 * motion.pitch * (1.1 - 0.25 * x) * tremble * drift(samples, 0.01, rng)
    voice = tone(np.minimum(frequency, MAX_FREQUENCY), (1.0, 0.12, 0.04))
    envelope = arch(samples, 0.25)
    return without_offset(voice * envelope, envelope)
