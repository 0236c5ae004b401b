"""Pursuit: limbs that follow goals of several priorities through time.

`reach` brings tips to places, whatever lies between. Here a limb is already near its goals
and stays with them: each moment it takes a few steps from the pose of the moment before, so
it keeps its branch and never jumps. Goals need not be about its tip.

Source: Sims 1987, 6.2 and B.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.goals import Goal
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.priority import Task, bounded_step
from pipeline.simulation.spatial import Array

STIFFNESS = 0.7
"""λ as a part of the error, λ² = |e|²/2 (Sugihara 2011): out of reach it keeps joints calm, and
where the goal is reached it vanishes."""

DAMPING = 1e-3
"""Least λ: near full extension a joint's speed stays bounded."""

MOST_TURN = 0.25
"""Most that a joint moves in one step [rad or m]."""

NEAR = 1e-5
"""Error of the first goals, in lengths of the limb and radians, that is good enough."""

STALLED = 1e-3
"""Part of the error that a step must take away to be worth another one."""


@dataclass(frozen=True, eq=False)
class Pursued:
    """Limbs with their goals.

    Attributes:
        pose: within the limits.
        error: (L,) what is left of the first goals, in lengths of the limb and radians.
    """

    pose: LimbPose
    error: Array


def pursue(
    batch: LimbBatch, start: Array, goals: Sequence[Goal], *, least: int = 1, most: int = 12
) -> Pursued:
    """Follow goals from joint values that are near them.

    Args:
        batch: the limbs.
        start: (L, n) joint values of the moment before [rad or m].
        goals: at least one, the first before all; the last is best a wish for joint values,
            such as `Preferred`, so that redundancy does not drift.
        least: steps that are taken anyhow, for what comes after the first goal.
        most: bound on the steps.
    """
    pose = batch.pose(np.clip(start, batch.lower, batch.upper))
    error = np.full(len(start), np.inf)
    for count in range(most + 1):
        tasks = [goal.task(batch, pose) for goal in goals]
        before, error = error, np.linalg.norm(tasks[0].velocity, axis=-1)
        if count == most or (count >= least and _done(error, before)):
            break
        pose = _stepped(batch, pose, tasks, error)
    return Pursued(pose, error)


def _done(error: Array, before: Array) -> bool:
    return bool(((error < NEAR) | (error > (1.0 - STALLED) * before)).all())


def _stepped(batch: LimbBatch, pose: LimbPose, tasks: Sequence[Task], error: Array) -> LimbPose:
    q, _ = bounded_step(batch, pose.q, tasks, DAMPING + STIFFNESS * np.minimum(error, 1.0))
    largest = np.abs(q - pose.q).max(axis=1, keepdims=True, initial=0.0)
    return batch.pose(pose.q + (q - pose.q) * (MOST_TURN / np.maximum(largest, MOST_TURN)))
