"""Spread: how the legs of one creature stand at rest, and how far they reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.spatial import Array

MAX_REACH = 0.97
"""How far a leg may stretch, as a part of its length: beyond lies the singularity of
full extension (Sims 1987, 6.3)."""


@dataclass(frozen=True, eq=False)
class LegLayout:
    """The legs of one creature at rest.

    Attributes:
        hips, feet: (n, 3) relative to the body [m].
        lengths: (n,) stretched out [m].
    """

    hips: Array
    feet: Array
    lengths: Array

    def only(self, legs: Sequence[int], aside: float = 0.0) -> LegLayout:
        """Return some of the legs alone, their feet set `aside` to the right [m]."""
        feet = self.feet[legs] + [0.0, 0.0, aside]
        return LegLayout(self.hips[legs], feet, self.lengths[legs])

    def tallest(self) -> float:
        """Return the greatest body height from which all feet reach level ground [m]."""
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        room = (MAX_REACH * self.lengths) ** 2 - across**2
        return float((np.sqrt(np.maximum(room, 0.0)) - self.hips[:, 1]).min())

    def longest_stride(self, gait: Gait, height: float, trails: float = 0.0) -> float:
        """Return the longest cycle over level ground that the legs can do [m].

        Args:
            gait: phases of the legs.
            height: of the body [m].
            trails: part of its swing for which a foot is to stay within reach of its place.
        """
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        drop = height + self.hips[:, 1]
        room = (MAX_REACH * self.lengths) ** 2 - drop**2 - across**2
        # Half of the ground covered in stance lies before the foot at rest, half behind it.
        forward = np.sqrt(np.maximum(room, 0.0)) - np.abs(self.feet[:, 0] - self.hips[:, 0])
        through = gait.duty + 2.0 * trails * gait.swing
        return max(float((2.0 * forward / through).min()), 0.0)
