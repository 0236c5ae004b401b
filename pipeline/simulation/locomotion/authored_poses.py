"""Authored poses: creatures of a herd whose bodies, feet or joints their author poses."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_frames import FigureFrames
from pipeline.simulation.figures.figure_posture import FigurePosture
from pipeline.simulation.figures.goal_miss import GoalMiss
from pipeline.simulation.figures.pose_plan import plan_poses
from pipeline.simulation.figures.surroundings import GROUND, Surroundings
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array, heading, turn
from pipeline.spec.creature import Creature


class AuthoredPoses:
    """The authored poses of a herd.

    Attributes:
        postures: by creature.
        surroundings: that limbs keep clear of.
    """

    def __init__(
        self,
        cast: Sequence[tuple[int, Creature, Figure]],
        herd: Herd,
        free_joints: FreeJoints,
        seed: int,
        surroundings: Surroundings,
    ) -> None:
        self.herd, self.free_joints = herd, free_joints
        self.surroundings = surroundings
        known = {GROUND, *(solid.name for solid in surroundings.solids)}
        self.postures: Mapping[int, FigurePosture] = {
            c: FigurePosture(
                figure,
                plan_poses(member.pose, figure, f"cast[{number}].pose", known),
                generator(seed, f"{member.name}.pose"),
                surroundings,
            )
            for c, (number, member, figure) in enumerate(cast)
            if member.pose
        }

    @property
    def span(self) -> tuple[float, float]:
        """When the first key begins to take over, and when the last one ends [s]; 0, 0 for none."""
        plans = [posture.plan for posture in self.postures.values()]
        runs = [asked.run for plan in plans for asked in (*plan.points, *plan.joints)]
        runs += [run for plan in plans for run in plan.body]
        ends = [time for run in runs for time in (float(run.track.times[-1]), *run.let_go)]
        first = min((run.taken[0] for run in runs), default=0.0)
        return first, max((end for end in ends if math.isfinite(end)), default=0.0)

    def free_fraction(self, times: Array) -> Array:
        """Return the fraction (n, L) of each leg's motion that is left to the walk."""
        result = np.ones((len(times), len(self.herd.owner)))
        for c, posture in self.postures.items():
            for i, leg in enumerate(np.flatnonzero(self.herd.owner == c)):
                result[:, leg] = posture.free(i, times)
        return result

    def move_bodies(self, times: Array, headings: Array, R_WB: Array, p_WB: Array) -> None:
        """Move bodies (n, C) with headings (n, C) to their authored poses at `times` (n,)."""
        for c, posture in self.postures.items():
            R, p = posture.body(times)
            R_WG = heading(headings[:, c])
            R_WB[:, c] = R_WG @ R @ R_WG.transpose(0, 2, 1) @ R_WB[:, c]
            p_WB[:, c] += turn(R_WG, p)

    def move_joints(
        self,
        around: Mapping[int, FigureFrames],
        legs: tuple[Array, Array],
        others: tuple[Array, Array],
    ) -> list[tuple[int, GoalMiss]]:
        """Set joints to their authored poses.

        Args:
            around: surroundings of each creature with authored poses.
            legs: joint values (n, L, k) and frames (n, L, k, 4, 4) of all legs; changed.
            others: values (n, M) and frames (n, M, 4, 4) of all other joints; changed.

        Returns:
            Creatures and their misses.
        """
        misses = list[tuple[int, GoalMiss]]()
        for c, posture in self.postures.items():
            places = self._places(c)
            q = np.zeros((len(legs[0]), len(posture.figure.skeleton.joint_names)))
            for joints, kind, own in places:
                q[:, joints] = (legs, others)[kind][0][(slice(None), *own)]
            q, X, missed = posture.values(q, around[c])
            for joints, kind, own in places:
                values, frames = (legs, others)[kind]
                values[(slice(None), *own)] = q[:, joints]
                frames[(slice(None), *own)] = X[:, joints]
            misses.extend((c, miss) for miss in missed)
        return misses

    def _places(self, c: int) -> list[tuple[list[int], int, tuple[NDArray[np.int64] | int, ...]]]:
        """Return joints of a creature, 0 for legs or 1 for others, and their indices there."""
        places: list[tuple[list[int], int, tuple[NDArray[np.int64] | int, ...]]] = []
        legs = np.flatnonzero(self.herd.owner == c)
        for leg, limb in zip(legs, self.herd.figures[c].skeleton.legs, strict=True):
            places.append((list(limb.joints), 0, (int(leg), np.arange(len(limb.joints)))))
        own = np.flatnonzero(self.free_joints.owner == c)
        places.append((self.free_joints.number[own].tolist(), 1, (own,)))
        return places
