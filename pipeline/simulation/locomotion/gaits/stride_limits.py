"""Stride limits: how far legs reach, and the longest stride that they can do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.locomotion.gaits.gait import Gait
from pipeline.simulation.spatial import Array

# Greatest extension of a leg, as a fraction of its length: beyond lies the singularity of full
# extension (Sims 1987, 6.3).
MAX_REACH = 0.97

# Planned extension of a leg, as a fraction of its length; the rest covers what no plan foresees.
PLANNED_REACH = 0.98 * MAX_REACH


@dataclass(frozen=True, eq=False)
class LegLayout:
    """The legs of one creature at rest.

    Attributes:
        hips, feet: (n, 3) relative to the body [m].
        lengths: (n,) stretched out [m].
        ends: (n,) how high the ends of the legs are over the ground, the centres of the feet [m].
            Zero on more than two legs: what the feet add is needed where each stands at another
            height.
    """

    hips: Array
    feet: Array
    lengths: Array
    ends: Array

    def only(self, legs: Sequence[int], lateral_offset: float = 0.0) -> LegLayout:
        """Return some of the legs, their feet `lateral_offset` to the right [m]."""
        feet = self.feet[legs] + [0.0, 0.0, lateral_offset]
        return LegLayout(self.hips[legs], feet, self.lengths[legs], self.ends[legs])

    def tallest(self) -> float:
        """Return the greatest body height from which all feet reach level ground [m]."""
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        room = (MAX_REACH * self.lengths) ** 2 - across**2
        return float((np.sqrt(np.maximum(room, 0.0)) - self.hips[:, 1] + self.ends).min())

    def reach(self, height: float, stretch: float = MAX_REACH) -> float:
        """Return the longest way that all feet can stand through [m].

        Args:
            height: of the body above level ground [m].
            stretch: greatest of a leg, in its length.
        """
        across = np.abs(self.feet[:, 2] - self.hips[:, 2])
        drop = height + self.hips[:, 1] - self.ends
        room = (stretch * self.lengths) ** 2 - drop**2 - across**2
        # Half of the ground covered in stance lies before the foot at rest, half behind it.
        forward = np.sqrt(np.maximum(room, 0.0)) - np.abs(self.feet[:, 0] - self.hips[:, 0])
        return max(float(2.0 * forward.min()), 0.0)

    def longest_stride(self, gait: Gait, height: float) -> float:
        """Return the longest stride over level ground [m].

        Args:
            gait: of the legs.
            height: of the body [m].
        """
        return self.reach(height) / float(gait.duty.max())


def rounded_down(value: float) -> str:
    """Return `value` in three digits, never more than it is."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2) if value > 0.0 else 1.0
    return f"{math.floor(value / step + 1e-9) * step:.3g}"


def rounded_up(value: float) -> str:
    """Return `value` in three digits, never less than it is."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.ceil(value / step - 1e-9) * step:.3g}"
