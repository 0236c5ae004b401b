"""Postures: the creatures of a herd of which their authors ask something beside walking."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_posture import (
    FIRST_POSE_STEPS,
    REST_PULL,
    TRACKING_STEPS,
    FigureFrames,
    FigurePosture,
    GoalMiss,
)
from pipeline.simulation.figures.ik_goals import PreferredValues, TipPlacement
from pipeline.simulation.figures.inverse_kinematics import track_goals
from pipeline.simulation.figures.pose_plan import plan_poses
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array, heading, turn
from pipeline.spec.creature import Creature


class AuthoredPoses:
    """What is asked of the creatures of a herd, by creature."""

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        herd: Herd,
        idlers: FreeJoints,
        seed: int,
    ) -> None:
        self.herd = herd
        self.idlers = idlers
        self.of: Mapping[int, FigurePosture] = {
            c: FigurePosture(
                figure,
                plan_poses(member.pose, figure, f"cast[{number}].pose"),
                generator(seed, f"{member.name}.pose"),
            )
            for c, (number, member, figure) in enumerate(cast)
            if member.pose
        }
        self._legs: dict[int, Array] = {}

    @staticmethod
    def ground(turned: Array, p_WB: Array, tall: Array) -> tuple[Array, Array]:
        """Return the frames R_WG (n, 3, 3), p_WG (n, 3) of the ground below a body.

        Args:
            turned: (n,) its heading [rad].
            p_WB: (n, 3) where it is [m].
            tall: (n,) how high it goes [m].
        """
        p_WG = p_WB.copy()
        p_WG[:, 1] -= tall
        return heading(turned), p_WG

    def move_bodies(self, times: Array, turned: Array, R_WB: Array, p_WB: Array) -> None:
        """Put bodies (n, C), headed as `turned` (n, C), where they are to be at `times` (n,)."""
        for c, posture in self.of.items():
            R, p = posture.body(times)
            R_WG = heading(turned[:, c])
            R_WB[:, c] = R_WG @ R @ R_WG.transpose(0, 2, 1) @ R_WB[:, c]
            p_WB[:, c] += turn(R_WG, p)

    def keep_feet(self, goals: Array, q: Array, residual: Array) -> None:
        """Keep the feet of moved bodies where they are, leg by leg from the row before.

        A body that an author moves goes where no walk would have it, where `settle` may find
        now one pose of a leg, now another.

        Args:
            goals: (n, L, 3) where the tips are to be, relative to the bodies [m].
            q: (n, L, k) joint values of all legs; changed.
            residual: (n, L) distances that are left [m]; changed.
        """
        for c, posture in self.of.items():
            legs = np.flatnonzero(self.herd.owner == c)
            if not posture.plan.body or not len(legs):
                continue
            batch = self.herd.legs.rows(legs)
            before = self._legs.get(c, batch.preferred)
            for row in range(len(q)):
                wanted = TipPlacement(goals[row, legs]), PreferredValues(REST_PULL)
                first = row == 0 and c not in self._legs
                pursued = track_goals(
                    batch, before, wanted, max_steps=FIRST_POSE_STEPS if first else TRACKING_STEPS
                )
                q[row, legs] = before = pursued.pose.q
                residual[row, legs] = pursued.error * batch.lengths
            self._legs[c] = before

    def free(self, times: Array) -> Array:
        """Return what part of each leg's doing is left to itself (n, L)."""
        result = np.ones((len(times), len(self.herd.owner)))
        for c, posture in self.of.items():
            for i, leg in enumerate(np.flatnonzero(self.herd.owner == c)):
                result[:, leg] = posture.free(i, times)
        return result

    def move_joints(
        self,
        around: Mapping[int, FigureFrames],
        legs: tuple[Array, Array],
        others: tuple[Array, Array],
    ) -> list[tuple[int, GoalMiss]]:
        """Set joints as they are asked for.

        Args:
            around: where each of these creatures is.
            legs: joint values (n, L, k) and frames (n, L, k, 4, 4) of all legs; changed.
            others: those (n, M) and (n, M, 4, 4) of all other joints; changed.

        Returns:
            Creature and what it misses.
        """
        misses = list[tuple[int, GoalMiss]]()
        for c, posture in self.of.items():
            places = self._places(c)
            q = np.zeros((len(legs[0]), len(posture.figure.skeleton.joint_names)))
            for joints, which, own in places:
                q[:, joints] = (legs, others)[which][0][(slice(None), *own)]
            q, X, missed = posture.values(q, around[c])
            for joints, which, own in places:
                values, frames = (legs, others)[which]
                values[(slice(None), *own)] = q[:, joints]
                frames[(slice(None), *own)] = X[:, joints]
            misses.extend((c, miss) for miss in missed)
        return misses

    def _places(self, c: int) -> list[tuple[list[int], int, tuple[NDArray[np.int64] | int, ...]]]:
        """Return joints of a creature, whether they are others than legs', and where they stand."""
        places: list[tuple[list[int], int, tuple[NDArray[np.int64] | int, ...]]] = []
        legs = np.flatnonzero(self.herd.owner == c)
        for leg, limb in zip(legs, self.herd.figures[c].skeleton.legs, strict=True):
            places.append((list(limb.joints), 0, (int(leg), np.arange(len(limb.joints)))))
        own = np.flatnonzero(self.idlers.owner == c)
        places.append((self.idlers.number[own].tolist(), 1, (own,)))
        return places
