"""Anxiety: grows with the distance from who cares for somebody, and is soothed by a hug.

Source: Horswill 2008, "Example application"; Bowlby 1969.
"""

from __future__ import annotations

import math

SAFE, FAR = 1.5, 9.0
"""Distances from the caregiver at which nothing is to be feared, and at which much is [m]."""

GROWS = 0.26
"""How fast anxiety grows that far away in one who is very anxious [1/s]."""

CALMS = 0.02
"""How fast it goes by itself where one is safe [1/s]."""

SOOTHES = 0.75
"""How fast it goes in a hug [1/s]."""

SHOCK = 0.12
"""What a blow that just hurts adds."""


def exposed(distance: float) -> float:
    """Return how far from safety somebody is, from 0 to 1."""
    return min(max((distance - SAFE) / (FAR - SAFE), 0.0), 1.0)


def felt(anxiety: float, trait: float, distance: float, hugged: bool, dt: float) -> float:
    """Return what anxiety is a while later.

    Args:
        anxiety: from 0 to 1.
        trait: how anxious somebody is by nature, from 0 to 1.
        distance: from the caregiver [m].
        hugged: whether it hugs.
        dt: the while [s].
    """
    if hugged:
        return anxiety * math.exp(-SOOTHES * dt)
    gain = GROWS * trait * exposed(distance)
    loss = CALMS if distance < SAFE else 0.0
    return min(max(anxiety + (gain - loss) * dt, 0.0), 1.0)
