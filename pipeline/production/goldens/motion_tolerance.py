"""Motion tolerance: allowed differences of a take from its golden, and the rounding of goldens.

Tolerances are well below what a film shows (at 1280 pixels a scene of four metres has three
millimetres per pixel) and far above the rounding of other processors. A golden holds multiples of
a quantum; its rounding is at most 0.3 of the tolerance, so differences below 0.7 of it pass and
those above 1.3 of it fail.
"""

from __future__ import annotations

from typing import Final

POSITION: Final = 5e-4
"""Of a node and of the ground [m]."""

ROTATION: Final = 3e-3
"""Of a node, as the angle between both [rad]."""

SCALE: Final = 1e-3
"""Of a node."""

CHANNEL: Final = 5e-3
"""Of channels in other units."""

BY_UNIT: Final = {"m": POSITION, "rad": ROTATION}
"""Of channels: slides of joints, and their angles."""

MOMENT: Final = 0.2
"""Of contacts, sound events and notes [steps]: less than a quarter of a frame, whatever the number
of steps. On another class of processor they differ by less than 1e-4."""

PLACE: Final = 5e-3
"""Of contacts and sound events, which move while their moment does [m]."""

STRENGTH: Final = 0.02
"""Of the speed of contacts and sound events, as a fraction of it. On another class of processor it
differs by up to 0.015."""

LEAST_STRENGTH: Final = 3e-3
"""Of the speed of slow ones [m/s]: sounds of less than 0.02 m/s are alike."""

FORBIDDEN: Final = 1e-3
"""Of the fraction of forbidden cells."""

QUANTA: Final = {
    # Half a quantum in each of three components is √3/2 of it.
    "positions": 0.3 * POSITION,
    # Half a quantum in each of four components of a quaternion turns by two of it.
    "rotations": 0.14 * ROTATION,
    "alive": 1.0,
    "scales": 0.3 * SCALE,
    "terrain": 0.3 * POSITION,
}


CHANNEL_QUANTUM: Final = 0.3
"""Quantum of a channel, as a fraction of its tolerance."""


def strength_tolerance(speed: float) -> float:
    """Return the tolerance of a contact or a sound event of this speed [m/s]."""
    return LEAST_STRENGTH + STRENGTH * abs(speed)


def channel_tolerance(unit: str) -> float:
    """Return the tolerance of a channel with this unit."""
    return BY_UNIT.get(unit, CHANNEL)
