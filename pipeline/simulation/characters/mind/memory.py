"""Memory: what somebody has in view, and for a while has seen before.

Source: Horswill 2008, "Example application" (short-term memory).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.mind.surroundings import Surroundings
from pipeline.simulation.spatial import Array

SPAN = 12.0
"""How long what is out of view is remembered [s]."""

FAR = 25.0
"""How far somebody sees [m]."""

ASIDE = math.radians(95.0)
"""How far to the side of where it looks."""

TOUCHES = 0.9
"""What is nearer than this is felt or heard, if not seen [m]."""


class Memory:
    """Where somebody believes the others to be.

    Attributes:
        places: (C, 3) last known [m].
        velocities: (C, 3) then [m/s].
        seen: (C,) when each was last in view [s].
        in_view: (C,) who is.
        away: (C,) how far over the ground each is believed to be [m].
    """

    def __init__(self, around: Surroundings) -> None:
        # Whoever begins a film knows who is there.
        self.places = around.places.copy()
        self.velocities = np.zeros_like(self.places)
        self.seen = np.zeros(len(self.places))
        self.in_view: NDArray[np.bool_] = np.ones(len(self.places), dtype=bool)
        self.away = np.zeros(len(self.places))

    def look(self, around: Surroundings, me: int, gaze: float) -> None:
        """Take in what is in view of one who looks along a heading [rad]."""
        x, z, _ = self._from(around.places, around.places[me])
        distance = np.sqrt(x * x + z * z)
        ahead = x * math.cos(gaze) - z * math.sin(gaze)
        near = distance < around.radius + TOUCHES
        self.in_view = near | ((distance < FAR) & (ahead > math.cos(ASIDE) * distance))
        self.in_view[me] = False
        self.places[self.in_view] = around.places[self.in_view]
        self.velocities[self.in_view] = around.velocities[self.in_view]
        self.seen[self.in_view] = around.now
        _, _, self.away = self._from(self.places, around.places[me])

    @staticmethod
    def _from(places: Array, me: Array) -> tuple[Array, Array, Array]:
        x, z = places[:, 0] - me[0], places[:, 2] - me[2]
        return x, z, np.sqrt(x * x + z * z)

    def fresh(self, now: float) -> Array:
        """Return (C,) how well each is remembered, from 1 in view to 0."""
        left: Array = np.clip(1.0 - (now - self.seen) / SPAN, 0.0, 1.0)
        return left
