"""Forward kinematics against slower methods, and tips that are brought to goals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import JointTree, LimbBatch
from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.skeleton import BODY, Skeleton
from pipeline.simulation.figures.tip_ik import solve_tips
from pipeline.simulation.spatial import Array, rotation

UNEQUAL = (
    "{nodes: {a: [0, -1], b: [0, 1], k1: [1, -1], f1: [2, -1.2], f2: [2, 1],"
    " k3: [-1, -1], l3: [-1.5, -1.2], f3: [-2, -1.4], k4: [-1, 1], f4: [-2, 1.1]},"
    " chains: [[a, b], [a, k1, f1], [b, f2], [a, k3, l3, f3], [b, k4, f4]]}"
)


@pytest.fixture(scope="module", params=["beetle", "unequal"])
def skeleton(
    request: pytest.FixtureRequest, beetle: Figure, figure: Callable[..., Figure]
) -> Skeleton:
    return beetle.skeleton if request.param == "beetle" else figure(UNEQUAL).skeleton


@pytest.fixture(scope="module")
def legs(skeleton: Skeleton) -> LimbBatch:
    return LimbBatch.of([(skeleton, leg) for leg in skeleton.legs])


def _random(skeleton: Skeleton, n: int, seed: int = 1) -> Array:
    share = np.random.default_rng(seed).random((n, len(skeleton.lower)))
    return skeleton.lower + share * (skeleton.upper - skeleton.lower)


def _leg_values(skeleton: Skeleton, legs: LimbBatch, q: Array) -> Array:
    """Return the legs' joint values (L, n) out of the skeleton's (J,), padded."""
    result = np.zeros_like(legs.lower)
    for row, leg in enumerate(skeleton.legs):
        result[row, : len(leg.joints)] = q[list(leg.joints)]
    return result


def _recursive_pose(skeleton: Skeleton, q: Array, joint: int) -> tuple[Array, Array]:
    """Return a joint's pose by walking up to the body, one rotation at a time."""
    if joint == BODY:
        return np.eye(3), np.zeros(3)
    parent = int(skeleton.parents[joint])
    R, p = _recursive_pose(skeleton, q, parent)
    origin = skeleton.places[parent] if parent != BODY else np.zeros(3)
    p = p + R @ (skeleton.places[joint] - origin)
    return R @ rotation(skeleton.axes[joint], q[joint]), p


def test_tree_pose_matches_recursion(skeleton: Skeleton) -> None:
    tree = JointTree.of(skeleton)
    many = _random(skeleton, 5)
    X = tree.pose(many)
    R, p = X[..., :3, :3], X[..., :3, 3]
    for row, q in enumerate(many):
        for joint in range(len(q)):
            R_slow, p_slow = _recursive_pose(skeleton, q, joint)
            assert np.allclose(R[row, joint], R_slow, atol=1e-12)
            assert np.allclose(p[row, joint], p_slow, atol=1e-12)


def test_zero_pose_is_the_drawing(skeleton: Skeleton, legs: LimbBatch) -> None:
    tree = JointTree.of(skeleton)
    X = tree.pose(np.zeros(len(skeleton.parents)))
    assert np.allclose(X[:, :3, :3], np.eye(3))
    assert np.allclose(X[:, :3, 3], skeleton.places)
    assert np.allclose(legs.pose(np.zeros_like(legs.lower)).tips, legs.tips)


def test_limb_and_tree_poses_agree(skeleton: Skeleton, legs: LimbBatch) -> None:
    tree = JointTree.of(skeleton)
    for q in _random(skeleton, 10):
        X = tree.pose(q)
        pose = legs.pose(_leg_values(skeleton, legs, q))
        for row, leg in enumerate(skeleton.legs):
            joints = list(leg.joints)
            assert np.allclose(pose.X_BJ[row, : len(joints)], X[joints], atol=1e-12)
            last = joints[-1]
            tip = X[last, :3, 3] + X[last, :3, :3] @ (leg.tip - skeleton.places[last])
            assert np.allclose(pose.tips[row], tip, atol=1e-12)


def test_padding_joints_move_nothing(skeleton: Skeleton, legs: LimbBatch) -> None:
    counts = np.array([len(leg.joints) for leg in skeleton.legs])
    padding = np.arange(legs.lower.shape[1]) >= counts[:, None]
    q = _leg_values(skeleton, legs, _random(skeleton, 1)[0])
    pose = legs.pose(q)
    assert not pose.jacobian[padding].any()
    assert np.allclose(legs.pose(np.where(padding, 0.7, q)).tips, pose.tips)


def test_batched_legs_match_single_legs(skeleton: Skeleton, legs: LimbBatch) -> None:
    q = _leg_values(skeleton, legs, _random(skeleton, 1)[0])
    for row, leg in enumerate(skeleton.legs):
        alone = LimbBatch.of([(skeleton, leg)])
        n = len(leg.joints)
        assert np.allclose(alone.pose(q[row : row + 1, :n]).tips[0], legs.pose(q).tips[row])


def _solved(legs: LimbBatch, goals: Array) -> tuple[Array, Array]:
    """Return joint values (m, L, n) and distances (m, L) for goals (m, L, 3) [m]."""
    found = solve_tips(legs, group_chains(legs, np.zeros(len(legs.lengths), dtype=int)), goals)
    return found.q, found.residual


def test_success_rate_for_reachable_goals(beetle: Figure) -> None:
    """Goals are drawn from all joint values: many are met only with a joint at its limit."""
    skeleton = beetle.skeleton
    legs = LimbBatch.of([(skeleton, leg) for leg in skeleton.legs])
    goals = np.stack(
        [
            legs.pose(_leg_values(skeleton, legs, values)).tips
            for values in _random(skeleton, 300, seed=5)
        ]
    )
    q, residual = _solved(legs, goals)
    assert ((q >= legs.lower) & (q <= legs.upper)).all()
    assert (residual <= 1e-6 * legs.lengths).mean() >= 0.9


def test_goals_near_rest_are_reached(skeleton: Skeleton, legs: LimbBatch) -> None:
    bent = np.array([len(leg.links) > 1 for leg in skeleton.legs])
    rest = legs.pose(legs.preferred).tips
    shift = np.random.default_rng(3).normal(size=(50, *rest.shape))
    shift *= (0.2 * legs.lengths / np.linalg.norm(shift, axis=-1))[..., None]
    _, residual = _solved(legs, rest + shift)
    assert (residual <= 1e-6 * legs.lengths)[:, bent].all()


def test_unreachable_goal_is_approached(beetle: Figure) -> None:
    skeleton = beetle.skeleton
    legs = LimbBatch.of([(skeleton, leg) for leg in skeleton.legs])
    hips = legs.places[:, 0]
    for factor in (1.05, 1.5, 4.0):
        # Legs are drawn a little crooked in the plane that they do not bend in.
        span = np.linalg.norm(legs.tips - hips, axis=-1)
        goals = hips + factor * (legs.lengths / span)[:, None] * (legs.tips - hips)
        q, residual = _solved(legs, goals[None])
        distance = np.linalg.norm(goals - hips, axis=-1)
        assert (residual >= distance - legs.lengths - 1e-9).all()
        assert (residual <= distance - span + 0.04 * legs.lengths).all()
        assert np.isfinite(q).all()
