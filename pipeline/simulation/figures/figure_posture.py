"""Posture: joint values of one figure as its author poses it, blended with its own motion.

A limb's joint values are its own before the first key and after the release.

Source: Sims 1987, 3.2.2, 6.2 and B.3.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_frames import FigureFrames, LimbParent
from pipeline.simulation.figures.goal_miss import GoalMiss
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.pose_plan import PosePlan
from pipeline.simulation.figures.posed_limb import PosedLimb
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.figures.surroundings import Surroundings
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.spatial import Array, turn


@dataclass(frozen=True, eq=False)
class FigurePosture:
    """One posed figure.

    Attributes:
        figure: the figure.
        plan: its demands.
        rng: for the search for poses of keys.
        surroundings: that its limbs keep clear of.
    """

    figure: Figure
    plan: PosePlan
    rng: np.random.Generator
    surroundings: Surroundings = field(default_factory=lambda: Surroundings(None))

    @cached_property
    def _tree(self) -> JointTree:
        return JointTree.of(self.figure.skeleton)

    @cached_property
    def _limbs(self) -> dict[int, PosedLimb]:
        """Limbs with demands; one that hangs on another comes after it."""
        limbs = {
            i: PosedLimb(self.figure, i, self.plan, self.rng, self.surroundings)
            for i in self.plan.limbs()
        }
        return dict(sorted(limbs.items(), key=lambda item: (item[1].above != BODY, item[0])))

    def body(self, times: Array) -> tuple[Array, Array]:
        """Return how the body is rotated (n, 3, 3) and moved (n, 3) in its ground's frame [m]."""
        wanted = np.zeros((len(times), 6))
        for run in self.plan.body:
            wanted += run.weight(times)[:, None] * run.track(times)
        return rotation_from_angles(wanted[:, 3:]), wanted[:, :3]

    def free(self, limb: int, times: Array) -> Array:
        """Return the weight (n,) of a limb's own motion."""
        posed = self._limbs.get(limb)
        return np.ones(len(times)) if posed is None else 1.0 - posed.weight(times)

    def values(self, q: Array, frames: FigureFrames) -> tuple[Array, Array, list[GoalMiss]]:
        """Return posed joint values.

        Args:
            q: (n, J) own values of all joints [rad or m].
            frames: of the figure.

        Returns:
            Joint values (n, J), the frames X_BJ (n, J, 4, 4), and misses.
        """
        skeleton = self.figure.skeleton
        q, misses = q.copy(), list[GoalMiss]()
        X = self._tree.pose(q)
        foresee = partial(self._foresee, frames)
        for i, limb in self._limbs.items():
            joints = list(skeleton.limbs[i].joints)
            parent = LimbParent.body(len(q))
            if limb.above != BODY:
                # Relative to what it hangs on, as that was drawn.
                R_BP = X[:, limb.above, :3, :3]
                p_BP = X[:, limb.above, :3, 3] - turn(R_BP, skeleton.places[limb.above])
                parent = LimbParent(R_BP, p_BP)
            q[:, joints], missed = limb.follow(q[:, joints], frames, parent, foresee)
            misses.extend(missed)
            X = self._tree.pose(q)
        return q, X, misses

    def _foresee(self, frames: FigureFrames, row: int, times: Array) -> FigureFrames:
        """Return the frames at times (k,), of a figure that stays where it is in `row`.

        Its body goes on as its author poses it.
        """
        count = len(times)
        R_WG, p_WG = frames.R_WG[row], frames.p_WG[row]
        R, p = self.body(np.append(times, frames.times[row]))
        R_then = R_WG @ R[:-1] @ R[-1].T @ R_WG.T @ frames.R_WB[row]
        p_then = frames.p_WB[row] + turn(R_WG, p[:-1] - p[-1])
        ground = np.broadcast_to(R_WG, (count, 3, 3)), np.broadcast_to(p_WG, (count, 3))
        return FigureFrames(times, frames.dt, R_then, p_then, *ground)
