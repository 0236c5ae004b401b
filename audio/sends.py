"""Reverb sends: how much of a sound the room gives back, by how far away it is."""

from __future__ import annotations

from math import hypot

CRITICAL_DISTANCE = 10.0
"""Where the room's part is as loud as what comes straight [m]: a large hall's."""


def send_of(distance: float, reverb: float) -> float:
    """Return the share of a sound's level that the room is given, 0 to `reverb`.

    What comes straight falls with the distance d, what the room gives back is everywhere the
    same; of both powers together the room has d² / (d² + d_c²), d_c the critical distance. Dry
    near, wetter far. Source: Kuttruff 2016, 5.5.

    Args:
        distance: from the listener [m].
        reverb: the author's word, 0 to 1.
    """
    return reverb * (distance / hypot(distance, CRITICAL_DISTANCE))
