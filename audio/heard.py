"""How loud an event is and from where it is heard; one rule for score and sound."""

from __future__ import annotations

from math import log10, sin

from audio.score import ScoreEvent

# Peak of a blow of 1 m/s by half a kilogram at 4 m [dBFS]: a walk then stands well above the
# floor of a living room and a crash of dozens still below the limiter's knee.
_REFERENCE_DB = -10.0
_REFERENCE_DISTANCE = 4.0
_REFERENCE_MASS = 0.5
NEAREST = 0.5
"""Nearer than this [m], loudness no longer grows: a camera may fly through a foot."""
SPEED_POWER = 0.7
"""Amplitude grows with speed to this power; 1 would be physical and hides soft steps."""
_SLOWEST, _FASTEST = 0.02, 1000.0
_LARGEST = 100.0


def loudness_db(event: ScoreEvent) -> float:
    """Return the peak level of an event at the listener before its voice's gain [dBFS]."""
    speed = min(max(abs(event.strength), _SLOWEST), _FASTEST)
    # What is heavier moves more air; where no energy is given, half a cube of water.
    mass = 2 * event.energy / speed**2 if event.energy > 0 else 500 * min(event.size, _LARGEST) ** 3
    weight = 5 * log10(max(mass, 1e-9) / _REFERENCE_MASS)
    near = 20 * log10(_REFERENCE_DISTANCE / max(event.distance, NEAREST))
    return _REFERENCE_DB + 20 * SPEED_POWER * log10(speed) + min(max(weight, -8.0), 8.0) + near


def pan_of(event: ScoreEvent) -> float:
    """Return where an event stands between left (-1) and right (1); behind folds to the front."""
    return sin(event.azimuth)
