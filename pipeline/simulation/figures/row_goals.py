"""Row goals: what is asked of one limb in one row, by priority.

Source: Sims 1987, B.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.figures.goals import Goal, rotation_vector
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.point_goals import (
    Compromise,
    JointsAt,
    PointAimed,
    PointAt,
    PointTurned,
)
from pipeline.simulation.figures.pose_plan import JointRun, PointRun
from pipeline.simulation.figures.surroundings import Surroundings
from pipeline.simulation.spatial import Array, normalized, rotation, turn, unturn
from pipeline.simulation.tracks import turned


def targets_of(asked: PointRun, around: Surroundings, R_BP: Array, p_BP: Array) -> Array:
    """Return what is asked of a node in n rows, relative to what its limb hangs on.

    Args:
        asked: of a node.
        around: where the figure is.
        R_BP: (n, 3, 3) of what the limb hangs on, see `PosedLimb.follow`.
        p_BP: (n, 3) of the same [m].

    Returns:
        Places (n, 3) [m], directions (n, 3), or rotations (n, 3, 3).
    """
    values = asked.run.track(around.times)
    R_WG, p_WG = around.frame(asked.frame)
    R_WP = around.R_WB @ R_BP
    if asked.goal == "reach":
        p_WP = around.p_WB + turn(around.R_WB, p_BP)
        return unturn(R_WP, p_WG + turn(R_WG, values) - p_WP)
    if asked.goal == "aim":
        return normalized(unturn(R_WP, turn(R_WG, values)))
    result: Array = R_WP.transpose(0, 2, 1) @ R_WG @ turned(values)
    return result


@dataclass(frozen=True, eq=False)
class RowGoals:
    """What is asked of one limb in one row.

    Weights (m,) are those of its points, then of its joints, from 0 to 1.

    Attributes:
        points: that something is asked of.
        joints: that something is asked of.
        targets: of each point: place (3,) [m], direction (3,) or rotation (3, 3).
        values: of each joint [rad or m].
    """

    points: Sequence[PointRun]
    joints: Sequence[JointRun]
    targets: Sequence[Array]
    values: Sequence[float]

    def levels(self, weights: Array) -> list[Goal]:
        """Return the goals that count, those of one priority as one, the first before all."""
        goals = [
            *map(_goal, self.points, self.targets),
            *map(_joint_goal, self.joints, self.values),
        ]
        asked = [
            (run, goal)
            for run, goal, weight in zip((*self.points, *self.joints), goals, weights, strict=True)
            if weight > 0.0
        ]
        return [
            _one([(run.weight, goal) for run, goal in asked if run.priority == priority])
            for priority in sorted({run.priority for run, _ in asked})
        ]

    def set_joints(self, q: Array, weights: Array) -> Array:
        """Return joint values (1, k): those of its joints, and `q` of all others."""
        result = q.copy()
        for joint, value, weight in zip(
            self.joints, self.values, weights[len(self.points) :], strict=True
        ):
            result[0, joint.column] += weight * (value - result[0, joint.column])
        return result

    def place_of_tip(self, weights: Array, last: int) -> Array | None:
        """Return where the tip is to be (3,), if that counts; `last` is the last joint."""
        for run, target, weight in zip(self.points, self.targets, weights, strict=False):
            if weight > 0.0 and run.goal == "reach" and run.point.column == last:
                return target
        return None

    def partly(self, weights: Array, batch: LimbBatch, pose: LimbPose) -> RowGoals:
        """Return goals that are each but `weights` of the way from what there is at `pose`."""
        targets = []
        for run, target, w in zip(self.points, self.targets, weights, strict=False):
            if run.goal == "reach":
                now = run.point.at(batch, pose)[0]
                targets.append(now + w * (target - now))
            elif run.goal == "aim":
                now = turn(run.point.turned(pose), run.point.along)[0]
                targets.append(normalized(now + w * (target - now)))
            else:
                R = run.point.turned(pose)[0]
                targets.append(_part(target @ R.T, float(w)) @ R)
        values = self.set_joints(pose.q, weights)[0]
        return replace(self, targets=targets, values=[values[j.column] for j in self.joints])


def _part(R: Array, part: float) -> Array:
    """Return a part of the turn `R` (3, 3)."""
    vector = rotation_vector(R)
    angle = float(np.linalg.norm(vector))
    return rotation(vector / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0]), part * angle)


def _goal(run: PointRun, target: Array) -> Goal:
    if run.goal == "reach":
        return PointAt(run.point, target[None])
    if run.goal == "aim":
        return PointAimed(run.point, target[None])
    return PointTurned(run.point, target[None])


def _joint_goal(run: JointRun, value: float) -> Goal:
    columns = np.zeros(run.joints)
    columns[run.column] = 1.0
    return JointsAt(columns, columns * value)


def _one(asked: list[tuple[float, Goal]]) -> Goal:
    return asked[0][1] if len(asked) == 1 else Compromise(asked)
