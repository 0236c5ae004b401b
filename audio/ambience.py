"""Ambience: the ambient sound of a scene, as long as the film.

Wind and what it moves, birds, crickets, rain, surf, running water, fire, the tone of a room and the
dull world below water; each layer comes from both sides and changes slowly.

Source: Farnell 2010.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields

import numpy as np
from scipy.fft import irfft, next_fast_len, rfftfreq

from audio.bubbles import bubble
from audio.dsp import (
    Signal,
    band_response,
    convolve,
    mix_in,
    pan_gains,
    silence,
    upsampled,
    without_rumble,
)
from audio.loudness_meter import integrated_loudness
from audio.time_grid import SAMPLE_RATE


@dataclass(frozen=True, slots=True)
class Ambience:
    """Amounts of the layers of an ambient sound, each from 0 to 1.

    Attributes:
        wind: in the open.
        leaves: that the wind moves.
        birds: by day.
        crickets: at night, and in dry heat.
        rain: on the ground around.
        surf: of a sea.
        stream: of running water.
        fire: that burns near the camera.
        room: tone of a room.
        submerged: below water, from where nothing else is heard.
    """

    wind: float = 0.0
    leaves: float = 0.0
    birds: float = 0.0
    crickets: float = 0.0
    rain: float = 0.0
    surf: float = 0.0
    stream: float = 0.0
    fire: float = 0.0
    room: float = 0.0
    submerged: float = 0.0

    @property
    def layers(self) -> dict[str, float]:
        """Its layers that are heard."""
        amounts = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: amount for name, amount in amounts.items() if amount > 0.0}


AMBIENCES: Mapping[str, Ambience] = {
    "meadow": Ambience(wind=0.35, leaves=0.25, birds=0.6),
    "forest": Ambience(wind=0.25, leaves=0.7, birds=0.8),
    "desert": Ambience(wind=0.8),
    "shore": Ambience(wind=0.4, surf=1.0),
    "stream": Ambience(wind=0.2, leaves=0.3, birds=0.4, stream=1.0),
    "rain": Ambience(wind=0.3, rain=0.8),
    "night": Ambience(wind=0.2, leaves=0.15, crickets=0.8),
    "street": Ambience(wind=0.45, birds=0.2),
    "fire": Ambience(wind=0.2, crickets=0.3, fire=1.0),
    "room": Ambience(room=1.0),
    "underwater": Ambience(submerged=1.0),
}
"""Ambiences by name."""

LOUDNESS: Mapping[str, float] = {
    "wind": -34.0,
    "leaves": -38.0,
    "birds": -41.0,
    "crickets": -41.0,
    "rain": -30.0,
    "surf": -33.0,
    "stream": -35.0,
    "fire": -34.0,
    "room": -47.0,
    "submerged": -36.0,
}
"""Loudness of each layer at its full amount, beside a track of -16 LUFS [LUFS]."""

USUAL_LUFS = -16.0

CONTROL_RATE = 50
"""Values of slow changes a second."""

# Share of the time in which a cricket is heard.
CHIRP = 0.28

# Samples after which a noise repeats, and the level below its strongest frequency of what is left
# out of it.
_PERIOD, _INAUDIBLE = 2**22, 1e-3


def ambient_sound(
    ambience: Ambience, samples: int, seed: int, target_lufs: float = USUAL_LUFS
) -> Signal:
    """Return an ambient sound: (samples, 2).

    Args:
        ambience: its layers.
        samples: of the film.
        seed: of the scene.
        target_lufs: loudness that the track is meant to have [LUFS].
    """
    bed = silence(samples)
    gusts = _slow(samples, 0.16, 4.0, np.random.default_rng([seed, 70]))
    for number, (name, make) in enumerate(_LAYERS.items()):
        amount = ambience.layers.get(name, 0.0)
        if not amount:
            continue
        rng = np.random.default_rng([seed, 71 + number])
        layer = make(samples, gusts, rng)
        loudness = integrated_loudness(layer)
        if np.isfinite(loudness):
            wanted = LOUDNESS[name] + 20.0 * np.log10(amount) + target_lufs - USUAL_LUFS
            bed += layer * 10 ** ((wanted - loudness) / 20)
    edge = min(round(0.02 * SAMPLE_RATE), samples // 2)
    bed[:edge] *= np.linspace(0.0, 1.0, edge)[:, None]
    bed[samples - edge :] *= np.linspace(1.0, 0.0, edge)[:, None]
    return bed


def _slow(samples: int, rate: float, depth: float, rng: np.random.Generator) -> Signal:
    """Return a slow change around 1, (samples,).

    Args:
        samples: of the film.
        rate: of its changes [Hz].
        depth: in decibels, as a deviation.
        rng: of the change.
    """
    count = samples * CONTROL_RATE // SAMPLE_RATE + 2
    size = 1 << (count + 4 * CONTROL_RATE).bit_length()
    spectrum = np.fft.rfft(rng.standard_normal(size))
    frequency = np.fft.rfftfreq(size, 1 / CONTROL_RATE)
    spectrum *= np.exp(-((frequency / rate) ** 2))
    curve = np.fft.irfft(spectrum, size)[:count]
    curve = curve / max(float(np.std(curve)), 1e-9)
    return upsampled(10 ** (depth * np.clip(curve, -1.4, 2.2) / 20), CONTROL_RATE, samples)


def _noise(
    samples: int, band: tuple[float, float], rng: np.random.Generator, slope: float = 0.0
) -> Signal:
    """Return noise between two frequencies, not alike on both sides: (samples, 2).

    It repeats after a minute and a half, which the gusts that shape it do not.

    Args:
        samples: of the film.
        band: lower and upper edge [Hz].
        rng: of the noise.
        slope: power of the frequency by which its amplitude falls.
    """
    size = min(next_fast_len(max(samples, 2), real=True), _PERIOD)
    # Single precision, random numbers for audible frequencies alone: they take most of the time.
    frequency = rfftfreq(size, 1 / SAMPLE_RATE).astype(np.float32)
    shape = band_response(frequency, band) * np.maximum(frequency, np.float32(band[0])) ** -slope
    heard = int(np.flatnonzero(shape > _INAUDIBLE * shape.max())[-1]) + 1
    spectrum = np.zeros((2, frequency.size), np.complex64)
    # Even ones, drawn faster than normal ones: so many of them add up to normal samples.
    random = (rng.random((2, heard, 2), np.float32) - 0.5).view(np.complex64)[:, :, 0]
    # As white noise of RMS 1 would be filtered.
    spectrum[:, :heard] = random * (np.sqrt(6 * size) * shape[:heard]).astype(np.float32)
    left, right = irfft(spectrum, size)
    # Part of it is the same on both sides: a place is around, not at two ears.
    noise = silence(samples)
    noise[:, 0] = np.resize(1.1 * left + 0.3 * right, samples)
    noise[:, 1] = np.resize(0.3 * left + 1.1 * right, samples)
    return noise


def _wind(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    body = _noise(samples, (90.0, 420.0), rng, 0.6)
    whistle = _noise(samples, (500.0, 1100.0), rng, 0.5)
    body *= gusts[:, None]
    whistle *= (9.0 * gusts * gusts)[:, None]
    return body + whistle


def _leaves(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    flutter = _slow(samples, 2.2, 2.5, rng)
    return _noise(samples, (1800.0, 7000.0), rng, 0.4) * (gusts**1.5 * flutter)[:, None]


def _scattered(
    samples: int,
    rate: float,
    make: Callable[[np.random.Generator], Signal],
    rng: np.random.Generator,
) -> Signal:
    """Return sounds at random times, from random sides and distances: (samples, 2).

    Args:
        samples: of the film.
        rate: of the sounds, a second.
        make: returns one of them (N,).
        rng: of all that is random.
    """
    out = silence(samples)
    for _ in range(max(int(rng.poisson(rate * samples / SAMPLE_RATE)), 1)):
        sound = make(rng) * rng.uniform(0.12, 1.0) ** 1.5
        start = int(rng.integers(0, max(samples - sound.size, 1)))
        left, right = pan_gains(rng.uniform(-0.85, 0.85))
        mix_in(out, start, sound, (left, right))
    return out


def _phrase(rng: np.random.Generator) -> Signal:
    """Return a phrase of one bird: chirps that glide, alike within the phrase."""
    base, notes = rng.uniform(2400.0, 5200.0), int(rng.integers(2, 7))
    glide, length = rng.uniform(-0.35, 0.45), rng.uniform(0.05, 0.14)
    trill = rng.uniform(18.0, 45.0) * (rng.random() < 0.4)
    pieces = []
    for _ in range(notes):
        t = np.arange(round(length * rng.uniform(0.8, 1.2) * SAMPLE_RATE)) / SAMPLE_RATE
        u = t / t[-1]
        pitch = base * rng.uniform(0.94, 1.06) * (1.0 + glide * u + 0.03 * np.sin(6.28 * trill * t))
        tone = np.sin(2.0 * np.pi * np.cumsum(pitch) / SAMPLE_RATE) * np.sin(np.pi * u) ** 1.5
        pieces += [tone, np.zeros(round(rng.uniform(0.03, 0.12) * SAMPLE_RATE))]
    return np.concatenate(pieces)


def _birds(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    near = _scattered(samples, 0.55, _phrase, rng)
    # The wood answers softly.
    tail = rng.standard_normal(round(0.5 * SAMPLE_RATE)) * np.exp(
        -np.arange(round(0.5 * SAMPLE_RATE)) / (0.11 * SAMPLE_RATE)
    )
    tail /= np.sqrt((tail**2).sum())
    answer = [convolve(side, tail, single=True) for side in near.T]
    return near + 0.5 * np.stack(answer, axis=-1)


def _crickets(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    out = silence(samples)
    for _ in range(5):
        pitch, chirps = rng.uniform(3900.0, 4800.0), rng.uniform(1.6, 2.9) / SAMPLE_RATE
        begun, strength = rng.uniform(), _slow(samples, 0.1, 3.0, rng)
        sides = np.array(pan_gains(rng.uniform(-0.9, 0.9))) * rng.uniform(0.2, 1.0)
        # Three strokes of the wings in each chirp, all of which are alike.
        length = int(CHIRP / chirps)
        t = np.arange(length)
        song = np.sin(2.0 * np.pi * pitch / SAMPLE_RATE * t)
        song *= np.sin(3.0 * np.pi / CHIRP * chirps * t) ** 2
        for start in ((np.arange(begun + samples * chirps) - begun) / chirps).tolist():
            first = max(round(start), 0)
            chirp = song[max(-round(start), 0) :]
            if first < samples:
                mix_in(out, first, chirp, tuple(sides * strength[first]))
    return out


def _rain(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    wash = _noise(samples, (900.0, 8500.0), rng, 0.35)
    wash /= np.sqrt(np.mean(wash**2))
    t = np.arange(round(0.004 * SAMPLE_RATE)) / SAMPLE_RATE
    drops = silence(samples)
    for pitch in (1400.0, 2300.0, 3600.0, 5200.0):
        drop = np.cos(2.0 * np.pi * pitch * t) * np.exp(-t / 0.0008)
        drop -= drop.mean()
        for side in range(2):
            count = int(rng.poisson(55.0 * samples / SAMPLE_RATE))
            strength = np.minimum(rng.exponential(1.0, count), 2.5)
            places = rng.integers(0, samples, count)[:, None] + np.arange(t.size)
            levels = np.outer(strength, drop)
            drops[:, side] += np.bincount(places.ravel(), levels.ravel(), samples)[:samples]
    drops *= 0.8 / max(float(np.sqrt(np.mean(drops**2))), 1e-12)
    wash += drops
    wash *= (gusts**0.4)[:, None]
    return wash


def _surf(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    swell = _slow(samples, 0.14, 5.0, rng)
    low = _noise(samples, (110.0, 700.0), rng, 0.7)
    foam = _noise(samples, (1100.0, 6500.0), rng, 0.5)
    later = np.roll(swell, round(1.1 * SAMPLE_RATE))
    return low * swell[:, None] + 7.0 * foam * (later**1.6)[:, None]


def _stream(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    wash = _noise(samples, (350.0, 2600.0), rng, 0.5)
    bubbles = _scattered(samples, 70.0, bubble, rng)
    scale = np.sqrt(np.mean(bubbles**2)) / max(float(np.sqrt(np.mean(wash**2))), 1e-12)
    return bubbles + 0.7 * scale * wash


def _crackle(rng: np.random.Generator) -> Signal:
    """Return a splinter that bursts: a click, now and then with a hiss."""
    t = np.arange(round(0.03 * SAMPLE_RATE)) / SAMPLE_RATE
    pitch = np.exp(rng.uniform(np.log(900.0), np.log(6000.0)))
    click = np.cos(2.0 * np.pi * pitch * t) * np.exp(-t / rng.uniform(0.0004, 0.002))
    hiss = rng.standard_normal(t.size) * np.exp(-t / 0.006) * 0.15 * (rng.random() < 0.3)
    return (click - click.mean() + hiss) * min(rng.exponential(1.0), 1.6)


def _fire(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    roar = _noise(samples, (70.0, 320.0), rng, 0.5) * _slow(samples, 3.0, 2.5, rng)[:, None]
    crackles = _scattered(samples, 34.0, _crackle, rng)
    scale = np.sqrt(np.mean(crackles**2)) / max(float(np.sqrt(np.mean(roar**2))), 1e-12)
    return crackles + 3.0 * scale * roar


def _room(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    return _noise(samples, (70.0, 300.0), rng, 0.8) * _slow(samples, 0.2, 0.8, rng)[:, None]


def _submerged(samples: int, gusts: Signal, rng: np.random.Generator) -> Signal:
    deep = _noise(samples, (55.0, 190.0), rng, 0.8) * gusts[:, None]
    bubbles = _scattered(samples, 2.5, bubble, rng)
    scale = np.sqrt(np.mean(deep**2)) / max(float(np.sqrt(np.mean(bubbles**2))), 1e-12)
    dull = np.stack([without_rumble(side) for side in deep.T], axis=-1)
    return dull + 0.25 * scale * bubbles


_Layer = Callable[[int, Signal, np.random.Generator], Signal]

_LAYERS: Mapping[str, _Layer] = {
    "wind": _wind,
    "leaves": _leaves,
    "birds": _birds,
    "crickets": _crickets,
    "rain": _rain,
    "surf": _surf,
    "stream": _stream,
    "fire": _fire,
    "room": _room,
    "submerged": _submerged,
}
"""Layers by the names of the attributes of an ambience."""
