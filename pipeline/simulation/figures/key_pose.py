"""Key pose: joint values of one limb that meet the goals of a key, from any other pose if need be.

Source: Sims 1987, 6.2 and B.3.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.simulation.figures.ball_joint_ik import ball_joint_branches, base_ball_joint
from pipeline.simulation.figures.ik_goals import TipPlacement
from pipeline.simulation.figures.inverse_kinematics import closest_pose
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.limb_goals import LimbGoals, pursue
from pipeline.simulation.spatial import Array

KEY_STEPS = 60
"""Bound on the steps to the pose of a key."""

KEY_TOLERANCE = 1e-4
"""Error of a key's pose for which no other one is looked for, in lengths of the limb or radians."""

CANDIDATES, DRAWS = 12, 256
"""Poses that the search for a key's pose starts from, out of so many random ones and of those that
geometry gives."""

TRAVEL_COST = 0.05
"""Error that a start may have more for joints one radian nearer to the pose of the key before."""

DEPTH, DEPTH_COST = 0.02, 20.0
"""Depth in obstacles, in lengths of the limb, for which another pose is looked for, and joint
movement [rad] that a length less is worth."""


class KeyPoseSearch:
    """The search for poses of one limb.

    Args:
        batch: the limb alone.
        rng: of the random poses.
    """

    def __init__(self, batch: LimbBatch, rng: np.random.Generator) -> None:
        self.batch = batch
        shape = DRAWS, batch.lower.shape[1]
        self._draws = batch.lower + rng.random(shape) * (batch.upper - batch.lower)

    def pose_of(self, goals: LimbGoals, own: Array, start: Array) -> Array:
        """Return joint values (k,) for goals (one row), as near to `start` (k,) as there are any.

        Args:
            goals: of one row.
            own: (k,) the limb's own values.
            start: (k,) of the key before.
        """
        near = self._pursued(goals, np.stack([start, own]))
        own_cost = self.cost(goals.repeated(2), near)[0]
        if own_cost < KEY_TOLERANCE and self._depth(goals.repeated(2), near)[0] < DEPTH:
            return near.q[0]
        starts = np.concatenate([near.q, self._candidates(goals, start)])
        found = self._pursued(goals, starts)
        cost = self.cost(goals.repeated(len(starts)), found)
        depth = self._depth(goals.repeated(len(starts)), found)
        travel = np.abs(found.q - start).max(axis=1) + DEPTH_COST * depth
        reached = cost < KEY_TOLERANCE
        if reached.any():
            return found.q[np.where(reached, travel, np.inf).argmin()]
        return self._closest(goals, found.rows(np.array([cost.argmin()])))

    def _depth(self, goals: LimbGoals, pose: LimbPose) -> Array:
        """Return how deep (n,) links are in obstacles, in lengths of the limb."""
        if goals.clearance is None:
            return np.zeros(len(pose.q))
        gap = goals.clearance.least_gap(pose, self.batch)
        result: Array = np.maximum(-gap / self.batch.lengths[0], 0.0)
        return result

    def _pursued(self, goals: LimbGoals, starts: Array) -> LimbPose:
        same = goals.repeated(len(starts))
        return pursue(self.batch, starts, same, KEY_STEPS, min_steps=KEY_STEPS // 4)

    def cost(self, goals: LimbGoals, pose: LimbPose) -> Array:
        """Return the errors (n,) of poses, those of lower priority counting little.

        Gaps from obstacles are left out.
        """
        return self._whole_cost(replace(goals, clearance=None), pose)

    def _whole_cost(self, goals: LimbGoals, pose: LimbPose) -> Array:
        """Return the errors (n,) with missing gaps, which count less than any goal."""
        return np.linalg.norm(goals.task(self.batch, pose).velocity, axis=-1)

    def _candidates(self, goals: LimbGoals, start: Array) -> Array:
        """Return joint values (c, k) to search from."""
        batch = self.batch
        draws = [self._draws, batch.preferred, 0.5 * (batch.lower + batch.upper)]
        last = batch.lower.shape[1] - 1
        for run, target in zip(goals.points, goals.targets, strict=True):
            if run.goal == "reach" and run.point.column == last and base_ball_joint(batch).any():
                draws.append(ball_joint_branches(batch, target)[:, 0])
        q = np.concatenate(draws)
        cost = self._whole_cost(goals.repeated(len(q)), batch.pose(q))
        cost += TRAVEL_COST * np.abs(q - start).max(axis=1)
        return q[np.argsort(cost, kind="stable")[:CANDIDATES]]

    def _closest(self, goals: LimbGoals, pose: LimbPose) -> Array:
        """Return joint values (k,) from which no small movement leads nearer to the goals."""
        last = self.batch.lower.shape[1] - 1
        runs = goals.points
        if self.cost(goals, pose)[0] < KEY_TOLERANCE:
            return pose.q[0]
        if len(runs) == 1 and runs[0].goal == "reach" and runs[0].point.column == last:
            pose = closest_pose(self.batch, pose, TipPlacement(goals.targets[0]))
        return pose.q[0]
