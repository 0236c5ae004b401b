"""Footsteps: the stages of a step, each in the grains and the ring of its ground.

A foot comes down with its heel, rolls, slaps down its ball and pushes off; a hoof or claw strikes
twice. Loose ground answers each stage with many small collisions of its own grains, which are
short resonances at random times, snow with a creak besides, and floors with their modes. No two
steps have the same times, levels and grains.

Sources: Cook 1997 (PhISM) for grains; Fontana and Bresin 2003 for ground that is crushed;
Turchet et al. 2010 for heel and toe and the materials.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from audio.acoustic_materials import family_name, family_of, solid_of
from audio.bubbles import bubble
from audio.dsp import Signal, band_noise, convolve, normalized, shared_noise
from audio.impact_contact import contact_seconds
from audio.modal_bank import ring
from audio.modal_synthesis import excited_modes
from audio.time_grid import SAMPLE_RATE

CAUSE = "footfall"

HARD = frozenset({"chitin", "bone", "stone", "brick", "metal", "glass", "ice", "plastic"})
"""Families of feet that strike without rolling: hooves, claws, shells."""

LEG = 0.95
"""Length of a person's leg, by which all others are measured [m]."""

LEG_MASS, HEEL_RADIUS = 6.0, 0.03
"""Of such a leg, as far as it takes part in a blow [kg], and of its heel [m]."""

CONTACT = (1e-4, 1.2e-3)
"""Shortest and longest contact of a blow [s]."""

ONSET = 0.03
"""Least level of the first sample, beside the peak."""

STOOD_ON = 40.0
"""Damping of a floor by whoever stands on it [1/s]."""

HEEL_TO_TOE, TWO_TICKS = 0.105, 0.032
"""Time from heel to ball of a walking person, and between the two strikes of a hoof [s]."""

PUSH = (2.3, 3.1)
"""When the foot pushes off, in times from heel to ball."""

TAIL = 0.14
"""Time after the last stage that is kept [s]."""

SLAP = 2048
"""Samples of the slap of a sole, which has fallen by 100 dB then."""

SLAP_FALL = np.exp(-np.arange(SLAP) / (0.0035 * SAMPLE_RATE))
"""Level of the slap at each of them."""

BUBBLES = 7
"""Number of them under a foot in water."""

CREST_WINDOW = round(0.05 * SAMPLE_RATE)
"""Samples over which the ear takes the mean of a step."""

RESONATORS = 9
"""Kinds of grains of one step."""


RUBBED = 3000.0
"""Least rate of grains under a foot that rolls or pushes off, which rubs them all [1/s]."""

SINKS, PULLED_FREE = 1.8, 1.7
"""Time for which claws and hooves crush loose ground, and level at which they leave it, beside a
sole: they are small, sink in and are pulled out."""

CLAW_CREST, SOLE_CREST, FIRM_CREST = 4.0, 8.0, 10.0
"""Level at which loose ground gives way under claws and soles, and soles on a floor are pressed
flat, above the mean of the loudest 50 ms [dB]."""


@dataclass(frozen=True, slots=True)
class LooseGround:
    """How ground of grains answers a stage.

    Attributes:
        band: of the grains' resonances [Hz].
        rate: grains a second at the strongest.
        grain: time in which a grain falls by 60 dB [s].
        spread: duration of a stage [s].
        thump: frequency of the dull blow below [Hz].
        weight: level of that blow beside the grains.
        creak: level of the creak of snow beside the grains.
        drops: level of bubbles beside the grains.
    """

    band: tuple[float, float]
    rate: float
    grain: float
    spread: float
    thump: float
    weight: float
    creak: float = 0.0
    drops: float = 0.0


GROUNDS: Mapping[str, LooseGround] = {
    "soil": LooseGround((240, 2000), 1100, 0.007, 0.055, 88, 0.40),
    "grass": LooseGround((2400, 9000), 900, 0.004, 0.065, 70, 0.40),
    "sand": LooseGround((1700, 6500), 9000, 0.0015, 0.075, 62, 0.28),
    "gravel": LooseGround((1300, 7000), 520, 0.009, 0.065, 95, 0.22),
    "snow": LooseGround((500, 2300), 2600, 0.004, 0.110, 55, 0.30, creak=0.5),
    "water": LooseGround((900, 5200), 500, 0.010, 0.110, 110, 0.30, drops=0.9),
}


@dataclass(frozen=True, slots=True)
class Stage:
    """A stage of a step.

    Attributes:
        at: after the first touch [s].
        level: relative to the first.
        spread: its duration relative to that of a strike.
        strikes: whether it is a blow; rolling and pushing off rub alone.
    """

    at: float
    level: float
    spread: float
    strikes: bool


def footstep(
    material: str, surface: str, size: float, speed: float, rng: np.random.Generator
) -> Signal:
    """Return a step from its first touch on: (N,).

    Args:
        material: of the foot.
        surface: of the ground.
        size: of the leg [m].
        speed: at which it comes down [m/s].
        rng: of all that sets one step apart from the next.
    """
    is_hard = family_name(material) in HARD
    stages = list(_stages(is_hard, size, speed, rng))
    samples = round((stages[-1].at + TAIL) * SAMPLE_RATE)
    loose = GROUNDS.get(family_name(surface))
    sound = np.zeros(samples)
    for stage in stages:
        start = round(stage.at * SAMPLE_RATE)
        level = stage.level
        if loose is not None:
            part = _crushed(loose, stage, size, rng, SINKS if is_hard else 1.0)
            level *= PULLED_FREE if is_hard and not stage.strikes else 1.0
        else:
            part = _struck(material, surface, stage, size, speed, rng)
        part = part[: samples - start]
        sound[start : start + part.size] += level * part
    crest = FIRM_CREST if loose is None else CLAW_CREST if is_hard else SOLE_CREST
    sound = yielding(sound, crest)
    # The first touch is heard on its sample.
    least = ONSET * float(np.abs(sound).max())
    sound[0] = np.copysign(max(abs(float(sound[0])), least), sound[0])
    return sound


def _stages(is_hard: bool, size: float, speed: float, rng: np.random.Generator) -> Iterator[Stage]:
    """Yield the stages of a step in their order; small and fast feet take less time."""
    pace = float(np.clip((size / LEG) ** 0.5 * max(speed, 0.1) ** -0.2, 0.3, 1.6))
    if is_hard:
        second = TWO_TICKS * pace * rng.uniform(0.8, 1.3)
        yield Stage(0.0, 1.0, 0.7, True)
        yield Stage(second, rng.uniform(0.35, 0.6), 0.6, True)
        yield Stage(
            second + 0.09 * pace * rng.uniform(0.9, 1.3), rng.uniform(0.08, 0.2), 1.2, False
        )
        return
    toe = HEEL_TO_TOE * pace * rng.uniform(0.85, 1.2)
    yield Stage(0.0, 1.0, 1.0, True)
    yield Stage(0.35 * toe, rng.uniform(0.08, 0.18), 1.2, False)
    yield Stage(toe, rng.uniform(0.55, 0.9), 0.9, True)
    yield Stage(toe * rng.uniform(*PUSH), rng.uniform(0.10, 0.26), 1.0, False)


def yielding(sound: Signal, crest_db: float) -> Signal:
    """Return a sound whose peaks bend below a level: (N,).

    Its peaks become lower, while its loudness, a mean over hundredths of a second, hardly does.

    Args:
        sound: (N,).
        crest_db: that level, above the mean of the loudest 50 ms [dB].
    """
    power = np.cumsum(np.pad(sound * sound, (CREST_WINDOW, 0)))
    loudest = float((power[CREST_WINDOW:] - power[:-CREST_WINDOW]).max(initial=0.0))
    level = 10 ** (crest_db / 20) * np.sqrt(max(loudest, 1e-30) / CREST_WINDOW)
    return np.asarray(level * np.tanh(sound / level))


def _crushed(
    ground: LooseGround, stage: Stage, size: float, rng: np.random.Generator, longer: float
) -> Signal:
    """Return the answer of loose ground to a stage, of peak 1: (N,).

    Args:
        ground: that is stepped on.
        stage: of the step.
        size: of the leg [m].
        rng: of all that sets one step apart from the next.
        longer: than that of a sole it lasts, as a factor.
    """
    spread = longer * ground.spread * stage.spread * rng.uniform(0.8, 1.25)
    samples = round((spread + 0.05) * SAMPLE_RATE)
    t = np.arange(samples) / SAMPLE_RATE
    # Most grains give way at once, the others as they settle; what only rubs swells and ebbs.
    envelope = np.exp(-4.0 * t / spread) if stage.strikes else np.sin(np.pi * t / t[-1]) ** 2
    rate = ground.rate if stage.strikes else max(ground.rate, RUBBED)
    sound = normalized(_grains(ground, rate, envelope, rng))
    if ground.creak:
        sound = sound + ground.creak * normalized(_creak(ground, envelope, rng))
    if ground.drops and stage.strikes:
        sound = sound + ground.drops * normalized(_bubbles(samples, rng))
    if stage.strikes:
        pitch = ground.thump * (LEG / max(size, 0.1)) ** 0.4 * rng.uniform(0.75, 1.4)
        swing = 2.0 * np.pi * (min(pitch, 400.0) * t + rng.uniform(0.0, 0.45))
        blow = np.sin(swing) * np.exp(-t / rng.uniform(0.008, 0.018))
        sound = sound + ground.weight * blow
    return normalized(sound)


def _grains(ground: LooseGround, rate: float, envelope: Signal, rng: np.random.Generator) -> Signal:
    """Return grains at random times along an envelope, each a short resonance: (N,).

    Args:
        ground: whose they are.
        rate: of them, a second, at the strongest.
        envelope: (N,) from 0 to 1.
        rng: of all that is random.
    """
    chance = rate / SAMPLE_RATE * envelope
    hits = np.flatnonzero(rng.random(envelope.size) < chance)
    # The first touch is heard on its sample.
    hits = np.concatenate(([0], hits))
    strengths = (
        rng.exponential(1.0, hits.size)
        * np.sqrt(envelope[hits])
        * rng.choice((-1.0, 1.0), hits.size)
    )
    kinds = rng.integers(0, RESONATORS, hits.size)
    length = max(round(2.0 * ground.grain * SAMPLE_RATE), 32)
    t = np.arange(length) / SAMPLE_RATE
    sound = np.zeros(envelope.size)
    low, high = np.log(ground.band[0]), np.log(ground.band[1])
    for kind in range(RESONATORS):
        own = kinds == kind
        if not own.any():
            continue
        pitch = np.exp(rng.uniform(low, high))
        grain = np.cos(2.0 * np.pi * pitch * t) * np.exp(-6.9 * t / ground.grain)
        grain -= grain.mean()
        # Few and short: adding them one by one is faster than a convolution.
        for start, strength in zip(hits[own].tolist(), strengths[own].tolist(), strict=True):
            part = sound[start : start + length]
            part += strength * grain[: part.size]
    return sound


def _creak(ground: LooseGround, envelope: Signal, rng: np.random.Generator) -> Signal:
    """Return the creak of snow that is pressed: slips at a rate that rises, (N,)."""
    rate = rng.uniform(150.0, 260.0) * (1.0 + 0.5 * np.linspace(0.0, 1.0, envelope.size))
    phase = np.cumsum(rate * (1.0 + 0.25 * rng.standard_normal(envelope.size)) / SAMPLE_RATE)
    slips = np.diff(np.floor(phase), prepend=0.0) * envelope
    noise = band_noise(round(0.006 * SAMPLE_RATE), ground.band, rng)
    return convolve(slips, noise * np.exp(-6.0 * np.linspace(0.0, 1.0, noise.size)))


def _bubbles(samples: int, rng: np.random.Generator) -> Signal:
    """Return some bubbles that close one after the other: (samples,)."""
    sound = np.zeros(samples)
    for start in rng.integers(0, round(0.6 * samples), BUBBLES).tolist():
        part = bubble(rng)[: samples - start]
        sound[start : start + part.size] += rng.exponential(1.0) * part
    return sound


def _struck(
    material: str, surface: str, stage: Stage, size: float, speed: float, rng: np.random.Generator
) -> Signal:
    """Return the answer of a firm floor to a stage, of peak 1: (N,)."""
    own, ground = family_of(material), family_of(surface)
    if not stage.strikes:
        # A sole that rubs over the floor.
        samples = round(0.055 * stage.spread * SAMPLE_RATE)
        swell = np.sin(np.pi * np.arange(samples) / samples) ** 2
        low, high = ground.grain_band
        return normalized(shared_noise(samples, (0.6 * low, high), rng) * swell)
    solids, long = (solid_of(material), solid_of(surface)), size / LEG
    mass, radius = LEG_MASS * long**3, HEEL_RADIUS * long * rng.uniform(0.6, 1.5)
    seconds = contact_seconds(solids, radius, mass, max(speed, 0.1)) / stage.spread
    seconds = float(np.clip(seconds, *CONTACT))
    samples = round(0.13 * SAMPLE_RATE)
    sound = np.zeros(samples)
    # One board or slab sounds unlike the next; the floor is damped by whoever stands on it.
    pitches = (
        ground.ground * rng.uniform(0.65, 1.6),
        own.ground / long**0.8 * rng.uniform(0.8, 1.2),
    )
    for family, solid, pitch, level in zip(
        (ground, own),
        solids[::-1],
        pitches,
        (rng.uniform(0.25, 0.75), rng.uniform(0.35, 0.8)),
        strict=True,
    ):
        pitch = float(np.clip(pitch, 40.0, 6000.0))
        damping = family.damping + STOOD_ON
        bank = excited_modes(
            family.shape, pitch, solid.loss, damping, family.tilt, rng.uniform(), rng
        )
        rung = ring([bank.struck(seconds)], samples, seconds)
        sound += level * normalized(rung)
    # Sole and floor meet at many points, not at one.
    highest = 2.0 ** (round(2.0 * np.log2(max(2.0 / seconds, 1800.0))) / 2.0)
    slap = shared_noise(SLAP, (500.0, highest), rng) * SLAP_FALL
    sound[:SLAP] += rng.uniform(0.5, 0.9) * normalized(slap)
    return normalized(sound)
