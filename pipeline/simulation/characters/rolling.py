"""Rolling: how balls are turned, which are one node each and know of no rotation themselves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, rotation

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

    def go(self, moved: Array, on_ground: NDArray[np.bool_]) -> None:
        """Go on by a step in which balls moved (T, 3) [m], those on the ground rolling."""
        # Up × moved, over the radius.
        rolled = np.zeros_like(moved)
        rolled[:, 0], rolled[:, 2] = moved[:, 2] / self.radius, -moved[:, 0] / self.radius
        self._turn = np.where(on_ground[:, None], rolled, self._turn)
        if not self._turn.any():
            return
        angle = np.sqrt((self._turn * self._turn).sum(axis=-1))
        axis = self._turn / np.where(angle > 0.0, angle, 1.0)[:, None]
        self.R = rotation(axis, angle) @ self.R
