"""Velocities: how hard a note is struck, and the level at the listener that goes with it."""

from __future__ import annotations

from dataclasses import replace
from math import log10

from audio.heard import SPEED_POWER, loudness_db
from audio.score import ScoreEvent
from audio.velocity_words import FASTEST, SLOWEST, VelocityWords

# The peak that full velocity stands for [dBFS]; a synthesiser's loudness follows
# 40 log10(velocity / 127). Source: MMA DLS 1999.
_FULL_VELOCITY_DB = -4.0
_FULL = 127
# Where velocities that the author gives are heard as given [m].
_REFERENCE_DISTANCE = 4.0
# Loudness of what does not move at all would have no logarithm [m/s].
_STILL = 0.02


def velocity_of(level: float) -> int:
    """Return the MIDI velocity of a level [dBFS], 1 to 127."""
    return min(max(round(_FULL * 10 ** ((level - _FULL_VELOCITY_DB) / 40)), 1), _FULL)


def level_of(velocity: float) -> float:
    """Return the level that a velocity stands for [dBFS]."""
    return _FULL_VELOCITY_DB + 40 * log10(velocity / _FULL)


def level_by(words: VelocityWords, event: ScoreEvent) -> float:
    """Return the level of an event at the listener by a curve, before gains [dBFS]."""
    if words.curve == "physical":
        return _physical(words, event)
    level = level_of(_velocity(words, abs(event.strength)))
    if not words.distance:
        return level
    near = replace(event, distance=_REFERENCE_DISTANCE)
    return level + loudness_db(event) - loudness_db(near)


def _physical(words: VelocityWords, event: ScoreEvent) -> float:
    """Return the loudness of a blow, its speed within bounds and to a power of the author's."""
    if (words.exponent, words.slowest, words.fastest) == (None, None, None):
        return loudness_db(event)
    given = max(abs(event.strength), _STILL)
    speed = min(max(given, words.slowest or 0.0), words.fastest or 1000.0)
    # Energy goes with the speed, so that the mass that is heard stays.
    bound = replace(event, strength=speed, energy=event.energy * (speed / given) ** 2)
    exponent = SPEED_POWER if words.exponent is None else words.exponent
    return loudness_db(bound) + 20 * (exponent - SPEED_POWER) * log10(speed)


def _velocity(words: VelocityWords, speed: float) -> float:
    if words.curve == "fixed":
        return words.loudest
    slowest = SLOWEST if words.slowest is None else words.slowest
    fastest = FASTEST if words.fastest is None else words.fastest
    part = min(max((speed - slowest) / (fastest - slowest), 0.0), 1.0)
    power = (0.5 if words.exponent is None else words.exponent) if words.curve == "power" else 1.0
    return words.softest + (words.loudest - words.softest) * float(part**power)
