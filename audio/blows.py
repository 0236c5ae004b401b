"""What one event sounds like at the listener's distance, before its loudness and direction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from hashlib import blake2b
from math import log2

import numpy as np

from audio.banks import Bank, Signal, hit, lasting, ring, struck
from audio.courses import Drive, drive_of, read_at
from audio.grains import band_noise, settling
from audio.grid import SAMPLE_RATE
from audio.heard import SPEED_POWER
from audio.materials import Family, family_of
from audio.motions import Driven, Motion, motion_of
from audio.names import folded
from audio.rubs import rub_of
from audio.voices import Note

# Each kind of blow exists in this many variants, so that no two steps in a row are alike
# and yet a thousand steps cost sixteen syntheses.
_VARIANTS = 16
# Attenuation in air [dB per m and Hz²], a square law through 0.16 dB/m at 10 kHz.
# Source: ISO 9613-1:1993, at 20 °C and 50 % humidity.
_AIR = 1.6e-9
_LONGEST = 6.0
_SPOTS = 16
# What a joint is part of rings no longer than this while it rubs [s].
_IN_A_JOINT = 0.04
# How much louder the heavier side of what rolls is.
_LUMPY = 0.25
_LEAST_ONSET = 1e-4
# How loud the modes of what rubs are beside the rub itself.
_SHAKEN = 0.5
_FADE = int(0.005 * SAMPLE_RATE)


@dataclass(frozen=True, slots=True)
class Blow:
    """All that the shape of a sound hangs on; equal blows are synthesised once.

    Attributes:
        cause: of the event.
        material: of what strikes.
        surface: of what is struck.
        size: of what strikes [m].
        speed: [m/s], in steps of 3 dB.
        distance: [m], in doublings: air dulls what is far.
        pitch: that the author wants [Hz]; 0 to leave it to the size.
        decay: time to die away that the author wants [s]; 0 to leave it to the materials.
        duration: of a sound that lasts, as far as it is heard [s]; 0 for a blow.
        variant: which of several alike.
        spot: where along its longest axis a body is struck, in steps of a 16th; None if unknown.
        whole: duration of the whole of what lasts [s].
        speeds: of what lasts, at even times over the whole [m/s].
        nearings: how fast it comes nearer, at these times [m/s].
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
    whole: float = 0.0
    speeds: tuple[float, ...] = ()
    nearings: tuple[float, ...] = ()


def blow_of(note: Note, seed: int, occurrence: int, left: float) -> tuple[Blow, float]:
    """Return the blow of a note and a small change of its loudness [dB].

    Both vary with the seed and with what happened, never with what else is in the score.

    Args:
        note: the event with its voice.
        seed: of the score.
        occurrence: how many events with the same cause, time and parts come before.
        left: time to the end of the score [s]; no sound needs to last longer.
    """
    event = note.event
    happened = (event.frame, event.time, event.cause, event.who, event.part, event.other)
    chance = _generator(seed, *happened, occurrence)
    blow = Blow(
        cause=event.cause,
        material=event.material,
        surface=event.surface,
        size=event.size,
        speed=_stepped(float(np.clip(abs(event.strength), 0.02, 1e3)), 2),
        distance=_stepped(float(np.clip(event.distance, 1.0, 1e4)), 1),
        pitch=440 * 2 ** ((note.pitch - 69) / 12) if note.tuned else 0.0,
        decay=note.decay or 0.0,
        duration=min(event.duration, left),
        variant=int(chance.integers(_VARIANTS)),
        spot=None if event.spot is None else round(event.spot * _SPOTS) / _SPOTS,
        whole=event.duration,
        speeds=event.speeds,
        nearings=tuple(bearing.nearing for bearing in event.course),
    )
    return blow, float(chance.uniform(-0.8, 0.8))


def _stepped(value: float, steps_per_doubling: int) -> float:
    return float(2 ** (round(log2(value) * steps_per_doubling) / steps_per_doubling))


SHORTEST = 64 / SAMPLE_RATE
"""Least duration of a motion's sound [s]."""


def _generator(seed: int, *what: object) -> np.random.Generator:
    key = "\x1f".join(str(part) for part in (seed, *what)).encode("utf-8", "replace")
    return np.random.default_rng(int.from_bytes(blake2b(key, digest_size=16).digest()))


def sounded(blow: Blow, seed: int) -> Signal:
    """Return the sound of a blow, of peak 1, from the sample of its onset on: (N,)."""
    # The wish for another distance or speed must not change the dice.
    rng = _generator(seed, blow.cause, blow.material, blow.surface, blow.size, blow.variant)
    motion, rub = motion_of(blow.cause), rub_of(blow.cause)
    if motion is not None:
        sound = _moved(motion, blow, rng)
    elif rub is not None or blow.duration > 0:
        sound = _rubbed(blow, _driven(blow, rub.seconds if rub else 0.0), rng)
    else:
        sound = _struck(blow, rng)
    fade = min(_FADE, sound.size)
    sound[sound.size - fade :] *= np.cos(0.5 * np.pi * np.arange(fade) / fade) ** 2
    sound = _peaked(sound)
    # Whatever a sound does at its begin, its onset is to be found on its sample.
    sound[0] = np.copysign(max(abs(sound[0]), _LEAST_ONSET), sound[0])
    return sound


def _driven(blow: Blow, otherwise: float) -> Drive:
    """Return what drives a sound that lasts, as long as asked, as it does, or as is usual [s]."""
    # Shorter ones are no sound, and divide by next to nothing.
    seconds = max(blow.decay or blow.duration or otherwise, SHORTEST)
    return drive_of(int(seconds * SAMPLE_RATE), blow.whole, blow.speeds, blow.nearings)


def _moved(motion: Motion, blow: Blow, rng: np.random.Generator) -> Signal:
    pitch = blow.pitch or motion.pitch * (0.1 / blow.size) ** 0.5
    body = np.ones(1)
    if motion.resonates:
        own = family_of(blow.material, "wood")
        body = _ring(lasting(_own(own, own, replace(blow, pitch=0.0), rng), _IN_A_JOINT), blow)
    driven = Driven(_driven(blow, motion.seconds), float(np.clip(pitch, 30, 6000)), blow.speed)
    return motion.play(driven, body, rng)


def _struck(blow: Blow, rng: np.random.Generator) -> Signal:
    own, ground = family_of(blow.material, "wood"), family_of(blow.surface, "wood")
    contact = (own.softness + ground.softness) * blow.speed**-0.2 * (blow.size / 0.1) ** 0.3
    # Under a millisecond: the ear and the cut are to find the onset on its frame.
    taps = int(np.clip(round(contact * 1e-3 * SAMPLE_RATE), 1, 44))
    yielding = ground.softness / (own.softness + ground.softness)
    layers = [
        (1 - 0.6 * yielding) * _peaked(hit(_ring(_own(own, ground, blow, rng), blow), taps)),
        (0.35 + 0.5 * yielding) * _peaked(hit(_ring(_ground(ground, blow, rng), blow), taps)),
    ]
    for family in (own, ground):
        if family.noise is not None:
            band = (family.band[0], min(family.band[1], _air_edge(blow.distance)))
            settle = min(family.settle * blow.speed**0.25, blow.decay or 1.0)
            grains = settling(band, settle, family.grains, rng)
            layers.append(10 ** (family.noise / 20) * _peaked(grains))
    return _summed(layers)


def _own(own: Family, ground: Family, blow: Blow, rng: np.random.Generator) -> Bank:
    pitch = blow.pitch or own.pitch * (0.1 / blow.size) ** 0.8
    # What rests on soft ground cannot ring freely.
    damping = own.damping + 160 * ground.friction
    bank = struck(
        *(own.shape, float(np.clip(pitch, 40, 6000)), own.friction, damping, own.tilt),
        *(blow.spot, rng),
    )
    return lasting(bank, blow.decay) if blow.decay else bank


def _ground(ground: Family, blow: Blow, rng: np.random.Generator) -> Bank:
    pitch = ground.ground * rng.uniform(0.94, 1.06)
    bank = struck(
        *(ground.shape, pitch, ground.friction, ground.damping + 8, ground.tilt, None, rng)
    )
    return lasting(bank, blow.decay) if blow.decay else bank


def _ring(bank: Bank, blow: Blow) -> Signal:
    air = 10 ** (-_AIR * bank.frequency**2 * blow.distance / 20)
    longest = max(_LONGEST, blow.decay)
    samples = max(int(min(bank.seconds, longest) * SAMPLE_RATE), _FADE)
    return ring(replace(bank, amplitude=bank.amplitude * air), samples)


def _air_edge(distance: float) -> float:
    """Return the frequency that the air has dulled by 6 dB [Hz]."""
    return float(np.sqrt(6 / (_AIR * distance)))


def _rubbed(blow: Blow, drive: Drive, rng: np.random.Generator) -> Signal:
    """Return a scrape or a roll: grains of the surface that shake the body's modes.

    The surface is a profile that is read as fast as the body goes, so the noise sinks with its
    speed, while the modes stay where they are.
    """
    own, ground = family_of(blow.material, "wood"), family_of(blow.surface, "wood")
    samples = drive.samples
    low, high = ground.band
    band = (low, min(high, _air_edge(blow.distance)))
    rough = read_at(band_noise(samples, band, rng), drive.share * drive.rate)
    rough *= drive.share**SPEED_POWER
    if folded(blow.cause) == "roll":
        turns = np.cumsum(drive.share * drive.rate) * blow.speed / (np.pi * blow.size)
        rough *= 1 + _LUMPY * np.sin(2 * np.pi * turns / SAMPLE_RATE)
    body = _ring(lasting(_own(own, ground, blow, rng), 0.03), blow)
    # What shakes a body is how steep the profile is: read slowly, it hardly does.
    shaken = np.convolve(np.diff(rough, prepend=0.0), body[: 2 * _FADE])[:samples]
    sound = _peaked(rough) + _SHAKEN * _peaked(shaken)
    edge = np.arange(samples) + 1.0
    return np.asarray(sound * np.minimum(1, np.minimum(edge / 40, edge[::-1] / (4 * _FADE))))


def _peaked(sound: Signal) -> Signal:
    peak = float(np.max(np.abs(sound), initial=0.0))
    return sound / peak if peak > 0 else sound


def _summed(layers: list[Signal]) -> Signal:
    """Return the sum of layers that all begin at the onset, each towards the same side there."""
    whole = np.zeros(max(layer.size for layer in layers))
    for layer in layers:
        # Two layers that start against each other would hide the onset.
        whole[: layer.size] += layer if layer[0] >= 0 else -layer
    return whole
