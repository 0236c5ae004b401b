"""Grasp: which places the joints of a leg bring its tip to.

A leg reaches less than its length says: knees fold only so far, and hips turn only so far
to the side. Inverse kinematics knows; it is asked only where a place is not beside those
that the leg comes to on level ground anyway.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.settling import misses
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array

MISSES = 1e-4
"""Distance of tip from place that is none, in the leg's length."""

BESIDE = np.array([0.12, 0.12, 0.1])
"""How far from its places on level ground a leg is sure to reach, in its length: along,
upward and across. Downward its length alone is the bound."""


class Grasp:
    """Tells which places the legs of a herd reach.

    Attributes:
        herd: whose legs.
    """

    def __init__(self, herd: Herd) -> None:
        self.herd = herd
        half = 0.5 * herd.stride[herd.owner] * (1.0 - 0.5 * herd.swings)
        x, z = herd.rest.T
        room = BESIDE * herd.legs.lengths[:, None]
        floor = herd.sole - herd.body_height[herd.owner]
        self._low = np.stack([x - half, floor - herd.legs.lengths, z], axis=-1) - room
        self._high = np.stack([x + half, floor, z], axis=-1) + room

    def holds(self, leg: int, goals: Array) -> NDArray[np.bool_]:
        """Say to which of `goals` (n, m, 3), relative to the body, the leg's tip comes."""
        return self.holds_each(np.full(len(goals), leg), goals)

    def holds_each(self, legs: NDArray[np.int64], goals: Array) -> NDArray[np.bool_]:
        """Say to which of their `goals` (N, m, 3), relative to bodies, tips of legs (N,) come."""
        low, high = self._low[legs, None], self._high[legs, None]
        inside: NDArray[np.bool_] = (goals >= low) & (goals <= high)
        known: NDArray[np.bool_] = np.asarray(inside.all(axis=-1))
        row, moment = np.nonzero(~known)
        if len(row):
            herd, asked = self.herd, legs[row]
            residual = misses(herd.legs, herd.chains, asked, goals[row, moment])
            known[row, moment] = residual <= MISSES * herd.legs.lengths[asked]
        return known
