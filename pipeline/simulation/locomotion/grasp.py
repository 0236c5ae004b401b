"""Grasp: which places the joints of a leg bring its tip to.

A leg reaches less than its length says: knees fold only so far, and hips turn only so far
to the side. Inverse kinematics knows; it is asked only where a place is not beside those
that the leg comes to on level ground anyway.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.chains import Chains, chains_of
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.settling import settle
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
        self._alone = cache(self._one)
        half = 0.5 * herd.stride[herd.owner] * (1.0 - 0.5 * herd.swings)
        x, z = herd.rest.T
        room = BESIDE * herd.legs.lengths[:, None]
        floor = herd.sole - herd.body_height[herd.owner]
        self._low = np.stack([x - half, floor - herd.legs.lengths, z], axis=-1) - room
        self._high = np.stack([x + half, floor, z], axis=-1) + room

    def _one(self, leg: int) -> tuple[LimbBatch, list[Chains]]:
        batch = self.herd.legs.rows(np.array([leg]))
        return batch, chains_of(batch, np.zeros(1, dtype=np.int64))

    def holds(self, leg: int, goals: Array) -> NDArray[np.bool_]:
        """Say to which of `goals` (n, m, 3), relative to the body, the leg's tip comes."""
        known: NDArray[np.bool_] = ((goals >= self._low[leg]) & (goals <= self._high[leg])).all(
            axis=-1
        )
        asked = ~known
        if asked.any():
            far = goals[asked]
            batch, chains = self._alone(leg)
            residual = settle(batch, chains, far[:, None]).residual[:, 0]
            known[asked] = residual <= MISSES * self.herd.legs.lengths[leg]
        return known

    def holds_each(self, legs: NDArray[np.int64], goals: Array) -> NDArray[np.bool_]:
        """Say whether the tips of `legs` (N,) come to all of their `goals` (N, m, 3)."""
        low, high = self._low[legs, None], self._high[legs, None]
        result: NDArray[np.bool_] = ((goals >= low) & (goals <= high)).all(axis=(1, 2))
        for i in np.flatnonzero(~result).tolist():
            result[i] = self.holds(int(legs[i]), goals[i][None]).all()
        return result
