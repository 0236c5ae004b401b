"""Posture: joint values of one figure, as its author asks for them over what it does itself.

Source: Sims 1987, 3.2.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import Tree
from pipeline.simulation.figures.pose_plan import PosePlan
from pipeline.simulation.figures.posed_limb import Miss, PosedLimb
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.figures.surroundings import Surroundings
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.tracks import turned


@dataclass(frozen=True, eq=False)
class Posture:
    """One figure under its author's hands; its limbs remember the row before.

    Attributes:
        figure: the figure.
        plan: what is asked of it.
        rng: for the first pose of a limb.
    """

    figure: Figure
    plan: PosePlan
    rng: np.random.Generator

    @cached_property
    def _tree(self) -> Tree:
        return Tree.of(self.figure.skeleton)

    @cached_property
    def _limbs(self) -> dict[int, PosedLimb]:
        """Those that something is asked of; one that hangs on another comes after it."""
        limbs = {i: PosedLimb(self.figure, i, self.plan, self.rng) for i in self.plan.limbs()}
        return dict(sorted(limbs.items(), key=lambda one: (one[1].above != BODY, one[0])))

    def body(self, times: Array) -> tuple[Array, Array]:
        """Return how the body is turned (n, 3, 3) and moved (n, 3) in its ground's frame [m]."""
        wanted = np.zeros((len(times), 6))
        for run in self.plan.body:
            wanted += run.weight(times)[:, None] * run.track(times)
        return turned(wanted[:, 3:]), wanted[:, :3]

    def free(self, limb: int, times: Array) -> Array:
        """Return what part of a limb's doing (n,) is left to itself."""
        posed = self._limbs.get(limb)
        return np.ones(len(times)) if posed is None else 1.0 - posed.weight(times)

    def values(self, q: Array, around: Surroundings) -> tuple[Array, Array, list[Miss]]:
        """Return joint values as they are asked for.

        Args:
            q: (n, J) of all joints as they would be [rad or m].
            around: where the figure is.

        Returns:
            Joint values (n, J), the frames X_BJ (n, J, 4, 4), and what is not reached.
        """
        skeleton = self.figure.skeleton
        q, misses = q.copy(), list[Miss]()
        X = self._tree.pose(q)
        for i, limb in self._limbs.items():
            joints = list(skeleton.limbs[i].joints)
            R_BP: Array = np.broadcast_to(np.eye(3), (len(q), 3, 3))
            p_BP = np.zeros((len(q), 3))
            if limb.above != BODY:
                # Relative to what it hangs on, as that was drawn.
                R_BP = X[:, limb.above, :3, :3]
                p_BP = X[:, limb.above, :3, 3] - turn(R_BP, skeleton.places[limb.above])
            q[:, joints], missed = limb.follow(q[:, joints], around, R_BP, p_BP)
            misses.extend(missed)
            X = self._tree.pose(q)
        return q, X, misses
