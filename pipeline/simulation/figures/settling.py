"""Settling: the joint values nearest to the preferred ones that bring tips to goals.

Unlike `solve`, which follows a motion from pose to pose, this always begins at the
preferred values and takes the same number of iterations. So a limb's pose is a function
of its goal alone, as smooth as the goal is; poses of many moments can be worked out at
once, in any order, and a limb comes back to the same pose with its foot.

Source: Sims 1987, 6.1, 6.2 and B.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.inverse import TOLERANCE, damping_of, iterate, solve
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.spatial import Array

SEGMENT = 0.35
"""Longest step of a tip in one iteration, as a part of the limb's length."""

GAINS = (0.6, 0.6, 0.6, 0.6, 0.3, 0.0, 0.0)
"""Gain α of the pull towards the preferred values, iteration by iteration; at the end
the tip is only brought home."""


@dataclass(frozen=True, eq=False)
class Settled:
    """Limbs at their goals.

    Attributes:
        pose: joint values within their limits, and what follows from them.
        residual: (L,) distance of tip from goal [m].
    """

    pose: LimbPose
    residual: Array


def settle(batch: LimbBatch, goals: Array) -> Settled:
    """Bring the tips to `goals` with joint values as near the preferred as can be.

    Args:
        batch: the limbs.
        goals: (L, 3) relative to the body [m].
    """
    pose = batch.pose(batch.preferred)
    longest, damping = SEGMENT * batch.lengths, damping_of(batch)
    for gain in GAINS:
        error = goals - pose.tips
        distance = np.sqrt((error * error).sum(axis=-1))
        part = np.minimum(1.0, longest / np.maximum(distance, 1e-300))
        pull = np.full(len(goals), gain)
        pose = batch.pose(iterate(batch, pose, error * part[:, None], pull, damping))
    residual = np.linalg.norm(goals - pose.tips, axis=-1)
    far = np.flatnonzero(residual > TOLERANCE * batch.lengths)
    if len(far):
        # Goals at the rim of what a limb reaches take smaller and more segments.
        rest = solve(batch.rows(far), pose.rows(far), goals[far], most=100)
        pose.q[far], pose.X_BJ[far], pose.tips[far] = rest.pose.q, rest.pose.X_BJ, rest.pose.tips
        residual[far] = rest.residual
    return Settled(pose, residual)
