"""Grasp: which places the joints of a leg bring its tip to.

A leg reaches less than its length says: knees fold only so far, and hips turn only so far
to the side. Inverse kinematics knows; it is asked only where a place is not beside those
that the leg comes to on level ground anyway.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.settling import settle
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array

MISSES = 1e-4
"""Distance of tip from place that is none, in the leg's length."""

BESIDE = 0.12
"""How far from its places on level ground a leg is sure to reach, in its length: as far
down as it is not overstretched, and half as far up."""


class Grasp:
    """Tells which places the legs of a herd reach.

    Attributes:
        herd: whose legs.
    """

    def __init__(self, herd: Herd) -> None:
        self.herd = herd
        room = BESIDE * herd.legs.lengths
        half = 0.5 * herd.stride[herd.owner] * (1.0 - 0.5 * herd.swings)
        x, z = herd.rest.T
        floor = herd.sole - herd.body_height[herd.owner]
        self._low = np.stack([x - half, floor - room, z - 0.5 * room], axis=-1)
        self._high = np.stack([x + half, floor + 0.5 * room, z + 0.5 * room], axis=-1)

    def holds(self, leg: int, goals: Array) -> NDArray[np.bool_]:
        """Say to which of `goals` (n, m, 3), relative to the body, the leg's tip comes."""
        known: NDArray[np.bool_] = (
            (goals >= self._low[leg]) & (goals <= self._high[leg])
        ).all(axis=-1)
        asked = ~known
        if asked.any():
            far = goals[asked]
            batch = self.herd.legs.rows(np.full(len(far), leg))
            residual = settle(batch, far).residual
            known[asked] = residual <= MISSES * self.herd.legs.lengths[leg]
        return known
