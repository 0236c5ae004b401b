"""Around: where the solids of other rooms are, step by step, and what they were pushed by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.characters.solids import Solids, solids_of
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.solid import Motion, Obstacle
from pipeline.simulation.spatial import Array


class Around:
    """What so many characters may run into.

    Attributes:
        obstacles: solids, in their order.
        solids: as compiled loops know them.
    """

    def __init__(self, obstacles: Sequence[Obstacle] = (), characters: int = 0) -> None:
        self.solids: Solids
        self.solids, which = solids_of(obstacles, characters)
        self.obstacles = [obstacles[k] for k in which]
        inverse = [
            np.zeros((3, 3)) if (o := one.weight) is None else o.inverse_inertia
            for one in self.obstacles
        ]
        self._inverse = np.array(inverse).reshape(-1, 3, 3)
        self._yields = np.array([one.weight is not None for one in self.obstacles], dtype=bool)

    def feel(self, motion: Motion) -> None:
        """Take in where the solids are, and how fast; what they were pushed by is forgotten."""
        bodies = self.solids.bodies
        bodies["p"], bodies["R"], bodies["here"] = motion.p, motion.R, motion.here
        bodies["v"], bodies["w"] = motion.v, motion.w
        R = motion.R
        bodies["inverse_inertia"] = R @ self._inverse @ np.swapaxes(R, -1, -2)
        bodies["fall"] = np.where(self._yields & ~motion.borne, GRAVITY, 0.0)
        bodies["push"] = bodies["twist"] = 0.0

    def pushed(self) -> tuple[Array, Array]:
        """Return what they were pushed by since: (S, 3) [N s], (S, 3) about their nodes [N m s]."""
        bodies = self.solids.bodies
        return bodies["push"].copy(), bodies["twist"].copy()
