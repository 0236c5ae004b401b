"""Loudness at the listener: level, velocity, pan and reverb send of an event.

Score and sound follow the same rules.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot, log10, sin

from audio.config.velocity import DEFAULT_FASTEST, DEFAULT_SLOWEST, Velocity
from audio.score import ScoreEvent

# Peak of an impact of 1 m/s by half a kilogram at 4 m [dBFS]: a walk is then well above the noise
# floor of a living room and a crash of dozens still below the limiter's ceiling.
_REFERENCE_DB = -10.0
REFERENCE_DISTANCE = 4.0
"""Distance at which given velocities hold [m]."""
_REFERENCE_MASS = 0.5
MIN_DISTANCE = 0.5
"""Loudness does not grow below this [m]: a camera may pass through a foot."""
SPEED_EXPONENT = 0.7
"""Exponent of speed in the amplitude; 1 would be physical but hide soft steps."""
_MIN_SPEED, _MAX_SPEED = 0.02, 1000.0
_MAX_SIZE = 100.0
# Bounds of the correction for mass [dB].
_MAX_MASS_DB = 8.0

# Peak of full velocity [dBFS]; a synthesiser's loudness follows 40 log10(velocity / 127).
# Source: MMA DLS 1999.
_FULL_VELOCITY_DB = -4.0
_FULL_VELOCITY = 127

CRITICAL_DISTANCE = 10.0
"""Distance at which reverberation is as loud as the direct sound [m], in a large hall."""


def loudness_db(event: ScoreEvent) -> float:
    """Return the peak level of an event before its voice's gain [dBFS]."""
    speed = min(max(abs(event.strength), _MIN_SPEED), _MAX_SPEED)
    # Without an energy, the mass of half a cube of water.
    mass = 500 * min(event.size, _MAX_SIZE) ** 3
    if event.energy > 0:
        mass = 2 * event.energy / speed**2
    weight = 5 * log10(max(mass, 1e-9) / _REFERENCE_MASS)
    near = 20 * log10(REFERENCE_DISTANCE / max(event.distance, MIN_DISTANCE))
    return (
        _REFERENCE_DB
        + 20 * SPEED_EXPONENT * log10(speed)
        + min(max(weight, -_MAX_MASS_DB), _MAX_MASS_DB)
        + near
    )


def pan_of(event: ScoreEvent) -> float:
    """Return the pan from left (-1) to right (1); behind is folded to the front."""
    return sin(event.azimuth)


def reverb_send(distance: float, reverb: float) -> float:
    """Return the share of a sound's level that is sent to the reverb, 0 to `reverb`.

    Direct sound falls with the distance d, reverberation is the same everywhere; its share of the
    total power is d² / (d² + d_c²), with the critical distance d_c.

    Source: Kuttruff 2016, 5.5.

    Args:
        distance: from the listener [m].
        reverb: configured share, 0 to 1.
    """
    return reverb * (distance / hypot(distance, CRITICAL_DISTANCE))


def velocity_of_level(level: float) -> int:
    """Return the MIDI velocity of a level [dBFS], 1 to 127."""
    velocity = round(_FULL_VELOCITY * 10 ** ((level - _FULL_VELOCITY_DB) / 40))
    return min(max(velocity, 1), _FULL_VELOCITY)


def level_of_velocity(velocity: float) -> float:
    """Return the level of a velocity [dBFS]."""
    return _FULL_VELOCITY_DB + 40 * log10(velocity / _FULL_VELOCITY)


def event_level(config: Velocity, event: ScoreEvent) -> float:
    """Return the level of an event by a velocity curve, before gains [dBFS]."""
    if config.curve == "physical":
        return _physical_level(config, event)
    level = level_of_velocity(_curve_velocity(config, abs(event.strength)))
    if not config.distance:
        return level
    near = replace(event, distance=REFERENCE_DISTANCE)
    return level + loudness_db(event) - loudness_db(near)


def _physical_level(config: Velocity, event: ScoreEvent) -> float:
    if (config.exponent, config.slowest, config.fastest) == (None, None, None):
        return loudness_db(event)
    given = max(abs(event.strength), _MIN_SPEED)
    speed = min(max(given, config.slowest or 0.0), config.fastest or _MAX_SPEED)
    # The energy is scaled with the speed, so that the mass stays.
    bounded = replace(event, strength=speed, energy=event.energy * (speed / given) ** 2)
    exponent = SPEED_EXPONENT if config.exponent is None else config.exponent
    return loudness_db(bounded) + 20 * (exponent - SPEED_EXPONENT) * log10(speed)


def _curve_velocity(config: Velocity, speed: float) -> float:
    if config.curve == "fixed":
        return config.loudest
    slowest = DEFAULT_SLOWEST if config.slowest is None else config.slowest
    fastest = DEFAULT_FASTEST if config.fastest is None else config.fastest
    fraction = min(max((speed - slowest) / (fastest - slowest), 0.0), 1.0)
    exponent = 1.0
    if config.curve == "power":
        exponent = 0.5 if config.exponent is None else config.exponent
    return config.softest + (config.loudest - config.softest) * float(fraction**exponent)
