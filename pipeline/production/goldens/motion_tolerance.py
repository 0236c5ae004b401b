"""Tolerance: how far from its golden a take may lie, and how finely goldens are rounded.

The tolerances lie well below what a film can show (at 1280 pixels a scene of four metres
has three millimetres a pixel) and far above what other processors do to the last bits.
A golden holds multiples of a quantum of each. Its own rounding is at most 0.3 of the
tolerance, so what is within 0.7 of it passes and what is beyond 1.3 of it fails.
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
"""Of channels in any unit that has no line of its own."""

BY_UNIT: Final = {"m": POSITION, "rad": ROTATION}
"""Of channels: slides of joints, and their angles."""

MOMENT: Final = 1.0
"""Of contacts, sound events and notes [steps]."""

PLACE: Final = 5e-3
"""Of contacts and sound events, which move while their moment does [m]."""

STRENGTH: Final = 0.02
"""Of the speed of contacts and sound events [m/s], and of its size beside itself."""

FORBIDDEN: Final = 1e-3
"""Of the share of the ground's cells that is forbidden."""

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
"""Quantum of a channel beside its tolerance."""


def of_unit(unit: str) -> float:
    """Return the tolerance of a channel of this unit."""
    return BY_UNIT.get(unit, CHANNEL)
