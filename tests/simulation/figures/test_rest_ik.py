"""Block-wise solutions match the plain iterations and do not depend on other limbs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.simulation.figures import rest_ik
from pipeline.simulation.figures.base_change import limb_between
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.inverse_kinematics import damped_step, damping_matrix
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.rest_ik import REST_GAINS, SEGMENT, solve_near_rest
from pipeline.simulation.figures.skeleton import Skeleton
from pipeline.simulation.spatial import Array

MOMENTS = 40


def _legs(figures: list[Figure]) -> tuple[LimbBatch, NDArray[np.int64]]:
    """Return the legs of figures, and the owner of each leg."""
    owner = [c for c, figure in enumerate(figures) for _ in figure.skeleton.legs]
    legs = [(figure.skeleton, leg) for figure in figures for leg in figure.skeleton.legs]
    return LimbBatch.of(legs), np.array(owner, dtype=np.int64)


def _goals(legs: LimbBatch, rng: np.random.Generator, wide: float = 1.0) -> Array:
    """Return foot positions (m, L, 3) as in walks [m]."""
    about = rng.uniform(-1, 1, (MOMENTS, len(legs.lengths), 3)) * [0.1, 0.05, 0.03]
    centre = legs.pose(legs.preferred).tips
    goals: Array = centre + (wide * about + [0.0, 0.05, 0.0]) * legs.lengths[:, None]
    return goals


def _plainly(legs: LimbBatch, goals: Array) -> tuple[Array, Array]:
    """Return joint values (L, n) and distances (L,) after plain iterations of all legs."""
    pose, damping = legs.pose(legs.preferred), damping_matrix(legs)
    for gain in REST_GAINS:
        error = goals - pose.tips
        distance = np.linalg.norm(error, axis=-1)
        part = np.minimum(1.0, SEGMENT * legs.lengths / np.maximum(distance, 1e-300))
        pull = np.full(len(goals), gain)
        pose = legs.pose(damped_step(legs, pose, error * part[:, None], pull, damping))
    return pose.q, np.linalg.norm(goals - pose.tips, axis=-1)


def test_solutions_match_plain_iterations(
    library: Callable[[str], Figure],
) -> None:
    names = ("beetle", "horse", "person", "kangaroo", "centipede")
    legs, owner = _legs([library(name) for name in names])
    goals = _goals(legs, np.random.default_rng(5), wide=2.0)
    settled = solve_near_rest(legs, group_chains(legs, owner), goals)
    for moment in range(MOMENTS):
        q, distance = _plainly(legs, goals[moment])
        near = distance < 1e-7 * legs.lengths  # the others are followed on by `solve`
        assert near.mean() > 0.5
        assert np.abs(settled.q[moment] - q)[near].max() < 1e-9


def test_frames_and_residuals_match_joint_values(shipped: Figure) -> None:
    legs, owner = _legs([shipped, shipped])
    if not len(owner):
        return
    goals = _goals(legs, np.random.default_rng(6))
    settled = solve_near_rest(legs, group_chains(legs, owner), goals)
    assert ((settled.q >= legs.lower) & (settled.q <= legs.upper)).all()
    for q, X, residual, goal in zip(settled.q, settled.X_BJ, settled.residual, goals, strict=True):
        pose = legs.pose(q)
        assert np.abs(X - pose.X_BJ)[legs.is_joint].max() < 1e-12 * max(1.0, legs.lengths.max())
        assert np.abs(residual - np.linalg.norm(goal - pose.tips, axis=-1)).max() < 1e-12


def test_random_chains_match_limb_poses(
    random_skeleton: Callable[[np.random.Generator, int], Skeleton],
) -> None:
    """Random chains have parallel, opposite and crossing axes, slides and coincident joints."""
    rng = np.random.default_rng(7)
    for _ in range(40):
        skeleton = random_skeleton(rng, 7)
        link = skeleton.links[int(rng.integers(4, 8))].name
        found = [limb_between(skeleton, "body", link)]
        legs = LimbBatch.of(found)
        axes = legs.axes.copy()
        for j in range(1, axes.shape[1]):
            like = rng.choice([0.0, 1.0, -1.0], p=[0.6, 0.2, 0.2])
            axes[0, j] = like * axes[0, j - 1] if like else axes[0, j]
        legs = replace(legs, axes=axes)
        (chain,) = group_chains(legs, np.zeros(1, dtype=np.int64))
        q = rng.uniform(-1.4, 1.4, legs.is_joint.shape)
        pose, k = legs.pose(q), q.shape[1]
        for j, frame in enumerate(chain.frames(q[0, :, None, None])):
            p = frame[3][:, 0, 0]
            if j < k:
                assert np.allclose(p, pose.X_BJ[0, j, :3, 3], atol=1e-12)
                R = chain.rotation(j, frame)[:, :, 0, 0]
                assert np.allclose(R, pose.X_BJ[0, j, :3, :3], atol=1e-12)
        assert np.allclose(p, pose.tips[0], atol=1e-12)


@pytest.mark.parametrize("block", [1, 7, 64, 100_000])
def test_results_do_not_depend_on_other_limbs(
    library: Callable[[str], Figure], monkeypatch: pytest.MonkeyPatch, block: int
) -> None:
    legs, owner = _legs([library(name) for name in ("beetle", "antelope", "person", "beetle")])
    goals = _goals(legs, np.random.default_rng(8))
    whole = solve_near_rest(legs, group_chains(legs, owner), goals)
    monkeypatch.setattr(rest_ik, "BLOCK_SIZE", block)
    for c in range(4):
        own = np.flatnonzero(owner == c)
        alone = legs.rows(own)
        for some in (slice(0, 1), slice(1, 4), slice(4, MOMENTS)):
            part = solve_near_rest(alone, group_chains(alone, owner[own]), goals[some][:, own])
            assert np.array_equal(part.q, whole.q[some][:, own])
            assert np.array_equal(part.X_BJ, whole.X_BJ[some][:, own])
            assert np.array_equal(part.residual, whole.residual[some][:, own])
