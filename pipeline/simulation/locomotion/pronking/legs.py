"""Legs: to which places the legs of a pronker come, by inverse kinematics.

That a foot is neither too far from its hip nor too near says nearly always that its leg comes
there. Where a leg points far from how it does at rest, limits of joints may say otherwise: only
then it is looked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.settling import brought
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array

MISSES = 2e-4
"""Distance of a foot from its foothold that is a miss [m]."""

NEAR, AWRY = 1.25, 0.85
"""Distance in what a leg can fold to, and cosine of the angle from where it points at rest, from
which on it is looked for."""


class Legs:
    """The legs of one creature.

    Attributes:
        herd: that it belongs to.
        own: (n,) numbers of its legs there.
        folds: (n,) least distances from hips to feet [m].
    """

    def __init__(self, herd: Herd, own: NDArray[np.int64], folds: Array) -> None:
        self.herd, self.own, self.folds = herd, own, folds
        self._hips = herd.hips[own]
        rest = np.stack([herd.rest[own, 0], 0.0 * folds, herd.rest[own, 1]], axis=-1)
        rest[:, 1] = -herd.body_height[herd.owner[own]]
        rest -= self._hips
        self._rest = rest / np.linalg.norm(rest, axis=-1, keepdims=True)

    def misses(self, feet: Array) -> NDArray[np.bool_]:
        """Tell which legs (n,) do not come to feet (n, 3) in the frame of the body."""
        way = feet - self._hips
        far = np.sqrt((way * way).sum(axis=-1))
        odd = (way * self._rest).sum(axis=-1) < AWRY * far
        odd |= far < NEAR * self.folds
        odd |= far > 0.97 * self.herd.legs.lengths[self.own]
        missed = np.zeros(len(far), dtype=bool)
        rows = np.flatnonzero(odd)
        if len(rows):
            herd = self.herd
            _, gap = brought(herd.legs, herd.chains, self.own[rows], feet[rows])
            missed[rows] = gap > MISSES
        return missed
