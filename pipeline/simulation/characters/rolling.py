"""Rolling: how balls are turned, which are one node each and know of no rotation themselves."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.spatial import UP, Array, cross, rotation

DEEP = 0.02
"""Height over the ground up to which a ball rolls on it, in radii."""


class Rolling:
    """Rotations of balls: on the ground they roll, in the air they go on as they turned.

    Attributes:
        R: (T, 3, 3) their rotations.
    """

    def __init__(self, radius: Array) -> None:
        self.radius = radius
        self.R: Array = np.broadcast_to(np.eye(3), (len(radius), 3, 3)).copy()
        self._turn = np.zeros((len(radius), 3))

    def go(self, moved: Array, on_ground: Array) -> None:
        """Go on by a step in which balls moved (T, 3) [m], those on the ground rolling."""
        rolled = cross(np.broadcast_to(UP, moved.shape), moved) / self.radius[:, None]
        self._turn = np.where(on_ground[:, None], rolled, self._turn)
        angle = np.sqrt((self._turn * self._turn).sum(axis=-1))
        axis = self._turn / np.where(angle > 0.0, angle, 1.0)[:, None]
        self.R = rotation(axis, angle) @ self.R
