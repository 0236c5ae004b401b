"""Posture: joint values of one figure as its author poses it, blended with its own motion.

Demands that have taken over completely are followed by inverse kinematics from the row before;
those that are taking over or ending are blended with the limb's own motion. So a limb never jumps,
and its joint values are its own before the first key and after the release.

Source: Sims 1987, 3.2.2, 6.2 and B.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.ik_goals import (
    Goal,
    JointPull,
    JointTargets,
    LeastSquaresGoals,
    PointDirection,
    PointOrientation,
    PointPlacement,
    rotation_vector,
)
from pipeline.simulation.figures.inverse_kinematics import TrackedPose, track_goals
from pipeline.simulation.figures.kinematics import JointTree, LimbBatch, LimbPose
from pipeline.simulation.figures.pose_plan import JointRun, PointRun, PosePlan
from pipeline.simulation.figures.reach_ik import reach
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.keyframe_track import rotation_from_angles
from pipeline.simulation.spatial import Array, normalized, rotation, turn, turn_inverse
from pipeline.spec.keyframes import Frame

REST_PULL = 0.08
"""Fraction of the way to the limb's own values that redundancy goes in one step."""

FIRST_POSE_RESTARTS = 8
"""Restarts of the first pose."""

FIRST_POSE_STEPS, TRACKING_STEPS = 60, 12
"""Bounds on the steps towards the first pose, and along the motion."""

MISS_TOLERANCE = 2e-3
"""Remaining error that is worth a note, in lengths of the limb or radians."""

MAX_JOINT_RATE = 14.0
"""Greatest rate of a joint [rad/s or m/s]."""

FULL_WEIGHT = 1.0 - 1e-9
"""Weight from which a run has taken over completely."""


@dataclass(frozen=True, eq=False)
class FigureFrames:
    """The place of a figure in n rows, and the frames of its author's values.

    Attributes:
        times: (n,) [s].
        dt: between two rows [s].
        R_WB, p_WB: (n, 3, 3) and (n, 3) pose of its body [m].
        R_WG, p_WG: (n, 3, 3) and (n, 3) of the ground below it, x along its heading [m].
    """

    times: Array
    dt: float
    R_WB: Array
    p_WB: Array
    R_WG: Array
    p_WG: Array

    def frame(self, name: Frame) -> tuple[Array, Array]:
        """Return the pose in the world of a frame named by the author."""
        if name == "body":
            return self.R_WB, self.p_WB
        if name == "feet":
            return self.R_WG, self.p_WG
        return np.broadcast_to(np.eye(3), self.R_WB.shape), np.zeros_like(self.p_WB)


def point_targets(point_run: PointRun, frames: FigureFrames, R_BP: Array, p_BP: Array) -> Array:
    """Return the targets of a node in n rows, relative to the parent of its limb.

    Args:
        point_run: the demand on the node.
        frames: of the figure.
        R_BP: (n, 3, 3) of the limb's parent, see `PosedLimb.follow`.
        p_BP: (n, 3) of the same [m].

    Returns:
        Places (n, 3) [m], directions (n, 3), or rotations (n, 3, 3).
    """
    values = point_run.run.track(frames.times)
    R_WG, p_WG = frames.frame(point_run.frame)
    R_WP = frames.R_WB @ R_BP
    if point_run.goal == "reach":
        p_WP = frames.p_WB + turn(frames.R_WB, p_BP)
        return turn_inverse(R_WP, p_WG + turn(R_WG, values) - p_WP)
    if point_run.goal == "aim":
        return normalized(turn_inverse(R_WP, turn(R_WG, values)))
    return R_WP.transpose(0, 2, 1) @ R_WG @ rotation_from_angles(values)


@dataclass(frozen=True, eq=False)
class RowGoals:
    """The demands on one limb in one row.

    Weights (m,) are those of its points, then of its joints, from 0 to 1.

    Attributes:
        points: demands on points.
        joints: demands on joints.
        targets: of each point: place (3,) [m], direction (3,) or rotation (3, 3).
        values: of each joint [rad or m].
    """

    points: Sequence[PointRun]
    joints: Sequence[JointRun]
    targets: Sequence[Array]
    values: Sequence[float]

    def levels(self, weights: Array) -> list[Goal]:
        """Return the active goals by priority, merging those of equal priority."""
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
            _merge_goals([(run.weight, goal) for run, goal in asked if run.priority == priority])
            for priority in sorted({run.priority for run, _ in asked})
        ]

    def set_joints(self, q: Array, weights: Array) -> Array:
        """Return joint values (1, k): those of its joints, and `q` for the others."""
        result = q.copy()
        for joint, value, weight in zip(
            self.joints, self.values, weights[len(self.points) :], strict=True
        ):
            result[0, joint.column] += weight * (value - result[0, joint.column])
        return result

    def place_of_tip(self, weights: Array, last: int) -> Array | None:
        """Return the target place of the tip (3,), if it is active; `last` is the last joint."""
        for run, target, weight in zip(self.points, self.targets, weights, strict=False):
            if weight > 0.0 and run.goal == "reach" and run.point.column == last:
                return target
        return None

    def partly(self, weights: Array, batch: LimbBatch, pose: LimbPose) -> RowGoals:
        """Return goals that are only `weights` of the way from those met at `pose`."""
        targets = []
        for run, target, w in zip(self.points, self.targets, weights, strict=False):
            if run.goal == "reach":
                now = run.point.at(batch, pose)[0]
                targets.append(now + w * (target - now))
            elif run.goal == "aim":
                now = turn(run.point.orientation(pose), run.point.along)[0]
                targets.append(normalized(now + w * (target - now)))
            else:
                R = run.point.orientation(pose)[0]
                targets.append(_partial_rotation(target @ R.T, float(w)) @ R)
        values = self.set_joints(pose.q, weights)[0]
        return replace(self, targets=targets, values=[values[j.column] for j in self.joints])


def _partial_rotation(R: Array, part: float) -> Array:
    """Return a fraction of the rotation `R` (3, 3)."""
    vector = rotation_vector(R)
    angle = float(np.linalg.norm(vector))
    return rotation(vector / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0]), part * angle)


def _goal(run: PointRun, target: Array) -> Goal:
    if run.goal == "reach":
        return PointPlacement(run.point, target[None])
    if run.goal == "aim":
        return PointDirection(run.point, target[None])
    return PointOrientation(run.point, target[None])


def _joint_goal(run: JointRun, value: float) -> Goal:
    columns = np.zeros(run.joints)
    columns[run.column] = 1.0
    return JointTargets(columns, columns * value)


def _merge_goals(goals: list[tuple[float, Goal]]) -> Goal:
    return goals[0][1] if len(goals) == 1 else LeastSquaresGoals(goals)


@dataclass(frozen=True, slots=True)
class GoalMiss:
    """A goal that a limb misses.

    Attributes:
        row: of the miss.
        limb: name of the limb.
        gap: in lengths of the limb, or radians.
    """

    row: int
    limb: str
    gap: float


class PosedLimb:
    """One posed limb of a figure."""

    def __init__(
        self, figure: Figure, number: int, plan: PosePlan, rng: np.random.Generator
    ) -> None:
        skeleton = figure.skeleton
        self.limb = skeleton.limbs[number]
        self.batch = LimbBatch.of([(skeleton, self.limb)])
        self.above = int(skeleton.parents[self.limb.joints[0]])
        self.points = [run for run in plan.points if run.limb == number]
        self.joints = [run for run in plan.joints if run.limb == number]
        self.rng = rng
        self._before: Array | None = None

    def weights(self, times: Array) -> Array:
        """Return the weights (n, m) of each point, then of each joint."""
        runs = [asked.run for asked in (*self.points, *self.joints)]
        return np.stack([run.weight(times) for run in runs], axis=-1)

    def weight(self, times: Array) -> Array:
        """Return the weight (n,) of the demands against the limb's own motion."""
        return self.weights(times).max(axis=-1)

    def follow(
        self, q: Array, frames: FigureFrames, R_BP: Array, p_BP: Array
    ) -> tuple[Array, list[GoalMiss]]:
        """Return posed joint values, and misses.

        Args:
            q: (n, k) the limb's own values [rad or m].
            frames: of the figure.
            R_BP: (n, 3, 3) of the limb's parent relative to the body; with `p_BP` (n, 3) it is the
                identity as drawn.
            p_BP: see `R_BP` [m].
        """
        weights = self.weights(frames.times)
        most = weights.max(axis=-1)
        targets = [point_targets(asked, frames, R_BP, p_BP) for asked in self.points]
        values = [asked.run.track(frames.times)[:, 0] for asked in self.joints]
        result, misses = q.copy(), list[GoalMiss]()
        for row in range(len(q)):
            if most[row] == 0.0:
                self._before = None
                continue
            here = [target[row] for target in targets], [value[row] for value in values]
            goals = RowGoals(self.points, self.joints, *here)
            found, left = self._row(q[row : row + 1], goals, weights[row] / most[row])
            if self._before is not None:
                found = self._before + _limit_step(found - self._before, MAX_JOINT_RATE * frames.dt)
            if left > MISS_TOLERANCE and most[row] > FULL_WEIGHT:
                misses.append(GoalMiss(row, self.limb.name, left))
            result[row] += most[row] * (found[0] - q[row])
            self._before = found
        return result, misses

    def _row(self, q: Array, goals: RowGoals, weights: Array) -> tuple[Array, float]:
        """Return the joint values (1, k) of one row, and the remaining error of its first goals."""
        if not weights[: len(self.points)].any():
            return goals.set_joints(q, weights), 0.0
        whole = np.where(weights > FULL_WEIGHT, 1.0, 0.0)
        first = self._before is None
        start = self._start(q, goals, whole) if self._before is None else self._before
        pursued = self._pursued(start, goals.levels(whole), q, first)
        if (whole < 1.0).any():
            # Demands that are still taking over ask for a fraction of their way.
            goals = goals.partly(weights, self.batch, pursued.pose)
            pursued = self._pursued(pursued.pose.q, goals.levels(weights), q, False)
        return pursued.pose.q, float(pursued.error[0])

    def _pursued(self, start: Array, levels: list[Goal], q: Array, first: bool) -> TrackedPose:
        most = FIRST_POSE_STEPS if first else TRACKING_STEPS
        return track_goals(
            self.batch,
            start,
            [*levels, JointPull(q, REST_PULL)],
            min_steps=1 if most == TRACKING_STEPS else FIRST_POSE_STEPS // 4,
            max_steps=most,
        )

    def _start(self, q: Array, goals: RowGoals, weights: Array) -> Array:
        """Return start values (1, k): near the place of the tip, if one is demanded."""
        place = goals.place_of_tip(weights, self.batch.lower.shape[1] - 1)
        if place is None:
            return q
        start = self.batch.pose(np.clip(q, self.batch.lower, self.batch.upper))
        found = reach(self.batch, start, place[None], restarts=FIRST_POSE_RESTARTS, rng=self.rng)
        return found.pose.q


def _limit_step(step: Array, limit: float) -> Array:
    """Return a step (1, k), shortened so that no joint moves more than `limit`."""
    largest = float(np.abs(step).max(initial=0.0))
    return step if largest <= limit else step * (limit / largest)


@dataclass(frozen=True, eq=False)
class FigurePosture:
    """One posed figure; its limbs remember the row before.

    Attributes:
        figure: the figure.
        plan: its demands.
        rng: for the first pose of a limb.
    """

    figure: Figure
    plan: PosePlan
    rng: np.random.Generator

    @cached_property
    def _tree(self) -> JointTree:
        return JointTree.of(self.figure.skeleton)

    @cached_property
    def _limbs(self) -> dict[int, PosedLimb]:
        """Limbs with demands; one that hangs on another comes after it."""
        limbs = {i: PosedLimb(self.figure, i, self.plan, self.rng) for i in self.plan.limbs()}
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
        for i, limb in self._limbs.items():
            joints = list(skeleton.limbs[i].joints)
            R_BP: Array = np.broadcast_to(np.eye(3), (len(q), 3, 3))
            p_BP = np.zeros((len(q), 3))
            if limb.above != BODY:
                # Relative to what it hangs on, as that was drawn.
                R_BP = X[:, limb.above, :3, :3]
                p_BP = X[:, limb.above, :3, 3] - turn(R_BP, skeleton.places[limb.above])
            q[:, joints], missed = limb.follow(q[:, joints], frames, R_BP, p_BP)
            misses.extend(missed)
            X = self._tree.pose(q)
        return q, X, misses
