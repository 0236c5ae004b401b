"""Default voices of causes: the one registry from which score and sound take them.

An impact without an entry sounds by its materials alone. A new cause needs an entry in
`CAUSE_VOICES`, beside its configuration in `pipeline/spec/sound_thresholds.py` and its detector in
`pipeline/simulation/sound_detection`.

Source: Sims 1987, 13.1.2; Peterson and Barney 1952 for the vowel of a cry.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from audio.dsp import Signal, band_noise, convolve, resample, without_offset
from audio.loudness_at_listener import SPEED_EXPONENT
from audio.names import normalized_name
from audio.source_motion import SpeedProfile
from audio.stick_slip import slip_impulses, slip_pulse, slip_rate
from audio.time_grid import SAMPLE_RATE

# The sound power of vortices grows with the sixth power of speed; the amplitude with the third.
# Source: Curle 1955.
_AIR_EXPONENT = 3.0
# Bands of a swoosh below its highest; lower ones are inaudible.
_SWOOSH_OCTAVES = 4.0
# Attack of a sustained sound [samples].
_ATTACK = int(0.003 * SAMPLE_RATE)
_MAX_FREQUENCY = 12_000.0
# A child's cry, and the formants of the vowel of an open mouth and their width [Hz].
# Source: Peterson and Barney 1952, for children.
_CRY_PITCH = 450.0
_CRY_FORMANTS, _FORMANT_WIDTH = (1030.0, 1370.0, 3170.0), 160.0
# Frequencies of the swing of a spring and of the vibrato of a cry [Hz].
_SPRING_SWING, _VIBRATO = (8.5, 10.5), (5.0, 7.0)


@dataclass(frozen=True, slots=True)
class Motion:
    """Input of a motion's synthesis.

    Attributes:
        profile: speed over time.
        pitch: at the greatest speed [Hz].
        speed: the greatest [m/s].
    """

    profile: SpeedProfile
    pitch: float
    speed: float


Synthesizer = Callable[[Motion, Signal, np.random.Generator], Signal]
"""Motion, ring of the body that moves (K,), random numbers -> (N,)."""


@dataclass(frozen=True, slots=True)
class CauseVoice:
    """Default voice of a cause other than an impact.

    Attributes:
        instrument: General MIDI instrument of its notes.
        seconds: duration of an event that has none [s].
        level: relative to an impact at the same speed [dB]: friction and air radiate little.
    """

    instrument: str
    seconds: float
    level: float


@dataclass(frozen=True, slots=True)
class FrictionVoice(CauseVoice):
    """Voice of a body that rubs over a surface; materials give its sound.

    Attributes:
        rolls: whether roughness repeats with each turn.
    """

    rolls: bool = False


@dataclass(frozen=True, slots=True)
class MotionVoice(CauseVoice):
    """Voice of a motion without contact.

    Attributes:
        pitch: of a body of 0.1 m [Hz].
        synthesize: makes the sound.
        resonates: whether the modes of the body ring along.
    """

    pitch: float
    synthesize: Synthesizer
    resonates: bool = False


def cause_voice(cause: str) -> FrictionVoice | MotionVoice | None:
    """Return the default voice of a cause; None for an impact."""
    return CAUSE_VOICES.get(normalized_name(cause))


def arch(samples: int, peak: float) -> Signal:
    """Return an envelope that rises from its first sample to 1 and falls to 0: (samples,).

    Args:
        samples: length.
        peak: position of the maximum, 0 to 1.
    """
    x = (np.arange(samples) + 1.0) / (samples + 1.0)
    ramps = np.where(x < peak, x / peak, (1 - x) / (1 - peak))
    return np.asarray(np.sin(0.5 * np.pi * ramps) ** 2)


def _envelope(profile: SpeedProfile, exponent: float, peak: float) -> Signal:
    """Return the amplitude over time: by the speed if known, else an arch: (N,)."""
    if profile.is_steady:
        return arch(profile.samples, peak)
    edge = np.arange(profile.samples) + 1.0
    ends = np.minimum(1, np.minimum(edge / _ATTACK, edge[::-1] / (2 * _ATTACK)))
    return np.asarray(ends * profile.relative_speed**exponent)


def _swoosh(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    profile, samples = motion.profile, motion.profile.samples
    # Vortices are shed at a rate that grows with speed (Strouhal), hence the band rises with it.
    top = float(np.clip(motion.pitch * motion.speed / 3, 150, 6000))
    envelope = _envelope(profile, _AIR_EXPONENT, 0.45)
    octaves = np.log2(np.maximum(envelope if profile.is_steady else profile.relative_speed, 1e-3))
    lowest = int(np.ceil(-max(float(octaves.min()), -_SWOOSH_OCTAVES)))
    sound = np.zeros(samples)
    for octave in range(lowest + 1):
        center = top * 2.0**-octave
        noise = band_noise(samples, (center, 1.6 * center), rng)
        # Equal-power crossfade of neighbouring bands.
        weight = np.clip(1 - np.abs(octaves + octave), 0, 1)
        if octave == lowest:
            weight = np.where(octaves < -octave, 1.0, weight)
        sound += np.sin(0.5 * np.pi * weight) * noise
    return without_offset(resample(sound, profile.doppler) * envelope, envelope)


def _tone(frequency: Signal, partials: tuple[float, ...]) -> Signal:
    """Return harmonics that start as rising sines: (N,).

    Args:
        frequency: (N,) of the fundamental [Hz].
        partials: amplitudes of the harmonics, from the fundamental up.
    """
    phase = 2 * np.pi * np.cumsum(frequency) / SAMPLE_RATE
    parts = [amplitude * np.sin((k + 1) * phase) for k, amplitude in enumerate(partials)]
    return np.asarray(np.sum(parts, axis=0))


def _drift(samples: int, depth: float, rng: np.random.Generator) -> Signal:
    """Return a slow random variation around 1: (samples,)."""
    knots = 1 + depth * rng.uniform(-1, 1, 8)
    return np.interp(np.linspace(0, 7, samples), np.arange(8), knots)


def _whistle(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    profile, samples = motion.profile, motion.profile.samples
    pitch = motion.pitch * (1 + 0.1 * min(motion.speed / 5, 2))
    # An aeolian tone: its frequency is proportional to speed (Strouhal).
    frequency = pitch * profile.relative_speed * profile.doppler * _drift(samples, 0.02, rng)
    breath = 0.1 * band_noise(samples, (pitch, 1.5 * pitch), rng)
    tone = _tone(np.minimum(frequency, _MAX_FREQUENCY), (1.0, 0.08))
    return np.asarray((tone + breath) * _envelope(profile, _AIR_EXPONENT, 0.3))


def _squeak(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    return _stick_slip(motion, body, (0.92, 1.12), 0.03, rng)


def _squawk(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    return _stick_slip(motion, body, (1.25, 0.8), 0.08, rng)


def _stick_slip(
    motion: Motion,
    body: Signal,
    bend: tuple[float, float],
    roughness: float,
    rng: np.random.Generator,
) -> Signal:
    """Return the sound of a joint that sticks and slips: its slips, and the ring they excite.

    Args:
        motion: of the joint.
        body: (K,) ring of the limb.
        bend: factors of the pitch at start and end, used if the speed is not known.
        roughness: random deviation of the slips, as a share of their period.
        rng: of that.
    """
    profile, samples = motion.profile, motion.profile.samples
    top = motion.pitch * _drift(samples, roughness, rng)
    if profile.is_steady:
        top *= np.linspace(*bend, samples)
    rate = slip_rate(top, profile.relative_speed)
    slips = slip_impulses(np.minimum(rate * profile.doppler, _MAX_FREQUENCY), roughness, rng)
    pulses = convolve(slips, slip_pulse(motion.pitch))
    sound = pulses / max(float(np.abs(pulses).max()), 1e-12)
    ring = convolve(sound, body)
    sound = 0.5 * sound + ring / max(float(np.abs(ring).max()), 1e-12)
    return np.asarray(sound * _envelope(profile, SPEED_EXPONENT, 0.2))


def _boing(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    samples, pitch = motion.profile.samples, motion.pitch
    seconds = samples / SAMPLE_RATE
    t = np.arange(samples) / SAMPLE_RATE
    # A spring's tone is bent by its own swing, which decays with it.
    swing = 0.28 * np.exp(-4 * t / seconds) * np.sin(2 * np.pi * rng.uniform(*_SPRING_SWING) * t)
    tone = _tone(pitch * (1 + swing), (1.0, 0.45, 0.3, 0.12))
    ends = np.minimum(1, (samples - np.arange(samples)) / (0.01 * SAMPLE_RATE))
    return np.asarray(tone * np.exp(-5 * t / seconds) * ends)


def _breath(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    samples, pitch = motion.profile.samples, motion.pitch
    puff = arch(samples, 0.3)
    return without_offset(puff * band_noise(samples, (0.6 * pitch, 2 * pitch), rng), puff)


def _cry(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return a voice that rises, breaks and falls: glottal harmonics through formants."""
    samples, t = motion.profile.samples, np.linspace(0.0, 1.0, motion.profile.samples)
    bend = 0.82 + 0.36 * np.sin(np.pi * t**0.6) - 0.12 * t
    vibrato = 1 + 0.02 * np.sin(
        2 * np.pi * rng.uniform(*_VIBRATO) * np.arange(samples) / SAMPLE_RATE
    )
    frequency = motion.pitch * bend * vibrato * _drift(samples, 0.015, rng)
    # A smaller throat raises the formants too.
    formants = np.array(_CRY_FORMANTS) * (motion.pitch / _CRY_PITCH) ** 0.4
    harmonic = np.arange(1, max(int(_MAX_FREQUENCY / (2 * motion.pitch)), 2))
    offset = (harmonic[:, None] * motion.pitch - formants) / _FORMANT_WIDTH
    # A louder voice has stronger upper harmonics.
    tilt = 1.2 - 0.08 * min(motion.speed, 5.0)
    amplitudes = (1 / (1 + offset**2)).sum(axis=1) / harmonic**tilt
    voice = _tone(frequency, tuple((amplitudes / amplitudes.sum()).tolist()))
    breath = 0.06 * band_noise(samples, (1500.0, 6000.0), rng)
    envelope = arch(samples, 0.25)
    return without_offset((voice + breath) * envelope, envelope)


def _hug(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return the rustle of pressed cloth and the soft thump of two chests."""
    samples = motion.profile.samples
    t = np.arange(samples) / SAMPLE_RATE
    thump = np.sin(2 * np.pi * motion.pitch * t) * np.exp(-t / 0.06)
    cloth = band_noise(samples, (500.0, 2200.0), rng)
    cloth /= max(float(np.abs(cloth).max()), 1e-12)
    puff = arch(samples, 0.3)
    return without_offset(thump + 0.35 * cloth * puff, puff)


CAUSE_VOICES: dict[str, FrictionVoice | MotionVoice] = {
    "scuff": FrictionVoice("guitar fret noise", 0.14, -12.0),
    "slide": FrictionVoice("breath noise", 0.3, -12.0),
    "roll": FrictionVoice("seashore", 0.3, -18.0, rolls=True),
    "swoosh": MotionVoice("breath noise", 0.4, -24.0, 900, _swoosh),
    "whistle": MotionVoice("whistle", 0.5, -30.0, 1500, _whistle),
    "squeak": MotionVoice("guitar fret noise", 0.16, -6.0, 1300, _squeak, resonates=True),
    "squawk": MotionVoice("muted trumpet", 0.25, -6.0, 480, _squawk, resonates=True),
    "boing": MotionVoice("slap bass 1", 0.7, -6.0, 170, _boing),
    "push off": MotionVoice("slap bass 1", 0.5, -6.0, 170, _boing),
    "breath": MotionVoice("breath noise", 0.8, -12.0, 700, _breath),
    "cry": MotionVoice("choir aahs", 0.7, -6.0, _CRY_PITCH, _cry),
    "hug": MotionVoice("voice oohs", 0.45, -3.0, 110, _hug),
}
"""By normalised cause."""
