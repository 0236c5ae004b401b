"""Sounds of motion without a blow: swooshes, squeaks, boings, breaths, cries and their kind.

Source: Sims 1987, 13.1.2; Peterson and Barney 1952 for the vowel of a cry.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from audio.banks import Signal
from audio.convolution import convolved
from audio.courses import Drive, read_at
from audio.grains import band_noise
from audio.grid import SAMPLE_RATE
from audio.heard import SPEED_POWER
from audio.names import folded
from audio.stick_slip import jolt, slipped, slips_a_second

# What air carries off vortices grows with the sixth power of speed; amplitude, with the third.
# Source: Curle 1955.
_AIR_POWER = 3.0
# Bands of a swoosh below its highest; further down nothing is heard.
_OCTAVES = 4.0
_RISE = int(0.003 * SAMPLE_RATE)
_HIGHEST = 12_000.0
# A child's cry [Hz], and the formants of the vowel of a mouth wide open, and how wide they are.
# Source: Peterson and Barney 1952, for children.
_CRY = 450.0
_OPEN_MOUTH, _WIDE = (1030.0, 1370.0, 3170.0), 160.0


@dataclass(frozen=True, slots=True)
class Driven:
    """What a motion's sound is made of.

    Attributes:
        drive: how fast it goes and how fast it is heard, at each sample.
        pitch: at its greatest speed [Hz].
        speed: its greatest [m/s].
    """

    drive: Drive
    pitch: float
    speed: float


Player = Callable[[Driven, Signal, np.random.Generator], Signal]
"""What is driven, the ring of what it is part of (K,), dice -> (N,)."""


@dataclass(frozen=True, slots=True)
class Motion:
    """How a kind of motion sounds.

    Attributes:
        instrument: of General MIDI that plays its notes.
        pitch: of a thing of 0.1 m [Hz].
        seconds: how long it lasts where the event does not say [s].
        play: makes the sound.
        level: against a blow of the same speed [dB]: air and joints take little of the energy.
        resonates: whether the modes of what moves are heard.
    """

    instrument: str
    pitch: float
    seconds: float
    play: Player
    level: float
    resonates: bool = False


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


def _envelope(drive: Drive, power: float, summit: float) -> Signal:
    """Return how loud a motion is at each sample: by its speed if known, else an arch: (N,)."""
    if drive.steady:
        return arch(drive.samples, summit)
    edge = np.arange(drive.samples) + 1.0
    ends = np.minimum(1, np.minimum(edge / _RISE, edge[::-1] / (2 * _RISE)))
    return np.asarray(ends * drive.share**power)


def _swoosh(driven: Driven, body: Signal, rng: np.random.Generator) -> Signal:
    drive, samples = driven.drive, driven.drive.samples
    # Vortices are shed at a rate that grows with speed (Strouhal), hence the band rises with it.
    top = float(np.clip(driven.pitch * driven.speed / 3, 150, 6000))
    loud = _envelope(drive, _AIR_POWER, 0.45)
    octaves = np.log2(np.maximum(loud if drive.steady else drive.share, 1e-3))
    lowest = int(np.ceil(-max(float(octaves.min()), -_OCTAVES)))
    sound = np.zeros(samples)
    for octave in range(lowest + 1):
        centre = top * 2.0**-octave
        noise = band_noise(samples, (centre, 1.6 * centre), rng)
        # Neighbouring bands share the power between them.
        near = np.clip(1 - np.abs(octaves + octave), 0, 1)
        if octave == lowest:
            near = np.where(octaves < -octave, 1.0, near)
        sound += np.sin(0.5 * np.pi * near) * noise
    sound = read_at(sound, drive.rate) * loud
    return np.asarray(sound - loud * (sound.sum() / loud.sum()))


def _tone(samples: int, frequency: Signal, overtones: tuple[float, ...]) -> Signal:
    # From the first sample on, a sine that rises.
    phase = 2 * np.pi * np.cumsum(frequency) / SAMPLE_RATE
    parts = [share * np.sin((k + 1) * phase) for k, share in enumerate(overtones)]
    return np.asarray(np.sum(parts, axis=0))[:samples]


def _wander(samples: int, depth: float, rng: np.random.Generator) -> Signal:
    """Return a slow random bend about 1: (samples,)."""
    knots = 1 + depth * rng.uniform(-1, 1, 8)
    return np.interp(np.linspace(0, 7, samples), np.arange(8), knots)


def _whistle(driven: Driven, body: Signal, rng: np.random.Generator) -> Signal:
    drive, samples = driven.drive, driven.drive.samples
    pitch = driven.pitch * (1 + 0.1 * min(driven.speed / 5, 2))
    # An aeolian tone: as high as it is fast (Strouhal).
    frequency = pitch * drive.share * drive.rate * _wander(samples, 0.02, rng)
    breath = 0.1 * band_noise(samples, (pitch, 1.5 * pitch), rng)
    tone = _tone(samples, np.minimum(frequency, _HIGHEST), (1.0, 0.08))
    return np.asarray((tone + breath) * _envelope(drive, _AIR_POWER, 0.3))


def _squeak(driven: Driven, body: Signal, rng: np.random.Generator) -> Signal:
    return _rasped(driven, body, (0.92, 1.12), 0.03, rng)


def _squawk(driven: Driven, body: Signal, rng: np.random.Generator) -> Signal:
    return _rasped(driven, body, (1.25, 0.8), 0.08, rng)


def _rasped(
    driven: Driven,
    body: Signal,
    bend: tuple[float, float],
    rough: float,
    rng: np.random.Generator,
) -> Signal:
    """Return a joint that sticks and slips: its slips, and what they ring.

    Args:
        driven: the joint.
        body: (K,) ring of the limb.
        bend: factors of its pitch at begin and end, where its speed is not known.
        rough: share by which slips come early or late.
        rng: of that.
    """
    drive, samples = driven.drive, driven.drive.samples
    top = driven.pitch * _wander(samples, rough, rng)
    if drive.steady:
        top *= np.linspace(*bend, samples)
    rate = slips_a_second(top, drive.share)
    slips = slipped(np.minimum(rate * drive.rate, _HIGHEST), rough, rng)
    jerk = convolved(slips, jolt(driven.pitch))
    sound = jerk / max(float(np.abs(jerk).max()), 1e-12)
    rung = convolved(sound, body)
    sound = 0.5 * sound + rung / max(float(np.abs(rung).max()), 1e-12)
    return np.asarray(sound * _envelope(drive, SPEED_POWER, 0.2))


def _boing(driven: Driven, body: Signal, rng: np.random.Generator) -> Signal:
    samples, pitch = driven.drive.samples, driven.pitch
    seconds = samples / SAMPLE_RATE
    t = np.arange(samples) / SAMPLE_RATE
    # A spring's tone is bent by its own swing, which dies away with it.
    swing = 0.28 * np.exp(-4 * t / seconds) * np.sin(2 * np.pi * rng.uniform(8.5, 10.5) * t)
    tone = _tone(samples, pitch * (1 + swing), (1.0, 0.45, 0.3, 0.12))
    ends = np.minimum(1, (samples - np.arange(samples)) / (0.01 * SAMPLE_RATE))
    return np.asarray(tone * np.exp(-5 * t / seconds) * ends)


def _breath(driven: Driven, body: Signal, rng: np.random.Generator) -> Signal:
    samples, pitch = driven.drive.samples, driven.pitch
    puff = arch(samples, 0.3)
    sound = puff * band_noise(samples, (0.6 * pitch, 2 * pitch), rng)
    return np.asarray(sound - puff * (sound.sum() / puff.sum()))


def _cry(driven: Driven, body: Signal, rng: np.random.Generator) -> Signal:
    """Return a voice that rises, breaks and falls: a row of pulses, and an open mouth."""
    samples, t = driven.drive.samples, np.linspace(0.0, 1.0, driven.drive.samples)
    bent = 0.82 + 0.36 * np.sin(np.pi * t**0.6) - 0.12 * t
    shaken = 1 + 0.02 * np.sin(2 * np.pi * rng.uniform(5.0, 7.0) * np.arange(samples) / SAMPLE_RATE)
    frequency = driven.pitch * bent * shaken * _wander(samples, 0.015, rng)
    # The smaller the throat, the higher the vowel too.
    formants = np.array(_OPEN_MOUTH) * (driven.pitch / _CRY) ** 0.4
    overtone = np.arange(1, max(int(_HIGHEST / (2 * driven.pitch)), 2))
    near = (overtone[:, None] * driven.pitch - formants) / _WIDE
    # Who screams presses: the higher overtones come out.
    shares = (1 / (1 + near**2)).sum(axis=1) / overtone ** (1.2 - 0.08 * min(driven.speed, 5.0))
    voice = _tone(samples, frequency, tuple((shares / shares.sum()).tolist()))
    breath = 0.06 * band_noise(samples, (1500.0, 6000.0), rng)
    sound = (voice + breath) * arch(samples, 0.25)
    return np.asarray(sound - arch(samples, 0.25) * (sound.sum() / arch(samples, 0.25).sum()))


def _hug(driven: Driven, body: Signal, rng: np.random.Generator) -> Signal:
    """Return cloth that is pressed, and two chests that meet softly."""
    samples = driven.drive.samples
    t = np.arange(samples) / SAMPLE_RATE
    thump = np.sin(2 * np.pi * driven.pitch * t) * np.exp(-t / 0.06)
    cloth = band_noise(samples, (500.0, 2200.0), rng)
    cloth /= max(float(np.abs(cloth).max()), 1e-12)
    puff = arch(samples, 0.3)
    sound = thump + 0.35 * cloth * puff
    return np.asarray(sound - puff * (sound.sum() / puff.sum()))


MOTIONS: dict[str, Motion] = {
    "swoosh": Motion("breath noise", 900, 0.4, _swoosh, -24.0),
    "whistle": Motion("whistle", 1500, 0.5, _whistle, -30.0),
    "squeak": Motion("guitar fret noise", 1300, 0.16, _squeak, -6.0, resonates=True),
    "squawk": Motion("muted trumpet", 480, 0.25, _squawk, -6.0, resonates=True),
    "boing": Motion("slap bass 1", 170, 0.7, _boing, -6.0),
    "push off": Motion("slap bass 1", 170, 0.5, _boing, -6.0),
    "breath": Motion("breath noise", 700, 0.8, _breath, -12.0),
    "cry": Motion("choir aahs", _CRY, 0.7, _cry, -6.0),
    "hug": Motion("voice oohs", 110, 0.45, _hug, -3.0),
}
