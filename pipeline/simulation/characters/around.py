"""Around: where the solids of other rooms are, step by step, and what they were pushed by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.characters.solids import Solids, solids_of
from pipeline.simulation.dynamics.compiled import Record
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
        self._hollow: NDArray[np.bool_] | None = None
        self._yields = np.array([one.weight is not None for one in self.obstacles], dtype=bool)

    def feel(self, motion: Motion, characters: Sequence[Array]) -> None:
        """Take in where the solids are, and how fast; what they were pushed by is forgotten.

        Args:
            motion: of the solids.
            characters: (n, 3) nodes of each [m].
        """
        bodies = self.solids.bodies
        bodies["p"], bodies["R"] = motion.p, motion.R
        if self._hollow is None:
            # A room, or a sky: nobody who begins all in something is thrown out of it.
            inside = [any(self._encloses(solid, p) for p in characters) for solid in bodies]
            self._hollow = np.array(inside, dtype=bool)
        bodies["here"] = motion.here & np.logical_not(self._hollow)
        bodies["v"], bodies["w"] = motion.v, motion.w
        R = motion.R
        bodies["inverse_inertia"] = R @ self._inverse @ np.swapaxes(R, -1, -2)
        bodies["fall"] = np.where(self._yields & ~motion.borne, GRAVITY, 0.0)
        bodies["push"] = bodies["twist"] = 0.0

    def pushed(self) -> tuple[Array, Array]:
        """Return what they were pushed by since: (S, 3) [N s], (S, 3) about their nodes [N m s]."""
        bodies = self.solids.bodies
        return bodies["push"].copy(), bodies["twist"].copy()

    def _encloses(self, solid: Record, p: Array) -> bool:
        """Tell whether all of p (n, 3) lie in a solid."""
        local = (p - solid["p"]) @ solid["R"]
        if solid["radius"] > 0.0:
            away = local - solid["middle"]
            return bool((np.sqrt((away * away).sum(axis=1)) < solid["radius"]).all())
        first, count = solid["planes"]
        planes = self.solids.planes[first : first + count]
        along = (local[:, None, :] * planes[:, :3]).sum(axis=-1)
        return bool((along < planes[:, 3]).all())
