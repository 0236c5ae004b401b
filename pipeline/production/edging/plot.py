"""Plot: built ground on which nothing else stands or grows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array


@dataclass(frozen=True, eq=False)
class Plot:
    """A rectangle on the ground.

    Attributes:
        middle: x and z [m].
        along: unit vector along its first sides.
        half: half its sides [m].
    """

    middle: Array
    along: Array
    half: Array

    def holds(self, places: Array, margin: float = 0.0) -> NDArray[np.bool_]:
        """Return which places (N, 2) lie in it, or within a margin around it [m]."""
        way = places - self.middle
        across = np.array([-self.along[1], self.along[0]])
        out = np.abs(np.stack([way @ self.along, way @ across], axis=-1)) - self.half
        return np.asarray((out < margin).all(axis=-1))
