"""Surroundings: where a figure is, and the frames that its author may speak in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.spatial import Array
from pipeline.spec.keyframes import Frame


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Where a figure is in n rows.

    Attributes:
        times: (n,) [s].
        dt: from one row to the next [s].
        R_WB, p_WB: (n, 3, 3) and (n, 3) pose of its body [m].
        R_WG, p_WG: (n, 3, 3) and (n, 3) of the ground below it, x along its heading [m].
    """

    times: Array
    dt: float
    R_WB: Array
    p_WB: Array
    R_WG: Array
    p_WG: Array

    def frame(self, name: Frame) -> tuple[Array, Array]:
        """Return the pose in the world of the frame that an author means."""
        if name == "body":
            return self.R_WB, self.p_WB
        if name == "feet":
            return self.R_WG, self.p_WG
        return np.broadcast_to(np.eye(3), self.R_WB.shape), np.zeros_like(self.p_WB)
