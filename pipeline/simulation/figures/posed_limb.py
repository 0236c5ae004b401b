"""Posed limb: the joint values of one limb that something is asked of, row after row.

What has taken over whole is followed by inverse kinematics from the row before; what is
taking over or letting go is blended with what the limb would do without it. So a limb
never jumps, and its joint values are its own before the first key and after the release.

Source: Sims 1987, 3.2.2, 6.2 and B.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.goals import Goal
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.point_goals import Toward
from pipeline.simulation.figures.pose_plan import PosePlan
from pipeline.simulation.figures.pursuit import Pursued, pursue
from pipeline.simulation.figures.reach import reach
from pipeline.simulation.figures.row_goals import RowGoals, targets_of
from pipeline.simulation.figures.surroundings import Surroundings
from pipeline.simulation.spatial import Array

PULL = 0.08
"""Part of the way to the limb's own values that redundancy goes in one step."""

RESTARTS = 8
"""Of the first pose, when there is none yet to go on from."""

FIRST, LATER = 60, 12
"""Bounds on the steps towards that first pose, and along the motion."""

MISSED = 2e-3
"""What is left of a goal that is worth a note, in lengths of the limb or radians."""

FASTEST = 14.0
"""Most that a joint turns or slides, whatever is asked [rad/s or m/s]."""

WHOLE = 1.0 - 1e-9
"""Weight from which on a run has taken over whole."""


@dataclass(frozen=True, slots=True)
class Miss:
    """A goal that a limb does not come to.

    Attributes:
        row: where it is missed.
        limb: name of the limb.
        gap: in lengths of the limb, or radians.
    """

    row: int
    limb: str
    gap: float


class PosedLimb:
    """One limb of a figure under its author's hands."""

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
        """Return how much each point, then each joint, has to say (n, m)."""
        runs = [asked.run for asked in (*self.points, *self.joints)]
        return np.stack([run.weight(times) for run in runs], axis=-1)

    def weight(self, times: Array) -> Array:
        """Return how much is taken over from the limb itself (n,)."""
        result: Array = self.weights(times).max(axis=-1)
        return result

    def follow(
        self, q: Array, around: Surroundings, R_BP: Array, p_BP: Array
    ) -> tuple[Array, list[Miss]]:
        """Return joint values as asked for, and what is missed.

        Args:
            q: (n, k) what they would be [rad or m].
            around: where the figure is.
            R_BP: (n, 3, 3) what the limb hangs on, relative to the body; with `p_BP` (n, 3)
                it is the identity as that was drawn.
            p_BP: see there [m].
        """
        weights = self.weights(around.times)
        most = weights.max(axis=-1)
        targets = [targets_of(asked, around, R_BP, p_BP) for asked in self.points]
        values = [asked.run.track(around.times)[:, 0] for asked in self.joints]
        result, misses = q.copy(), list[Miss]()
        for row in range(len(q)):
            if most[row] == 0.0:
                self._before = None
                continue
            here = [target[row] for target in targets], [value[row] for value in values]
            goals = RowGoals(self.points, self.joints, *here)
            found, left = self._row(q[row : row + 1], goals, weights[row] / most[row])
            if self._before is not None:
                found = self._before + _bounded(found - self._before, FASTEST * around.dt)
            if left > MISSED and most[row] > WHOLE:
                misses.append(Miss(row, self.limb.name, left))
            result[row] += most[row] * (found[0] - q[row])
            self._before = found
        return result, misses

    def _row(self, q: Array, goals: RowGoals, weights: Array) -> tuple[Array, float]:
        """Return the joint values (1, k) of one row, and what is left of its first goals."""
        if not weights[: len(self.points)].any():
            return goals.set_joints(q, weights), 0.0
        whole = np.where(weights > WHOLE, 1.0, 0.0)
        first = self._before is None
        start = self._start(q, goals, whole) if self._before is None else self._before
        pursued = self._pursued(start, goals.levels(whole), q, first)
        if (whole < 1.0).any():
            # What is still taking over asks for a part of the way from where it would be.
            goals = goals.partly(weights, self.batch, pursued.pose)
            pursued = self._pursued(pursued.pose.q, goals.levels(weights), q, False)
        return pursued.pose.q, float(pursued.error[0])

    def _pursued(self, start: Array, levels: list[Goal], q: Array, first: bool) -> Pursued:
        most = FIRST if first else LATER
        return pursue(
            self.batch,
            start,
            [*levels, Toward(q, PULL)],
            least=1 if most == LATER else FIRST // 4,
            most=most,
        )

    def _start(self, q: Array, goals: RowGoals, weights: Array) -> Array:
        """Return joint values (1, k) to begin at: near the place of the tip, if one is asked."""
        place = goals.place_of_tip(weights, self.batch.lower.shape[1] - 1)
        if place is None:
            return q
        start = self.batch.pose(np.clip(q, self.batch.lower, self.batch.upper))
        found = reach(self.batch, start, place[None], restarts=RESTARTS, rng=self.rng)
        return found.pose.q


def _bounded(step: Array, most: float) -> Array:
    """Return a step (1, k), shortened so that no joint moves more than `most`."""
    largest = float(np.abs(step).max(initial=0.0))
    return step if largest <= most else step * (most / largest)
