"""Default voices of causes: the one registry from which score and sound take them.

An impact without an entry sounds by its materials alone. A new cause needs an entry in
`CAUSE_VOICES`, beside its configuration in `pipeline/spec/sound_thresholds.py` and its detector in
`pipeline/simulation/sound_detection`.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from audio.dsp import Signal, band_noise, convolve, resample, shared_noise, without_offset
from audio.loudness_at_listener import SPEED_EXPONENT
from audio.motion import MAX_FREQUENCY, Motion, arch, drift, tone
from audio.names import normalized_name
from audio.source_motion import SpeedProfile
from audio.stick_slip import slip_impulses, slip_pulse, slip_rate
from audio.time_grid import SAMPLE_RATE
from audio.vocal_tract import (
    ANIMAL_PITCH,
    ANIMAL_SLOPE,
    PERSON_PITCH,
    breath,
    call,
    cry,
    gasp,
    growl,
    laugh,
    whine,
)
from audio.wing_beats import WING_PITCH, WING_SLOPE, wings

# The sound power of vortices grows with the sixth power of speed; the amplitude with the third.
# Source: Curle 1955.
_AIR_EXPONENT = 3.0
# Bands of a swoosh below its highest; lower ones are inaudible.
_SWOOSH_OCTAVES = 4.0
# Attack of a sustained sound [samples].
_ATTACK = int(0.003 * SAMPLE_RATE)
# Frequencies of the swing of a spring [Hz].
_SPRING_SWING = (8.5, 10.5)


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
        slope: power of the size with which the pitch falls.
    """

    pitch: float
    synthesize: Synthesizer
    resonates: bool = False
    slope: float = 0.5

    def pitch_of(self, size: float) -> float:
        """Return the pitch of a body of a size [m], in Hz."""
        return self.pitch * (0.1 / size) ** self.slope


def cause_voice(cause: str) -> FrictionVoice | MotionVoice | None:
    """Return the default voice of a cause; None for an impact."""
    return CAUSE_VOICES.get(normalized_name(cause))


def _envelope(profile: SpeedProfile, exponent: float, peak: float) -> Signal:
    """Return the amplitude over time: by the speed if known, else an arch: (N,)."""
    if profile.is_steady:
        return arch(profile.samples, peak)
    edge = np.arange(profile.samples) + 1.0
    ends = np.minimum(1, np.minimum(edge / _ATTACK, edge[::-1] / (2 * _ATTACK)))
    return np.asarray(ends * profile.raised(exponent))


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


def _whistle(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    profile, samples = motion.profile, motion.profile.samples
    pitch = motion.pitch * (1 + 0.1 * min(motion.speed / 5, 2))
    # An aeolian tone: its frequency is proportional to speed (Strouhal).
    frequency = pitch * profile.relative_speed * profile.doppler * drift(samples, 0.02, rng)
    air = 0.1 * band_noise(samples, (pitch, 1.5 * pitch), rng)
    sung = tone(np.minimum(frequency, MAX_FREQUENCY), (1.0, 0.08))
    return np.asarray((sung + air) * _envelope(profile, _AIR_EXPONENT, 0.3))


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
    top = motion.pitch * drift(samples, roughness, rng)
    if profile.is_steady:
        top *= np.linspace(*bend, samples)
    rate = slip_rate(top, profile.relative_speed)
    slips = slip_impulses(np.minimum(rate * profile.doppler, MAX_FREQUENCY), roughness, rng)
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
    sung = tone(pitch * (1 + swing), (1.0, 0.45, 0.3, 0.12))
    ends = np.minimum(1, (samples - np.arange(samples)) / (0.01 * SAMPLE_RATE))
    return np.asarray(sung * np.exp(-5 * t / seconds) * ends)


def _rustle(motion: Motion, body: Signal, rng: np.random.Generator) -> Signal:
    """Return cloth that rubs on cloth: a soft noise that follows the speed, in small creases."""
    profile, samples = motion.profile, motion.profile.samples
    low = shared_noise(samples, (350.0, 1800.0), rng)
    high = shared_noise(samples, (1800.0, 6500.0), rng)
    creases = np.abs(shared_noise(samples, (18.0, 70.0), rng))
    speed = arch(samples, 0.4) if profile.is_steady else profile.relative_speed
    edge = np.arange(samples) + 1.0
    ends = np.minimum(1.0, np.minimum(edge / _ATTACK, edge[::-1] / (8 * _ATTACK)))
    # Faster cloth is brighter.
    return np.asarray(ends * speed * (0.4 + creases) * ((1.0 - 0.6 * speed) * low + speed * high))


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
    "wings": MotionVoice("breath noise", 1.0, -21.0, WING_PITCH, wings, slope=WING_SLOPE),
    "rustle": MotionVoice("breath noise", 0.4, -18.0, 900, _rustle),
    "boing": MotionVoice("slap bass 1", 0.7, -6.0, 170, _boing),
    "push off": MotionVoice("slap bass 1", 0.5, -6.0, 170, _boing),
    "breath": MotionVoice("breath noise", 0.8, -12.0, 700, breath),
    "cry": MotionVoice("choir aahs", 0.7, -6.0, PERSON_PITCH, cry),
    "laugh": MotionVoice("voice oohs", 1.1, -9.0, PERSON_PITCH, laugh),
    "gasp": MotionVoice("breath noise", 0.45, -9.0, PERSON_PITCH, gasp),
    "call": MotionVoice("french horn", 0.6, -3.0, ANIMAL_PITCH, call, slope=ANIMAL_SLOPE),
    "growl": MotionVoice("tuba", 0.9, -6.0, ANIMAL_PITCH, growl, slope=ANIMAL_SLOPE),
    "whine": MotionVoice("oboe", 0.8, -9.0, ANIMAL_PITCH, whine, slope=ANIMAL_SLOPE),
    "hug": MotionVoice("voice oohs", 0.45, -3.0, 110, _hug),
}
"""By normalised cause."""
