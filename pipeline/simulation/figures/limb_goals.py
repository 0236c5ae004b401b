"""All goals of one limb in many rows at once, and their pursuit.

A row is the limb at one moment; no row knows of the others, so what is found for it does not
depend on how many are worked out together.

Source: Sims 1987, 3.2.2, 6.2, B.2 and B.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import hinge
from pipeline.simulation.figures.ik_goals import (
    Goal,
    JointTargets,
    PointDirection,
    PointOrientation,
    PointPlacement,
    dexterity_gradient,
    rotation_vector,
)
from pipeline.simulation.figures.inverse_kinematics import GOAL_PURSUIT
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.pose_plan import JointRun, PointRun, PoseRun
from pipeline.simulation.figures.surroundings import LimbSamples, Surroundings
from pipeline.simulation.figures.task_priority import Task, bounded_least_squares_step
from pipeline.simulation.spatial import Array, cross, normalized, rotation, turn, turn_inverse

PULL_GAIN = 0.3
"""Fraction of the way to the pulled values that redundancy goes in one step."""

PRIORITY_SCALE = 0.01
"""Errors of each priority count so much of those before: their squares ten thousandth."""

CLEARANCE = 0.03
"""Gap that limbs keep from obstacles, in their lengths."""

CLEARANCE_GAIN = 0.5
"""Fraction of a missing gap that one step makes up for."""

REACHED = 1e-6
"""Error that counts as none, in lengths of the limb or radians."""


@dataclass(frozen=True, eq=False)
class Clearance:
    """What the links of one limb keep clear of in n rows.

    Attributes:
        surroundings: the ground and solids.
        samples: points of the limb.
        times: (n,) [s].
        R_WP, p_WP: (n, 3, 3) and (n, 3) of what the limb hangs on [m].
        keep: gap that is kept, in lengths of the limb.
        ahead: (n, 3) displacements in the world by which the links keep clear, too [m].
    """

    surroundings: Surroundings
    samples: LimbSamples
    times: Array
    R_WP: Array
    p_WP: Array
    keep: float = CLEARANCE
    ahead: Array | None = None

    def rows(self, chosen: NDArray[np.int64]) -> Clearance:
        """Return the rows `chosen`."""
        return replace(
            self,
            times=self.times[chosen],
            R_WP=self.R_WP[chosen],
            p_WP=self.p_WP[chosen],
            ahead=None if self.ahead is None else self.ahead[chosen],
        )

    def gaps(self, pose: LimbPose, batch: LimbBatch) -> tuple[Array, Array, Array]:
        """Return the gaps (n, o, m) of the samples' surfaces, directions away, and places."""
        samples = self.samples
        X = pose.X_BJ[:, samples.columns]
        offsets = samples.places - batch.places[0, samples.columns]
        points = X[..., :3, 3] + turn(X[..., :3, :3], offsets)
        there = self.p_WP[:, None] + turn(self.R_WP[:, None], points)
        radii = samples.radii
        if self.ahead is not None:
            there = np.concatenate([there, there + self.ahead[:, None]], axis=1)
            points, radii = np.concatenate([points, points], axis=1), np.tile(radii, 2)
        gap, away = self.surroundings.gaps(self.times, there)
        return gap - radii, turn_inverse(self.R_WP[:, None, None], away), points

    def least_gap(self, pose: LimbPose, batch: LimbBatch) -> Array:
        """Return the least gap (n,) of each row [m]."""
        gap, _, _ = self.gaps(pose, batch)
        result: Array = gap.min(axis=(1, 2))
        return result

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Demand the missing gaps, which begin to act before they are missing."""
        size = float(batch.lengths[0])
        keep, width = self.keep * size, 0.5 * self.keep * size
        gap, away, points = self.gaps(pose, batch)
        missing = hinge(keep - gap, width)
        acting = np.clip((keep - gap + width) / (2.0 * width), 0.0, 1.0)
        axes = turn(pose.X_BJ[..., :3, :3], batch.axes)
        levers = points[:, :, None] - pose.X_BJ[:, None, :, :3, 3]
        J = np.where(batch.prismatic[:, None, :, None], axes[:, None], cross(axes[:, None], levers))
        columns = np.resize(self.samples.columns, points.shape[1])
        J = J * (np.arange(J.shape[2]) <= columns[:, None])[..., None]
        rows = np.sum(J[:, None] * away[:, :, :, None], axis=-1) * acting[..., None] / size
        count = len(rows)
        return Task(
            rows.reshape(count, -1, J.shape[2]),
            (CLEARANCE_GAIN * acting * missing / size).reshape(count, -1),
        )


def begins_at(keep: float, batch: LimbBatch) -> float:
    """Return the gap from which on a limb gives way [m], if it is to keep `keep` of its length."""
    return 1.5 * keep * float(batch.lengths[0])


@dataclass(frozen=True, eq=False)
class LimbGoals:
    """The goals of one limb in n rows.

    Attributes:
        points: goals of its nodes.
        joints: goals of its joints.
        targets: of each point: places (n, 3) [m], directions (n, 3) or rotations (n, 3, 3),
            relative to what the limb hangs on.
        values: (n, j) of the joints [rad or m].
        pull: (n, k) joint values to which redundancy leads [rad or m].
        dexterity: joint values [rad] that redundancy gains for a gradient of dexterity of one.
        clearance: what its links keep clear of.
    """

    points: Sequence[PointRun]
    joints: Sequence[JointRun]
    targets: Sequence[Array]
    values: Array
    pull: Array
    dexterity: float = 0.0
    clearance: Clearance | None = None

    def rows(self, chosen: NDArray[np.int64]) -> LimbGoals:
        """Return the goals in the rows `chosen`."""
        targets = [target[chosen] for target in self.targets]
        return replace(
            self,
            targets=targets,
            values=self.values[chosen],
            pull=self.pull[chosen],
            clearance=None if self.clearance is None else self.clearance.rows(chosen),
        )

    def repeated(self, count: int) -> LimbGoals:
        """Return the goals of the first row `count` times."""
        return self.rows(np.zeros(count, dtype=np.int64))

    def only(self, taken: Sequence[bool]) -> LimbGoals:
        """Return some of the goals: `taken` says which of the points, then of the joints."""
        here, there = taken[: len(self.points)], taken[len(self.points) :]
        chosen = [i for i, is_taken in enumerate(there) if is_taken]
        return replace(
            self,
            points=[run for run, is_taken in zip(self.points, here, strict=True) if is_taken],
            targets=[goal for goal, is_taken in zip(self.targets, here, strict=True) if is_taken],
            joints=[self.joints[i] for i in chosen],
            values=self.values[:, chosen],
        )

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Return all demands at `pose` as one, those of lower priority with little weight."""
        tasks = self._tasks(batch, pose)
        levels = sorted({run.priority for run, _ in tasks})
        scales = [
            run.weight**0.5 * PRIORITY_SCALE ** levels.index(run.priority) for run, _ in tasks
        ]
        demands = [task for _, task in tasks]
        if self.clearance is not None:
            scales.append(PRIORITY_SCALE ** len(levels))
            demands.append(self.clearance.task(batch, pose))
        return Task(
            np.concatenate(
                [c * task.jacobian for c, task in zip(scales, demands, strict=True)], axis=1
            ),
            np.concatenate(
                [c * task.velocity for c, task in zip(scales, demands, strict=True)], axis=1
            ),
        )

    def _tasks(self, batch: LimbBatch, pose: LimbPose) -> list[tuple[PoseRun, Task]]:
        goals: list[Goal] = [
            *map(_point_goal, self.points, self.targets),
            *map(_joint_goal, self.joints, self.values.T),
        ]
        runs = zip((*self.points, *self.joints), goals, strict=True)
        return [(run, goal.task(batch, pose)) for run, goal in runs]

    def partly(self, weights: Array, batch: LimbBatch, pose: LimbPose) -> LimbGoals:
        """Return goals that are only `weights` (n, m) of the way from what `pose` has."""
        targets = []
        for run, target, w in zip(self.points, self.targets, weights.T, strict=False):
            part = w[:, None]
            if run.goal == "reach":
                now = run.point.at(batch, pose)
                targets.append(now + part * (target - now))
            elif run.goal == "aim":
                now = turn(run.point.orientation(pose), run.point.along)
                targets.append(normalized(now + part * (target - now)))
            else:
                R = run.point.orientation(pose)
                targets.append(_partial_rotation(target @ R.transpose(0, 2, 1), w) @ R)
        values = self.values.copy()
        for i, joint in enumerate(self.joints):
            own = pose.q[:, joint.column]
            values[:, i] = own + weights[:, len(self.points) + i] * (values[:, i] - own)
        return replace(self, targets=targets, values=values)

    def misses(self, batch: LimbBatch, pose: LimbPose) -> Array:
        """Return how far (n, m) each goal is missed: metres of places, else radians."""
        gaps = [
            np.linalg.norm(_point_goal(run, target).task(batch, pose).velocity, axis=-1)
            * (batch.lengths if run.goal == "reach" else 1.0)
            for run, target in zip(self.points, self.targets, strict=True)
        ]
        gaps += [
            np.abs(value - pose.q[:, run.column])
            for run, value in zip(self.joints, self.values.T, strict=True)
        ]
        return np.stack(gaps, axis=-1)


def pursue(
    batch: LimbBatch,
    start: Array,
    goals: LimbGoals,
    max_steps: int,
    min_steps: int = 1,
    least_damping: float = GOAL_PURSUIT.damping,
) -> LimbPose:
    """Return the limb in all rows after the steps that their goals need.

    A row rests where its goals are reached or come no nearer.

    Args:
        batch: the limb alone, which serves for all rows.
        start: (n, k) joint values to go from [rad or m].
        goals: of n rows.
        max_steps: bound on the steps.
        min_steps: least number of steps, for the pull.
        least_damping: λ, which bounds how far joints go for what they hardly move.
    """
    pose = batch.pose(np.clip(start, batch.lower, batch.upper))
    rows = np.arange(len(start))
    before = np.full(len(start), np.inf)
    here, there = pose, goals
    for count in range(max_steps):
        task = there.task(batch, here)
        error = np.linalg.norm(task.velocity, axis=-1)
        going = (error > REACHED) & (error < (1.0 - GOAL_PURSUIT.stall_fraction) * before)
        if count < min_steps:
            going[:] = True
        if not going.all():
            left = np.flatnonzero(going)
            if not len(left):
                break
            rows, there = rows[left], there.rows(left)
            here, error = here.rows(left), error[left]
            task = Task(task.jacobian[left], task.velocity[left])
        damping = least_damping + GOAL_PURSUIT.stiffness * np.minimum(error, 1.0)
        wish = PULL_GAIN * (there.pull - here.q)
        if there.dexterity:
            wish += there.dexterity * dexterity_gradient(batch, here)
        q = bounded_least_squares_step(batch, here.q, task, wish, damping)
        largest = np.abs(q - here.q).max(axis=1, keepdims=True, initial=0.0)
        part = GOAL_PURSUIT.max_move / np.maximum(largest, GOAL_PURSUIT.max_move)
        here = batch.pose(here.q + (q - here.q) * part)
        before = error
        _store(pose, rows, here)
    return pose


def _store(pose: LimbPose, rows: NDArray[np.int64], new: LimbPose) -> None:
    pose.q[rows], pose.X_BJ[rows] = new.q, new.X_BJ
    pose.tips[rows], pose.jacobian[rows] = new.tips, new.jacobian


def _partial_rotation(R: Array, part: Array) -> Array:
    """Return fractions (n,) of rotations (n, 3, 3)."""
    vector = rotation_vector(R)
    angle = np.linalg.norm(vector, axis=-1)
    still = angle == 0.0
    axis = np.where(still[:, None], [1.0, 0.0, 0.0], vector) / np.where(still, 1.0, angle)[:, None]
    return rotation(axis, part * angle)


def _point_goal(run: PointRun, target: Array) -> Goal:
    if run.goal == "reach":
        return PointPlacement(run.point, target)
    if run.goal == "aim":
        return PointDirection(run.point, target)
    return PointOrientation(run.point, target)


def _joint_goal(run: JointRun, value: Array) -> Goal:
    columns = np.zeros(run.joints)
    columns[run.column] = 1.0
    return JointTargets(columns, columns * value[:, None])
