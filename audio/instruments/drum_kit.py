"""Drum kit: the drums of General MIDI, from membranes, bars, metal noise and grains."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from audio.dsp import SILENCE_EXPONENT, Signal, band_noise
from audio.modal_bank import bank_of, ring
from audio.time_grid import SAMPLE_RATE

# Modes of an ideal membrane, relative to the lowest: zeros of Bessel functions.
# Source: Fletcher and Rossing 1998, 3.3.
_MEMBRANE = (1.0, 1.594, 2.136, 2.296, 2.653, 2.918, 3.156, 3.501)
# A loaded hand drum is nearly harmonic.
_HAND_DRUM = (1.0, 1.98, 2.96, 3.94, 5.1)
# Of a wood block or clave as a short free bar, of a cowbell as two plates, and of a triangle.
_BAR = (1.0, 2.757, 5.404)
_COWBELL = (1.0, 1.48, 2.33, 3.06, 4.2)
_TRIANGLE = (1.0, 1.62, 2.37, 3.14, 4.02, 5.21)
# Square waves of the metal sound: incommensurate, so that no pitch is heard [Hz].
_METAL = (205.3, 304.4, 369.6, 522.7, 635.0, 800.0)


class Drum(Protocol):
    """A drum: (strength from 0 to 1, noise) -> its sound (N,)."""

    def __call__(self, strength: float, rng: np.random.Generator) -> Signal:
        """Return its sound."""
        ...


@dataclass(frozen=True, slots=True)
class _Noise:
    """Noise of a drum.

    Attributes:
        band: [Hz].
        seconds: in which it falls by 60 dB.
        level: relative to its tone.
    """

    band: tuple[float, float]
    seconds: float
    level: float


def _fall(samples: int, seconds: float) -> Signal:
    return np.exp(-SILENCE_EXPONENT * np.arange(samples) / (seconds * SAMPLE_RATE))


def _noise(noise: _Noise, rng: np.random.Generator) -> Signal:
    samples = int(noise.seconds * SAMPLE_RATE)
    return noise.level * band_noise(samples, noise.band, rng) * _fall(samples, noise.seconds)


def _sum(*layers: Signal) -> Signal:
    whole = np.zeros(max(layer.size for layer in layers))
    for layer in layers:
        whole[: layer.size] += layer
    return whole


def _head(
    strength: float,
    rng: np.random.Generator,
    *,
    pitch: float,
    seconds: float,
    drop: float = 0.0,
    ratios: tuple[float, ...] = _MEMBRANE,
    noise: _Noise = _Noise((200.0, 4000.0), 0.03, 0.3),
) -> Signal:
    """Return a drumhead whose pitch drops as its tension does after a blow.

    Args:
        strength: of the blow.
        rng: of its noise.
        pitch: of its lowest mode [Hz].
        seconds: in which that falls by 60 dB.
        drop: by which its pitch is higher at the blow, as a share.
        ratios: of its modes.
        noise: of the stick, beater or snares.
    """
    samples = int(seconds * SAMPLE_RATE)
    t = np.arange(samples) / SAMPLE_RATE
    sag = drop * (0.5 + 0.5 * strength)
    # The integral of pitch (1 + sag e^{-t / 0.03 s}).
    phase = 2 * np.pi * pitch * (t + sag * 0.03 * (1 - np.exp(-t / 0.03)))
    tone = np.zeros(samples)
    for number, ratio in enumerate(ratios):
        level = 1 / (1 + number) ** (1.6 - 0.6 * strength)
        tone += level * np.sin(ratio * phase) * _fall(samples, seconds / ratio)
    louder = _Noise(noise.band, noise.seconds, noise.level * (0.4 + 0.6 * strength))
    return _sum(tone, _noise(louder, rng))


def _bars(
    strength: float,
    rng: np.random.Generator,
    *,
    pitch: float,
    seconds: float,
    ratios: tuple[float, ...] = _BAR,
    click: float = 0.15,
) -> Signal:
    """Return what rings with fixed modes."""
    ratio = np.array(ratios)
    level = ratio ** -(1.3 - 0.7 * strength)
    bank = bank_of(pitch * ratio, SILENCE_EXPONENT * ratio**0.5 / seconds, level)
    tone = ring([bank], int(seconds * SAMPLE_RATE))
    return _sum(tone, _noise(_Noise((1000.0, 8000.0), 0.015, click * strength), rng))


def _metal(
    strength: float,
    rng: np.random.Generator,
    *,
    low: float,
    seconds: float,
    scale: float = 1.0,
    bell: float = 0.0,
) -> Signal:
    """Return a cymbal: a dense sound of metal above a frequency, brighter at its stroke."""
    samples = int(seconds * SAMPLE_RATE)
    t = np.arange(samples) / SAMPLE_RATE
    clang = np.zeros(samples)
    for f in _METAL:
        clang += np.sign(np.sin(2 * np.pi * (f * scale * t + rng.uniform())))
    # Differences twice over leave what is high.
    clang = np.diff(clang, 2, prepend=(0.0, 0.0))
    clang /= max(float(np.sqrt(np.mean(clang**2))), 1e-9)
    hiss = band_noise(samples, (low, 15_000.0), rng)
    stroke = 0.4 + strength * _fall(samples, 0.25 * seconds)
    sound = (0.35 * clang + hiss) * _fall(samples, seconds) * stroke
    if bell:
        sound += bell * _sum(_bars(strength, rng, pitch=620.0 * scale, seconds=seconds,
                                   ratios=_COWBELL), np.zeros(samples))[:samples]  # fmt: skip
    return np.asarray(sound)


def _clap(strength: float, rng: np.random.Generator) -> Signal:
    """Return hands of several people, a few hundredths of a second apart."""
    hand = _noise(_Noise((700.0, 3500.0), 0.05, 1.0), rng)
    tail = _noise(_Noise((800.0, 3000.0), 0.22, 0.6 * (0.5 + strength)), rng)
    whole = np.zeros(tail.size + 1500)
    for at, level in ((0, 0.7), (480, 0.6), (1010, 0.9)):
        whole[at : at + hand.size] += level * hand
    whole[1500:] += tail
    return whole


def _shake(
    strength: float, rng: np.random.Generator, *, low: float, seconds: float, strokes: int = 1
) -> Signal:
    """Return grains that are shaken, or a scraper of so many notches."""
    samples = int(seconds * SAMPLE_RATE)
    t = np.arange(samples) / samples
    shape = np.sin(np.pi * np.minimum(t**0.6, 1.0)) ** 2 * (1.1 - t) + 0.05 * (1 - t)
    if strokes > 1:
        shape = shape * (0.15 + np.maximum(np.cos(2 * np.pi * strokes * t), 0.0) ** 4)
    return np.asarray(band_noise(samples, (low, 12_000.0), rng) * shape * (0.5 + strength))


def _whistle(strength: float, rng: np.random.Generator, *, seconds: float) -> Signal:
    samples = int(seconds * SAMPLE_RATE)
    t = np.arange(samples) / SAMPLE_RATE
    trill = 2350 * t + 60 / (2 * np.pi * 32) * np.sin(2 * np.pi * 32 * t)
    edge = np.minimum(1, np.minimum(t / 0.01, (seconds - t) / 0.03))
    breath = 0.1 * strength * band_noise(samples, (1500.0, 6000.0), rng)
    return np.asarray((np.sin(2 * np.pi * trill) + breath) * edge)


def _cuica(strength: float, rng: np.random.Generator, *, seconds: float) -> Signal:
    samples = int(seconds * SAMPLE_RATE)
    t = np.arange(samples) / SAMPLE_RATE
    glide = 380 * t + 240 * t**2 / seconds
    edge = np.minimum(1, np.minimum(t / 0.008, (seconds - t) / 0.05))
    rub = 0.15 * band_noise(samples, (300.0, 2500.0), rng)
    return np.asarray((np.sin(2 * np.pi * glide) + 0.4 * np.sin(4 * np.pi * glide) + rub) * edge
                      * (0.6 + 0.4 * strength))  # fmt: skip


def _tom(pitch: float) -> Drum:
    return partial(_head, pitch=pitch, seconds=0.55, drop=0.35)


def _hand(pitch: float, seconds: float) -> Drum:
    slap = _Noise((500.0, 5000.0), 0.04, 0.25)
    return partial(_head, pitch=pitch, seconds=seconds, drop=0.06, ratios=_HAND_DRUM, noise=slap)


_SNARES = _Noise((1200.0, 9000.0), 0.22, 1.1)
_BEATER = _Noise((800.0, 5000.0), 0.02, 0.35)

# In the order of the keys of `audio.general_midi.DRUMS`.
KIT: tuple[Drum, ...] = (
    partial(_head, pitch=48.0, seconds=0.45, drop=1.6, ratios=(1.0, 1.6), noise=_BEATER),
    partial(_head, pitch=54.0, seconds=0.35, drop=1.9, ratios=(1.0, 1.6), noise=_BEATER),
    partial(_bars, pitch=1750.0, seconds=0.06, click=0.5),
    partial(_head, pitch=185.0, seconds=0.18, drop=0.2, noise=_SNARES),
    _clap,
    partial(_head, pitch=210.0, seconds=0.14, drop=0.3, noise=_SNARES),
    _tom(82.0),
    partial(_metal, low=7000.0, seconds=0.09),
    _tom(98.0),
    partial(_metal, low=6000.0, seconds=0.07),
    _tom(117.0),
    partial(_metal, low=7000.0, seconds=0.7),
    _tom(139.0),
    _tom(165.0),
    partial(_metal, low=3500.0, seconds=2.2, scale=1.3),
    _tom(196.0),
    partial(_metal, low=5000.0, seconds=1.6, scale=1.2, bell=0.2),
    partial(_metal, low=2500.0, seconds=1.4, scale=0.9),
    partial(_metal, low=6000.0, seconds=1.2, scale=1.2, bell=0.9),
    partial(_shake, low=6500.0, seconds=0.16),
    partial(_metal, low=4500.0, seconds=0.9, scale=1.7),
    partial(_bars, pitch=560.0, seconds=0.35, ratios=_COWBELL),
    partial(_metal, low=3200.0, seconds=2.0, scale=1.45),
    partial(_shake, low=1800.0, seconds=0.7, strokes=22),
    partial(_metal, low=4600.0, seconds=1.5, scale=1.1, bell=0.25),
    _hand(400.0, 0.20),
    _hand(290.0, 0.26),
    _hand(330.0, 0.07),
    _hand(310.0, 0.32),
    _hand(205.0, 0.38),
    partial(_head, pitch=430.0, seconds=0.35, drop=0.04),
    partial(_head, pitch=300.0, seconds=0.40, drop=0.04),
    partial(_bars, pitch=910.0, seconds=0.40, ratios=_COWBELL),
    partial(_bars, pitch=680.0, seconds=0.45, ratios=_COWBELL),
    partial(_shake, low=4500.0, seconds=0.11),
    partial(_shake, low=5500.0, seconds=0.07),
    partial(_whistle, seconds=0.15),
    partial(_whistle, seconds=0.45),
    partial(_shake, low=2200.0, seconds=0.12, strokes=6),
    partial(_shake, low=2200.0, seconds=0.42, strokes=20),
    partial(_bars, pitch=2500.0, seconds=0.11),
    partial(_bars, pitch=1150.0, seconds=0.13),
    partial(_bars, pitch=830.0, seconds=0.15),
    partial(_cuica, seconds=0.14),
    partial(_cuica, seconds=0.34),
    partial(_bars, pitch=2100.0, seconds=0.12, ratios=_TRIANGLE, click=0.05),
    partial(_bars, pitch=2100.0, seconds=2.4, ratios=_TRIANGLE, click=0.05),
)
