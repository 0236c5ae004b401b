"""Signal processing: noise, convolution, resampling and panning.

Source of the grain noise: Cook 1997 (PhISM): many small collisions at random times, fewer and
softer as energy is spent.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft
from scipy.signal import butter, lfilter

from audio.seeded import seeded
from audio.time_grid import SAMPLE_RATE

Signal = NDArray[np.float64]

Gain = float | Signal

SILENCE_EXPONENT = float(np.log(1000.0))
"""-60 dB as an exponent of e."""

SINGLE_THREAD_SIZE = 2**17
"""Multiplications below which BLAS uses one thread.

The bits must not depend on the number of threads, and small products are faster without them.
"""

_MIN_FFT_SIZE = 1 << 12
# Samples of the blocks of a convolution that are transformed at once.
_BLOCKS_SIZE = 1 << 17
# Below 30 Hz loudspeakers move and nobody hears.
_RUMBLE = butter(2, 30.0, "highpass", fs=SAMPLE_RATE)
# Samples of a noise that is shared.
_SHARED_NOISE = 2**17
# Decay of the click of an impact on loose ground, and that of a grain [s].
_CRUNCH_DECAY, _GRAIN_DECAY = 0.003, 0.0012


def band_noise(samples: int, band: tuple[float, float], rng: np.random.Generator) -> Signal:
    """Return stationary noise between two frequencies with soft shoulders, RMS 1: (samples,).

    Args:
        samples: at least one.
        band: lower and upper edge [Hz].
        rng: of the noise.
    """
    # A power of two, since FFTs of prime lengths are slow.
    size = 1 << max(int(samples - 1).bit_length(), 6)
    f = np.fft.rfftfreq(size, 1 / SAMPLE_RATE).astype(np.float64)
    # Even numbers, drawn faster than normal ones, add up to normal samples.
    spectrum = (rng.random((f.size, 2)) - 0.5).view(np.complex128)[:, 0]
    noise = np.fft.irfft(spectrum * band_response(f, band), size)[:samples]
    return np.asarray(noise / max(float(np.sqrt(np.mean(noise**2))), 1e-12))


def shared_noise(samples: int, band: tuple[float, float], rng: np.random.Generator) -> Signal:
    """Return a stretch of a noise that all sounds of a band share, RMS about 1: (samples,).

    Nobody may change it.
    It starts anywhere in the noise, which goes around, so that no two stretches are alike.

    Args:
        samples: at least one.
        band: lower and upper edge [Hz].
        rng: of the start.
    """
    noise = _noise_of_band(band, _SHARED_NOISE)
    start = int(rng.integers(noise.size))
    if start + samples <= noise.size:
        return noise[start : start + samples]
    return np.resize(np.concatenate((noise[start:], noise[:start])), samples)


def noise_at_rate(band: tuple[float, float], rate: Signal, rng: np.random.Generator) -> Signal:
    """Return a noise that all sounds of a band share, read at a varying rate, RMS about 1: (N,).

    Args:
        band: lower and upper edge at a rate of 1 [Hz].
        rate: (N,) of the reading; not negative.
        rng: of the start.
    """
    # Twice as many samples as it has at a rate of 1: lines between them are smooth enough.
    noise = _noise_of_band((band[0] / 2, band[1] / 2), 2 * _SHARED_NOISE)
    position = np.cumsum(rate)
    position *= 2.0
    position += rng.random() * noise.size
    i = position.astype(np.int64)
    share = position - i
    here = noise.take(i, mode="wrap")
    there = noise.take(i + 1, mode="wrap")
    there -= here
    there *= share
    there += here
    return there


@lru_cache(maxsize=32)
def _noise_of_band(band: tuple[float, float], samples: int) -> Signal:
    noise = band_noise(samples, band, seeded("noise", *band))
    noise.setflags(write=False)
    return noise


def band_response(frequency: Signal, band: tuple[float, float]) -> Signal:
    """Return what a band of soft shoulders leaves of frequencies, as a factor: (M,).

    Args:
        frequency: (M,) [Hz]; two Butterworth-like shoulders, exactly zero at 0 Hz.
        band: lower and upper edge [Hz].
    """
    # Products, because general powers take ten times as long.
    below, above = (frequency / band[0]) ** 2, (frequency / band[1]) ** 2
    return np.asarray(below / np.sqrt((1 + below * below) * (1 + above * above * above)))


def grain_noise(
    band: tuple[float, float], decay: float, rate: float, rng: np.random.Generator
) -> Signal:
    """Return the noise of an impact on loose ground, at full level from its first sample: (N,).

    Args:
        band: of the grains [Hz].
        decay: time to fall by 60 dB [s].
        rate: grains a second, at the start; 0 for a smooth rustle.
        rng: of grains and noise.
    """
    samples = max(int(decay * SAMPLE_RATE), 64)
    crunch, fall = (_decay(samples, time) for time in (_CRUNCH_DECAY, decay / SILENCE_EXPONENT))
    noise = shared_noise(samples, band, rng)
    envelope = crunch + fall * (_bursts(samples, rate, rng) if rate > 0 else 0.6)
    sound = noise * envelope
    # The onset must be audible at its sample, whatever the noise does there.
    sound[0] = np.copysign(max(abs(sound[0]), 0.3), sound[0])
    return without_offset(sound, envelope)


@lru_cache(maxsize=32)
def _decay(samples: int, seconds: float) -> Signal:
    """Return a decay to 1/e in a time [s]: (samples,)."""
    return np.asarray(np.exp(np.arange(samples) / (-seconds * SAMPLE_RATE)))


def _bursts(samples: int, rate: float, rng: np.random.Generator) -> Signal:
    """Return the sum of short decays at random times, of random strength: (samples,)."""
    count = max(int(rng.poisson(rate * samples / SAMPLE_RATE)), 3)
    starts = (rng.random(count) ** 1.5 * samples).astype(np.int64)
    strengths = rng.exponential(1.0, count)
    impulses = np.zeros(samples)
    np.add.at(impulses, starts, strengths)
    return np.asarray(lfilter([1.0], [1.0, -np.exp(-1 / (_GRAIN_DECAY * SAMPLE_RATE))], impulses))


def without_offset(sound: Signal, envelope: Signal) -> Signal:
    """Return a sound with its mean removed along an envelope, so that silence stays silent."""
    return np.asarray(sound - envelope * (sound.sum() / envelope.sum()))


def normalized(sound: Signal) -> Signal:
    """Return a sound scaled to a peak of 1; silence as it is."""
    peak = peak_of(sound)
    return sound / peak if peak > 0 else sound


def peak_of(sound: Signal) -> float:
    """Return the largest magnitude of a sound; 0 for none."""
    return max(float(sound.max(initial=0.0)), -float(sound.min(initial=0.0)))


def convolve(sound: Signal, response: Signal, single: bool = False) -> Signal:
    """Return a sound convolved with impulse responses, as long as the sound: (..., N).

    Overlap-add; blocks of silence are skipped and stay exactly silent.

    Args:
        sound: (N,).
        response: (..., K).
        single: whether single precision, 130 dB below the sound, is enough; it takes half the time.
    """
    kind = np.float32 if single else np.float64
    taps = response.shape[-1]
    size = max(_MIN_FFT_SIZE, 1 << (4 * taps - 1).bit_length())
    step = size - taps + 1
    spectrum = rfft(response.astype(kind, copy=False), size)
    whole = np.zeros((*response.shape[:-1], sound.size + size))
    # Several blocks at once, which the library transforms side by side.
    at_once = max(_BLOCKS_SIZE // size, 1)
    for first in range(0, sound.size, at_once * step):
        part = sound[first : first + at_once * step]
        rows = np.zeros((-(-part.size // step), step), kind)
        rows.reshape(-1)[: part.size] = part
        heard_at = np.flatnonzero(rows.any(axis=1))
        spectra = rfft(rows[heard_at], size)
        for k, each in zip(heard_at.tolist(), spectra, strict=True):
            if response.ndim > 1:
                start = first + k * step
                whole[..., start : start + size] += irfft(each * spectrum, size)
        if response.ndim == 1:
            for k, heard in zip(heard_at.tolist(), irfft(spectra * spectrum, size), strict=True):
                whole[first + k * step : first + k * step + size] += heard
    return whole[..., : sound.size]


def resample(sound: Signal, rate: Signal) -> Signal:
    """Return a sound read at a varying rate by cubic interpolation: (N,).

    Source: Catmull and Rom 1974.

    Args:
        sound: (K,) samples; repeated if too short.
        rate: (N,) input samples per output sample; not negative.
    """
    if (rate == 1.0).all() and rate.size <= sound.size:
        return np.array(sound[: rate.size])
    position = np.concatenate(([0.0], np.cumsum(rate)[:-1]))
    i = position.astype(np.int64)
    x = position - i
    if i[-1] >= sound.size:
        i %= sound.size
    around = np.concatenate((sound[-1:], sound, np.resize(sound, 2)))
    p0, p1, p2, p3 = (around[i + k] for k in range(4))
    curve = x * (3 * (p1 - p2) + p3 - p0) + 2 * p0 - 5 * p1 + 4 * p2 - p3
    return np.asarray(p1 + 0.5 * x * (p2 - p0 + x * curve))


def upsampled(curve: Signal, rate: int, samples: int) -> Signal:
    """Return a slow curve at each sample, linearly interpolated: (samples,).

    Args:
        curve: (K,) values, which reach beyond the last sample.
        rate: of the values, a second; the sample rate is a multiple of it.
        samples: to be returned.
    """
    step = SAMPLE_RATE // rate
    share = np.arange(step) / step
    rows = -(-samples // step)
    values = curve[:rows, None] + (curve[1 : rows + 1] - curve[:rows])[:, None] * share
    return np.asarray(values.reshape(-1)[:samples])


def pan_gains(pan: float) -> tuple[float, float]:
    """Return the gains of left and right for a pan of -1 to 1; their squares add to 1."""
    angle = (pan + 1) * pi / 4
    # cos(π/2) is 6e-17, which would keep the far side from being silent.
    return max(cos(angle), 0.0) * (pan < 1), max(sin(angle), 0.0) * (pan > -1)


def silence(samples: int, channels: int = 2) -> Signal:
    """Return silence, (samples, channels), with each channel in one piece."""
    return np.zeros((channels, samples)).T


def mix_in(mix: Signal, start: int, sound: Signal, gains: Sequence[Gain]) -> None:
    """Add a sound to a mix at a sample; the part past the end is cut.

    Args:
        mix: (N, C), changed.
        start: sample of the onset.
        sound: (M,).
        gains: of its channels, left and right first; (M,) if they vary.
    """
    size = min(max(mix.shape[0] - start, 0), sound.size)
    for side, gain in enumerate(gains):
        if isinstance(gain, np.ndarray) and gain.ndim:
            mix[start : start + size, side] += gain[:size] * sound[:size]
        elif gain:
            mix[start : start + size, side] += gain * sound[:size]


def without_rumble(sound: Signal) -> Signal:
    """Return a sound (N,) without what is too low to be heard, from its first sample on."""
    return np.asarray(lfilter(*_RUMBLE, sound))


def fade_out(stereo: Signal, samples: int) -> None:
    """Fade the last samples of a mix to silence, in place, to avoid a click at the end."""
    fade = min(samples, stereo.shape[0])
    stereo[stereo.shape[0] - fade :] *= (np.cos(0.5 * np.pi * (np.arange(fade) + 1) / fade) ** 2)[
        :, None
    ]


def decibels(amplitude: float) -> float:
    """Return an amplitude in decibels; -inf for zero."""
    return float(20 * np.log10(amplitude)) if amplitude > 0 else -np.inf
