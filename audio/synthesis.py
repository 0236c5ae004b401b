"""Synthesis of single sounds at the listener's distance, before their gain and direction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log2

import numpy as np
from scipy.fft import next_fast_len

from audio import footsteps
from audio.acoustic_materials import (
    FAMILIES,
    acoustic_name,
    family_name,
    family_of,
    solid_of,
    usual_shape,
)
from audio.body_shape import BodyShape
from audio.cause_voices import MotionVoice, cause_voice
from audio.dsp import (
    Signal,
    convolve,
    noise_at_rate,
    normalized,
    peak_of,
    without_rumble,
)
from audio.harmony import frequency_of
from audio.impact_contact import contact_seconds
from audio.loudness_at_listener import SPEED_EXPONENT
from audio.modal_bank import ModalBank
from audio.motion import Motion
from audio.notes import Note
from audio.score import ScoreEvent
from audio.seeded import random_pair, seeded
from audio.sound_cache import SoundCache
from audio.source_motion import SpeedProfile, speed_profile
from audio.struck_body import (
    BLOWS,
    FADE,
    GRAINS,
    Blow,
    Grains,
    absorption,
    air_cutoff,
    body_modes,
    faded,
    ring_in_air,
)
from audio.time_grid import SAMPLE_RATE

# Each kind of sound exists in this many variants: no two steps in a row are alike, and yet a
# thousand steps cost sixteen syntheses.
_VARIANTS = 16
# Variants of a blow whose place is known, because places and durations of contacts differ anyway,
# and of what is struck and of grains, because they sound beside the body.
_BLOW_VARIANTS = 4
# Steps in each octave: of the speed of a motion, whose pitch follows it, and of an impact on
# grains; of the length of the leg of a footstep, and of the duration of a contact.
_SPEEDS, _IMPACT_SPEEDS, _STEP_SIZES, _CONTACTS = 2, 1, 4, 3
# Distance below which air takes nothing that is heard: 0.6 dB at 10 kHz [m].
_NEAR = 4.0
# Random variation of the level [dB].
_LEVEL_JITTER = 0.8
# Steps of the point of impact along a body.
_SPOTS = 16
# Length of what air makes of an impulse [samples].
_AIR_RESPONSE = 256
# Longest ring of a limb while its joint rubs, and of a body that rubs [s].
_JOINT_RING, _FRICTION_RING = 0.04, 0.03
# Modulation of the rolling noise by the heavier side.
_ROLL_MODULATION = 0.25
# Level of the excited modes of a rubbing body relative to the friction noise.
_FRICTION_RESONANCE = 0.5
# Sizes that a body of unknown shape may have [m].
_SIZES = (1e-3, 100.0)
# Pitches of a motion [Hz]: from the beats of a large wing on.
_PITCHES = (3.0, 6000.0)
# Least speed of an impact [m/s].
_SLOWEST = 0.02
_MIN_ONSET = 2e-3
# Samples in which a scrape comes up.
_RISE = 40

SHORTEST_CONTACT = 1 / SAMPLE_RATE
"""Duration of a contact that sounds like any shorter one [s]."""

MIN_DURATION = 64 / SAMPLE_RATE
"""Least duration of a sustained sound [s]."""


@dataclass(frozen=True, slots=True)
class SoundParameters:
    """All parameters of a sound's synthesis; equal ones are synthesised once.

    Attributes:
        cause: of the event.
        material: of the body that sounds, without its colour.
        surface: material of what it met, likewise.
        size: of the body [m]; of a footstep the length of the leg, in quarters of an octave.
        speed: [m/s], in steps of 3 dB; of a footstep and of an impact on grains in steps of 6 dB;
            0 of other impacts, which differ by the duration of their contacts alone.
        distance: [m], in powers of two, for the absorption of air.
        pitch: configured pitch [Hz]; 0 for the pitch of the size.
        decay: configured decay time [s]; 0 for that of the materials.
        duration: audible duration of a sustained sound [s]; 0 for an impact.
        variant: number of the random variant.
        spot: point of impact along the longest axis, in steps of a 16th; None if unknown. Mirror
            images of a point are the same.
        contact: duration of the contact of an impact, in thirds of an octave [s].
        shape: of the body; None for that usual for its material.
        struck_shape: of the body that it met; None for the ground.
        full_duration: of the sustained sound, with the part after the end of the score [s].
        speeds: of a sustained sound, at even times over the full duration [m/s].
        approach_speeds: rates at which its distance shrinks, at these times [m/s].
    """

    cause: str
    material: str
    surface: str
    size: float
    speed: float
    distance: float
    pitch: float
    decay: float
    duration: float
    variant: int
    spot: float | None = None
    contact: float = SHORTEST_CONTACT
    shape: BodyShape | None = None
    struck_shape: BodyShape | None = None
    full_duration: float = 0.0
    speeds: tuple[float, ...] = ()
    approach_speeds: tuple[float, ...] = ()


def sound_parameters(
    note: Note, seed: int, occurrence: int, remaining: float
) -> tuple[SoundParameters, float]:
    """Return the parameters of a note's sound and a random variation of its level [dB].

    Both depend on the seed and the event, never on other events.

    Args:
        note: the event with its voice.
        seed: of the score.
        occurrence: number of earlier events with the same key.
        remaining: time to the end of the score [s].
    """
    event, key = note.event, note.event.key
    material, surface = acoustic_name(event.material), acoustic_name(event.surface)
    is_step = _is_footstep(event.cause, note.tuned, note.decay or 0.0)
    if is_step:
        # Steps of like feet share their syntheses, wherever they strike and however hard.
        size = _quantized(float(np.clip(event.size, *_SIZES)), _STEP_SIZES)
        event = replace(event, size=size, spot=None, energy=0.0, shape=None, struck_shape=None)
    of_variant, of_level = random_pair(seed, *key, occurrence)
    speed, contact = min(max(abs(event.strength), _SLOWEST), 1e3), SHORTEST_CONTACT
    steps, variants = _SPEEDS, _VARIANTS
    if cause_voice(event.cause) is None and not event.duration:
        contact = _quantized(max(_contact_seconds(event, speed), SHORTEST_CONTACT), _CONTACTS)
        steps = _IMPACT_SPEEDS
        families = family_of(event.material), family_of(event.surface)
        if not is_step and all(family.grain_level is None for family in families):
            speed = 0.0
        if event.spot is not None:
            variants = _BLOW_VARIANTS
    parameters = SoundParameters(
        cause=event.cause,
        material=material,
        surface=surface,
        size=event.size,
        speed=_quantized(speed, steps) if speed else 0.0,
        distance=_quantized(min(max(event.distance, _NEAR), 1e4), 1),
        pitch=frequency_of(note.pitch) if note.tuned else 0.0,
        decay=note.decay or 0.0,
        duration=min(event.duration, remaining),
        variant=int(variants * of_variant),
        spot=_spot(event),
        contact=contact,
        shape=event.shape,
        struck_shape=event.struck_shape,
        full_duration=event.duration,
        speeds=event.speeds,
        approach_speeds=tuple(bearing.approach_speed for bearing in event.course),
    )
    return parameters, (2 * of_level - 1) * _LEVEL_JITTER


def _is_footstep(cause: str, is_tuned: bool, decay: float) -> bool:
    """Return whether a sound is a step in its stages; one that is tuned plays its note instead."""
    return cause == footsteps.CAUSE and not is_tuned and not decay


def _spot(event: ScoreEvent) -> float | None:
    """Return the point of impact, on the first half of a body that is its own mirror image."""
    if event.spot is None:
        return None
    spot = round(event.spot * _SPOTS) / _SPOTS
    is_vessel = event.shape is not None and event.shape.kind == "vessel"
    return spot if is_vessel else min(spot, 1.0 - spot)


def _contact_seconds(event: ScoreEvent, speed: float) -> float:
    """Return how long bodies touch that meet at a speed [m/s]."""
    solids = solid_of(event.material), solid_of(event.surface)
    shape = event.shape or _usual_shape(event.material, event.size)
    mass = 2 * event.energy / speed**2 if event.energy > 0 else shape.volume * solids[0].density
    curvature = 1 / shape.contact_radius
    if event.struck_shape is not None:
        other = event.struck_shape.volume * solids[1].density
        mass = mass * other / (mass + other)
        curvature += 1 / event.struck_shape.contact_radius
    return contact_seconds(solids, 1 / curvature, mass, speed)


def _quantized(value: float, steps_per_doubling: int) -> float:
    return float(2 ** (round(log2(value) * steps_per_doubling) / steps_per_doubling))


def synthesize(sound: SoundParameters, seed: int) -> Signal:
    """Return a sound of peak 1 from the sample of its onset on: (N,)."""
    # Distance and speed are left out, so that changing them keeps the random numbers. The last
    # bits of a size differ between classes of processor.
    size = f"{sound.size:.6g}"
    rng = seeded(seed, sound.cause, sound.material, sound.surface, size, sound.variant)
    voice = cause_voice(sound.cause)
    if isinstance(voice, MotionVoice):
        signal = _motion(voice, sound, rng)
    elif voice is not None or sound.duration > 0:
        rolls = voice is not None and voice.rolls
        signal = _friction(sound, _profile(sound, voice.seconds if voice else 0.0), rolls, rng)
    elif _is_footstep(sound.cause, sound.pitch > 0, sound.decay):
        parts = (sound.material, sound.surface, sound.size, sound.speed)
        signal = _through_air(footsteps.footstep(*parts, rng), sound.distance)
    else:
        return _finished(_impact(sound, seed))
    return _finished(without_rumble(signal))


def _finished(signal: Signal) -> Signal:
    """Return a sound of peak 1 with an end and an onset: (N,)."""
    signal = faded(signal, min(FADE, signal.size))
    signal *= 1 / max(peak_of(signal), 1e-300)
    # The onset must be detectable on its sample.
    signal[0] = np.copysign(max(abs(signal[0]), _MIN_ONSET), signal[0])
    return signal


def _through_air(signal: Signal, distance: float) -> Signal:
    """Return a sound as it arrives over a distance [m], duller: (N,)."""
    if distance <= _NEAR:
        return signal
    # FFTs of prime lengths are slow, and the end must not come round to the onset.
    size = next_fast_len(signal.size + _AIR_RESPONSE, real=True)
    frequency = np.fft.rfftfreq(size, 1 / SAMPLE_RATE).astype(np.float64)
    spectrum = np.fft.rfft(signal, size) * absorption(frequency, distance)
    return np.asarray(np.fft.irfft(spectrum, size)[: signal.size])


def _profile(sound: SoundParameters, default_duration: float) -> SpeedProfile:
    seconds = max(sound.decay or sound.duration or default_duration, MIN_DURATION)
    samples = int(seconds * SAMPLE_RATE)
    return speed_profile(samples, sound.full_duration, sound.speeds, sound.approach_speeds)


def _motion(voice: MotionVoice, sound: SoundParameters, rng: np.random.Generator) -> Signal:
    pitch = sound.pitch or voice.pitch_of(sound.size)
    body = np.ones(1)
    if voice.resonates:
        bank = _own_modes(replace(sound, pitch=0.0, surface=sound.material), rng)
        body = ring_in_air(bank.with_decay_time(_JOINT_RING), sound.distance)
    motion = Motion(_profile(sound, voice.seconds), float(np.clip(pitch, *_PITCHES)), sound.speed)
    return voice.synthesize(motion, body, rng)


def _impact(sound: SoundParameters, seed: int) -> Signal:
    """Return the sound of an impact, without rumble: (N,)."""
    body = sound.material, sound.surface, _shape(sound), sound.contact, sound.distance
    struck = sound.surface, sound.material, sound.struck_shape, sound.contact, sound.distance
    few = sound.variant % _BLOW_VARIANTS
    blows = (
        Blow(*body, sound.variant, spot=sound.spot, pitch=sound.pitch, decay=sound.decay),
        Blow(*struck, few, decay=sound.decay),
    )
    rings = [BLOWS.sound(blow, seed) for blow in blows]
    if sound.struck_shape is None:
        # The ground yields the more, the softer it is.
        young = solid_of(sound.material).young
        compliance = young / (young + solid_of(sound.surface).young)
        level = 0.15 if sound.pitch else 0.15 + 0.35 * min(compliance, 1.0)
        layers = [(1 - level, rings[0]), (level, rings[1])]
    else:
        layers = [(1.0, _sum(rings))]
    for name in (family_name(sound.material), family_name(sound.surface)):
        level_db = FAMILIES[name].grain_level
        if level_db is not None:
            grains = Grains(name, sound.speed, sound.distance, few, sound.decay)
            layers.append((10 ** (level_db / 20), GRAINS.sound(grains, seed)))
    return _sum([(peak / max(peak_of(layer), 1e-300)) * layer for peak, layer in layers])


def _shape(sound: SoundParameters) -> BodyShape:
    return sound.shape or _usual_shape(sound.material, sound.size)


def _usual_shape(material: str, size: float) -> BodyShape:
    return usual_shape(material, min(max(size, _SIZES[0]), _SIZES[1]))


def _friction(
    sound: SoundParameters, profile: SpeedProfile, rolls: bool, rng: np.random.Generator
) -> Signal:
    """Return a scrape or a roll: surface roughness that excites the body's modes.

    The roughness is a profile read at the speed of the body, so the noise falls in pitch with the
    speed while the modes keep their frequencies.
    """
    ground = family_of(sound.surface)
    low, high = ground.grain_band
    band = (low, min(high, air_cutoff(sound.distance)))
    pace = profile.relative_speed * profile.doppler
    noise = noise_at_rate(band, pace, rng)
    noise *= profile.raised(SPEED_EXPONENT)
    if rolls:
        turns = np.cumsum(pace) * sound.speed / (np.pi * sound.size)
        noise *= 1 + _ROLL_MODULATION * np.sin(2 * np.pi * turns / SAMPLE_RATE)
    bank = _own_modes(sound, rng).with_decay_time(_FRICTION_RING)
    body = ring_in_air(bank, sound.distance)
    # The slope of the profile excites the body: read slowly, it hardly does.
    excited = convolve(np.diff(noise, prepend=0.0), body[: 2 * FADE], single=True)
    signal = normalized(noise)
    excited *= _FRICTION_RESONANCE / max(peak_of(excited), 1e-300)
    signal += excited
    rise, fall = signal[:_RISE], signal[-4 * FADE :]
    rise *= np.arange(1.0, rise.size + 1) / _RISE
    fall *= np.arange(fall.size, 0.0, -1.0) / (4 * FADE)
    return signal


def _own_modes(sound: SoundParameters, rng: np.random.Generator) -> ModalBank:
    """Return the modes of a body that rubs on another."""
    body = sound.material, sound.surface, _shape(sound)
    when = sound.contact, sound.distance, sound.variant
    return body_modes(Blow(*body, *when, sound.spot, sound.pitch, sound.decay), rng)


def _sum(layers: list[Signal]) -> Signal:
    """Return the sum of layers from their common onset on."""
    whole = np.zeros(max(layer.size for layer in layers))
    for layer in layers:
        whole[: layer.size] += layer
    return whole


SOUNDS = SoundCache(synthesize, 2**23)
"""The sounds of this process, 64 MiB of them: a track and its stems share them."""
