"""Inverse kinematics through a ball joint: other branches, and limbs that need them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.simulation.figures.ball_joint_ik import ball_joint_branches, base_ball_joint
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.ik_goals import TipPlacement
from pipeline.simulation.figures.inverse_kinematics import TIP_ITERATION, closest_pose
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.reach_ik import reach
from pipeline.simulation.figures.skeleton import Skeleton
from pipeline.simulation.spatial import Array, normalized


def _uniform(batch: LimbBatch, rng: np.random.Generator) -> Array:
    return batch.lower + rng.random(batch.lower.shape) * (batch.upper - batch.lower)


def _some(skeleton: Skeleton, count: int, kind: str = "") -> LimbBatch:
    limbs = [limb for limb in skeleton.limbs if limb.kind == kind or not kind]
    return LimbBatch.of([(skeleton, limb) for limb in limbs for _ in range(count)])


@pytest.mark.sample(4)
@pytest.mark.slow
def test_an_unlimited_ball_joint_reaches_every_goal(shipped: Figure) -> None:
    """Where a bend gives the distance, a turn that no limit clips gives the place.

    Only close to the first axis may the tip fall between two of the swivels looked at: it
    comes as near to the plane across the second axis as half the angle between them.
    """
    batch = _some(shipped.skeleton, 40)
    goals = batch.pose(_uniform(batch, np.random.default_rng(1))).tips
    free = base_ball_joint(batch)
    batch = replace(
        batch,
        lower=np.where(free, -np.pi, batch.lower),
        upper=np.where(free, np.pi, batch.upper),
    )
    tips = np.stack([batch.pose(q).tips for q in ball_joint_branches(batch, goals)])
    origin = batch.places[:, 0]
    far = np.linalg.norm(tips - origin, axis=-1) - np.linalg.norm(goals - origin, axis=-1)
    to_goal = normalized(goals - origin)
    clear = np.linalg.norm(np.cross(batch.axes[:, 0], to_goal), axis=-1) > np.sin(np.pi / 15)
    as_far = (np.abs(far) <= 1e-6 * batch.lengths).any(axis=0)
    there = (np.linalg.norm(tips - goals, axis=-1) <= 2e-6 * batch.lengths).any(axis=0)
    assert as_far.mean() >= 0.6
    assert there[as_far & clear].all()


def test_branches_are_within_joint_limits(shipped: Figure) -> None:
    """Within reach and beyond it."""
    batch = _some(shipped.skeleton, 5)
    tips = batch.pose(_uniform(batch, np.random.default_rng(2))).tips
    for goals in (tips, batch.places[:, 0] + 3.0 * (tips - batch.places[:, 0])):
        ways = ball_joint_branches(batch, goals)
        assert (ways >= batch.lower).all()
        assert (ways <= batch.upper).all()


@pytest.mark.parametrize("name", ["person", "kangaroo"])
def test_branches_free_arms_stuck_at_a_limit(library: Callable[[str], Figure], name: str) -> None:
    """Iterations alone leave some limbs at the shoulder's limit; branches free them."""
    arms = _some(library(name).skeleton, 100, "arm")
    goals = arms.pose(_uniform(arms, np.random.default_rng(3))).tips
    start = arms.pose(arms.preferred)
    alone = closest_pose(arms, start, TipPlacement(goals), max_iterations=200)
    found = reach(arms, start, goals)
    stuck = np.linalg.norm(alone.tips - goals, axis=-1) > 1e-4 * arms.lengths
    assert stuck.mean() > 0.05
    assert (found.residual[stuck] <= TIP_ITERATION.tolerance * arms.lengths[stuck]).mean() >= 0.97


def test_left_and_right_arms_are_mirror_images(library: Callable[[str], Figure]) -> None:
    """Mirrored goals are reached with mirrored joint values."""
    skeleton = library("person").skeleton
    left, right = (
        LimbBatch.of([(skeleton, limb)] * 50) for limb in skeleton.limbs if limb.kind == "arm"
    )
    q = _uniform(left, np.random.default_rng(4))
    # Mirroring keeps angles about the lateral axis and negates the others.
    sign = np.where(np.abs(left.axes[..., 2]) > 0.5, 1.0, -1.0)
    mirrored = sign * q
    assert (mirrored >= right.lower - 1e-12).all()
    assert (mirrored <= right.upper + 1e-12).all()
    assert np.allclose(right.pose(mirrored).tips, left.pose(q).tips * [1, 1, -1])
