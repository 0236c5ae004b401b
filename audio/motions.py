"""Sounds of motion without a blow: swooshes, squeaks, boings, breaths and their kind.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from audio.banks import Signal
from audio.grains import band_noise
from audio.grid import SAMPLE_RATE
from audio.names import folded

# seconds, pitch [Hz], speed [m/s], rng -> (N,)
Player = Callable[[float, float, float, np.random.Generator], Signal]


@dataclass(frozen=True, slots=True)
class Motion:
    """How a kind of motion sounds.

    Attributes:
        instrument: of General MIDI that plays its notes.
        pitch: of a thing of 0.1 m [Hz].
        seconds: how long it lasts where the event does not say [s].
        play: makes the sound.
        level: against a blow of the same speed [dB]: air and joints take little of the energy.
    """

    instrument: str
    pitch: float
    seconds: float
    play: Player
    level: float


def motion_of(cause: str) -> Motion | None:
    """Return the motion that a cause names; None for a blow."""
    return MOTIONS.get(folded(cause))


def arch(samples: int, summit: float) -> Signal:
    """Return an envelope that rises from its first sample to 1 and falls to 0: (samples,).

    Args:
        samples: how many.
        summit: where the top lies, within 0 to 1.
    """
    x = (np.arange(samples) + 1.0) / (samples + 1.0)
    bent = np.where(x < summit, x / summit, (1 - x) / (1 - summit))
    return np.asarray(np.sin(0.5 * np.pi * bent) ** 2)


def _swoosh(seconds: float, pitch: float, speed: float, rng: np.random.Generator) -> Signal:
    samples = max(int(seconds * SAMPLE_RATE), 64)
    # Vortices are shed at a rate that grows with speed (Strouhal), hence the band rises with it.
    centre = float(np.clip(pitch * speed / 3, 150, 6000))
    near = band_noise(samples, (centre, 1.6 * centre), rng)
    far = band_noise(samples, (0.5 * centre, 0.8 * centre), rng)
    pass_by = arch(samples, 0.45)
    sound = pass_by * (pass_by * near + (1 - pass_by) * far)
    return np.asarray(sound - pass_by * (sound.sum() / pass_by.sum()))


def _tone(samples: int, frequency: Signal, overtones: tuple[float, ...]) -> Signal:
    # From the first sample on, a sine that rises.
    phase = 2 * np.pi * np.cumsum(frequency) / SAMPLE_RATE
    parts = [share * np.sin((k + 1) * phase) for k, share in enumerate(overtones)]
    return np.asarray(np.sum(parts, axis=0))[:samples]


def _wander(samples: int, depth: float, rng: np.random.Generator) -> Signal:
    """Return a slow random bend about 1: (samples,)."""
    knots = 1 + depth * rng.uniform(-1, 1, 8)
    return np.interp(np.linspace(0, 7, samples), np.arange(8), knots)


def _whistle(seconds: float, pitch: float, speed: float, rng: np.random.Generator) -> Signal:
    samples = max(int(seconds * SAMPLE_RATE), 64)
    frequency = pitch * _wander(samples, 0.02, rng) * (1 + 0.1 * min(speed / 5, 2))
    breath = 0.1 * band_noise(samples, (pitch, 1.5 * pitch), rng)
    return np.asarray((_tone(samples, frequency, (1.0, 0.08)) + breath) * arch(samples, 0.3))


def _squeak(seconds: float, pitch: float, speed: float, rng: np.random.Generator) -> Signal:
    samples = max(int(seconds * SAMPLE_RATE), 64)
    rise = np.linspace(0.92, 1.12, samples)
    frequency = pitch * rise * _wander(samples, 0.05, rng)
    # Stick and slip: a saw-tooth, rough at tens of slips a second.
    rough = 1 + 0.5 * np.sin(2 * np.pi * rng.uniform(45, 80) * np.arange(samples) / SAMPLE_RATE)
    tone = _tone(samples, frequency, (1.0, 0.5, 0.33, 0.25, 0.2))
    return np.asarray(tone * rough * arch(samples, 0.2))


def _squawk(seconds: float, pitch: float, speed: float, rng: np.random.Generator) -> Signal:
    samples = max(int(seconds * SAMPLE_RATE), 64)
    fall = np.linspace(1.25, 0.8, samples)
    frequency = pitch * fall * _wander(samples, 0.08, rng)
    return np.asarray(
        _tone(samples, frequency, (0.6, 1.0, 0.8, 0.7, 0.5, 0.3)) * arch(samples, 0.15)
    )


def _boing(seconds: float, pitch: float, speed: float, rng: np.random.Generator) -> Signal:
    samples = max(int(seconds * SAMPLE_RATE), 64)
    t = np.arange(samples) / SAMPLE_RATE
    # A spring's tone is bent by its own swing, which dies away with it.
    swing = 0.28 * np.exp(-4 * t / seconds) * np.sin(2 * np.pi * rng.uniform(8.5, 10.5) * t)
    tone = _tone(samples, pitch * (1 + swing), (1.0, 0.45, 0.3, 0.12))
    ends = np.minimum(1, (samples - np.arange(samples)) / (0.01 * SAMPLE_RATE))
    return np.asarray(tone * np.exp(-5 * t / seconds) * ends)


def _breath(seconds: float, pitch: float, speed: float, rng: np.random.Generator) -> Signal:
    samples = max(int(seconds * SAMPLE_RATE), 64)
    puff = arch(samples, 0.3)
    sound = puff * band_noise(samples, (0.6 * pitch, 2 * pitch), rng)
    return np.asarray(sound - puff * (sound.sum() / puff.sum()))


MOTIONS: dict[str, Motion] = {
    "swoosh": Motion("breath noise", 900, 0.4, _swoosh, -24.0),
    "whistle": Motion("whistle", 1500, 0.5, _whistle, -30.0),
    "squeak": Motion("guitar fret noise", 1300, 0.16, _squeak, -6.0),
    "squawk": Motion("muted trumpet", 480, 0.25, _squawk, -6.0),
    "boing": Motion("slap bass 1", 170, 0.7, _boing, -6.0),
    "push off": Motion("slap bass 1", 170, 0.5, _boing, -6.0),
    "breath": Motion("breath noise", 700, 0.8, _breath, -12.0),
}
