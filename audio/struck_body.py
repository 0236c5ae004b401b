"""Struck bodies: what each side of an impact sounds like, kept for the next one like it.

Source of the attenuation in air: ISO 9613-1:1993, at 20 °C and 50 % humidity.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from audio.acoustic_materials import FAMILIES, family_of, solid_of
from audio.body_shape import BodyShape
from audio.dsp import Signal, grain_noise, without_rumble
from audio.modal_bank import ModalBank, audible_seconds, ring
from audio.modal_synthesis import body_bank, excited_modes, lowest_frequency
from audio.seeded import seeded
from audio.sound_cache import SoundCache
from audio.time_grid import SAMPLE_RATE

FADE = int(0.005 * SAMPLE_RATE)
"""Samples in which sounds end."""

# Attenuation in air [dB per m and Hz²], a square law through 0.16 dB/m at 10 kHz.
_AIR_ABSORPTION = 1.6e-9
# Longest ring without a configured decay [s].
_MAX_RING = 6.0
# Damping by air and by what a body lies on, per loss factor of the latter [1/s]; that of ground.
_AIR_DAMPING, _SUPPORT_DAMPING, _GROUND_DAMPING = 1.0, 160.0, 8.0
# The ground is large: wherever it is struck it sounds the same, in most of its modes.
_GROUND_SPOT = 0.35
# Lowest mode from which on a ring has no rumble [Hz]: its modes have no sum.
_CLEAR = 120.0


@dataclass(frozen=True, slots=True)
class Blow:
    """A blow on one body, or on the ground.

    Attributes:
        material: of the body.
        other: material of what it met.
        shape: of the body; None for the ground.
        contact: its duration [s].
        distance: of the listener [m].
        variant: number of the random variant.
        spot: point of impact along the longest axis, 0 to 1; None if unknown.
        pitch: configured pitch [Hz]; 0 for that of the body.
        decay: configured decay time [s]; 0 for that of the materials.
    """

    material: str
    other: str
    shape: BodyShape | None
    contact: float
    distance: float
    variant: int
    spot: float | None = None
    pitch: float = 0.0
    decay: float = 0.0


@dataclass(frozen=True, slots=True)
class Grains:
    """Grains that an impact scatters.

    Attributes:
        family: of the loose material.
        speed: of the impact [m/s].
        distance: of the listener [m].
        variant: number of the random variant.
        decay: configured decay time [s]; 0 for that of the material.
    """

    family: str
    speed: float
    distance: float
    variant: int
    decay: float = 0.0


def _struck(blow: Blow, seed: int) -> Signal:
    """Return the ring of a body after a blow, without rumble, from its upward onset on: (N,)."""
    length = 0.0 if blow.shape is None else blow.shape.length
    # The last bits of a length differ between classes of processor.
    key = blow.material, blow.other, f"{length:.6g}", blow.spot is None, blow.variant
    bank = body_modes(blow, seeded(seed, *key))
    signal = ring_in_air(bank, blow.distance, blow.decay, blow.contact)
    if bank.modes.lowest < _CLEAR:
        signal = without_rumble(signal)
    # Opposite signs would hide the onset.
    return signal if signal[0] >= 0 else -signal


def _scattered(grains: Grains, seed: int) -> Signal:
    """Return the noise of grains, without rumble, from its upward onset on: (N,)."""
    family = FAMILIES[grains.family]
    rng = seeded(seed, *(grains.family, grains.variant))
    low, high = family.grain_band
    band = low, min(high, air_cutoff(grains.distance))
    decay = min(family.grain_decay * grains.speed**0.25, grains.decay or 1.0)
    noise = without_rumble(grain_noise(band, decay, family.grain_rate, rng))
    return noise if noise[0] >= 0 else -noise


BLOWS, GRAINS = SoundCache(_struck, 2**22), SoundCache(_scattered, 2**20)
"""Sides of impacts in this process."""


def body_modes(blow: Blow, rng: np.random.Generator) -> ModalBank:
    """Return the modes of a body, or of the ground, that a blow excites.

    Args:
        blow: on the body.
        rng: of all that sets one blow apart from the next.
    """
    solid = solid_of(blow.material)
    if blow.shape is None:
        ground = family_of(blow.material)
        pitch = ground.ground * rng.uniform(0.94, 1.06)
        damping = ground.damping + _GROUND_DAMPING
        place = ground.tilt, _GROUND_SPOT, rng
        bank = excited_modes(ground.shape, pitch, solid.loss, damping, *place)
    else:
        shape = blow.shape
        # A body on soft ground cannot ring freely.
        damping = _AIR_DAMPING + _SUPPORT_DAMPING * solid_of(blow.other).loss
        if blow.pitch:
            # A body of this pitch is as much larger or smaller.
            shape = shape.scaled(lowest_frequency(shape, solid) / blow.pitch)
        bank = body_bank(shape, solid, damping, blow.spot, blow.pitch > 0, rng)
    return bank.with_decay_time(blow.decay) if blow.decay else bank


def ring_in_air(
    bank: ModalBank, distance: float, decay: float = 0.0, contact: float = 0.0
) -> Signal:
    """Return the ring of a body as air carries it: (N,).

    Args:
        bank: of the body.
        distance: of the listener [m].
        decay: configured decay time, by which the ring may be longer [s].
        contact: its duration [s]; that of an impulse is 0.
    """
    heard = bank.struck(contact).scaled(absorption(bank.frequency, distance))
    seconds = min(heard.seconds, audible_seconds([heard]), max(_MAX_RING, decay))
    samples = max(int(seconds * SAMPLE_RATE), FADE)
    # Other layers may last longer, and would not cover its end.
    return faded(ring([heard], samples, contact), min(FADE, samples // 4))


def absorption(frequency: Signal, distance: float) -> Signal:
    """Return what air leaves of frequencies [Hz] over a distance [m], as a factor."""
    return np.asarray(10 ** (-_AIR_ABSORPTION * frequency**2 * distance / 20))


def air_cutoff(distance: float) -> float:
    """Return the frequency that air attenuates by 6 dB over a distance [m], in Hz."""
    return float(np.sqrt(6 / (_AIR_ABSORPTION * distance)))


def faded(signal: Signal, samples: int) -> Signal:
    """Return a signal whose last samples fall smoothly to nothing, changed in place."""
    signal[signal.size - samples :] *= _fall(samples)
    return signal


@lru_cache(maxsize=16)
def _fall(samples: int) -> Signal:
    return np.asarray(np.cos(0.5 * np.pi * np.arange(samples) / samples) ** 2)
