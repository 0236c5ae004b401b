"""Limbs reach their goals without jumps, and do not depend on other limbs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.simulation.figures import tip_ik
from pipeline.simulation.figures.ball_joint_ik import full_reach
from pipeline.simulation.figures.base_change import limb_between
from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.skeleton import Skeleton
from pipeline.simulation.figures.tip_ik import solve_tips
from pipeline.simulation.spatial import Array, turn
from pipeline.spec import read_scene

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


@pytest.mark.sample(7)
def test_tips_reach_their_goals(shipped: Figure) -> None:
    legs, owner = _legs([shipped])
    if not len(owner):
        return
    goals = _goals(legs, np.random.default_rng(5), wide=1.5)
    found = solve_tips(legs, group_chains(legs, owner), goals)
    # Legs that stand almost straight, as a giraffe's, cannot reach all of these.
    beyond = np.linalg.norm(goals - legs.places[:, 0], axis=-1) - full_reach(legs)
    assert (beyond > 0).mean() < 0.1
    assert (found.residual < 1e-6 * legs.lengths)[beyond <= 0].mean() > 0.99
    assert (found.residual - beyond < 0.01 * legs.lengths)[beyond > 0].all()


@pytest.mark.sample(7)
def test_at_rest_all_joints_have_their_preferred_values(shipped: Figure) -> None:
    legs, owner = _legs([shipped])
    if not len(owner):
        return
    rest = legs.pose(legs.preferred).tips
    found = solve_tips(legs, group_chains(legs, owner), rest[None])
    assert np.abs(found.q[0] - legs.preferred).max() < 0.01


@pytest.mark.sample(4)
def test_bends_are_those_of_two_equal_links(shipped: Figure) -> None:
    """No joint bends faster than twice as fast as one of two equal links, and steps halve."""
    legs, owner = _legs([shipped])
    if not len(owner):
        return
    chains, base = group_chains(legs, owner), legs.places[:, 0]
    shortest = np.empty(len(owner))
    for chain in chains:
        shortest[chain.rows] = chain.path.shortest[chain.on_path[:, 0]]
    for seed in range(4):
        paths = [_foot_path(legs, np.random.default_rng(seed), rows) for rows in (401, 801)]
        coarse, fine = (solve_tips(legs, chains, goals) for goals in paths)
        speed = np.linalg.norm(np.diff(paths[0], axis=0), axis=-1)
        distance = np.linalg.norm(paths[0] - base, axis=-1)
        stretch = distance / legs.lengths
        stretch = np.maximum(stretch[1:], stretch[:-1])
        needed = 2.0 * speed / (legs.lengths * np.sqrt(1.0 - stretch**2))
        bends = np.abs(np.diff(coarse.q, axis=0))[..., 3:].max(axis=-1)
        # The others are quicker where a joint has met its limit or is about to.
        free = (coarse.q > legs.lower + 0.1) & (coarse.q < legs.upper - 0.1)
        free[..., :3] = True
        near = (distance > 1.3 * shortest) & (free | ~legs.is_joint).all(axis=-1)
        assert (bends <= 2.0 * needed + 1e-3)[near[1:] & near[:-1]].all()
        assert near.mean() > 0.3
        assert (coarse.residual[near] < 1e-6 * legs.lengths.max()).all()
        halves = np.abs(np.diff(fine.q, axis=0)).max() / np.abs(np.diff(coarse.q, axis=0)).max()
        assert 0.4 < halves < 0.65


def _foot_path(legs: LimbBatch, rng: np.random.Generator, rows: int) -> Array:
    """Return feet (rows, L, 3) that step in place, within 96 % of their reach [m]."""
    t = np.linspace(0.0, 2.0 * np.pi, rows)[:, None]
    wide, high = rng.uniform(0.05, 0.2, 2)
    way = np.concatenate(
        [wide * np.cos(t), high * (1.0 + np.sin(t)), 0.1 * wide * np.sin(2.0 * t)], axis=1
    )
    goals = legs.pose(legs.preferred).tips + way[:, None] * legs.lengths[:, None]
    arm = goals - legs.places[:, 0]
    far = np.linalg.norm(arm, axis=-1, keepdims=True)
    most = 0.96 * legs.lengths[:, None]
    result: Array = legs.places[:, 0] + arm * np.minimum(1.0, most / far)
    return result


@pytest.mark.sample(7)
def test_feet_keep_their_direction_and_legs_stay_calm(shipped: Figure) -> None:
    legs, owner = _legs([shipped])
    chains = group_chains(legs, owner) if len(owner) else []
    with_feet = [chain.rows for chain in chains if chain.foot is not None]
    if not with_feet:
        return
    own = np.concatenate(with_feet)
    rest = legs.pose(legs.preferred)
    goals = _foot_path(legs, np.random.default_rng(3), 401)
    last = legs.is_joint[own].sum(axis=1) - 1
    link = rest.tips[own] - rest.X_BJ[own, last, :3, 3]
    kept = link / np.linalg.norm(link, axis=-1, keepdims=True)
    wanted = np.zeros_like(goals)
    wanted[:, own] = kept
    alone, held = solve_tips(legs, chains, goals), solve_tips(legs, chains, goals, wanted)
    assert (held.residual[:, own] < 1e-6 * legs.lengths[own]).all()
    off = []
    for found in (alone, held):
        tips = goals[:, own] - found.X_BJ[:, own, last][..., :3, 3]
        tips /= np.linalg.norm(tips, axis=-1, keepdims=True)
        off.append(np.arccos(np.clip((tips * kept).sum(axis=-1), -1.0, 1.0)).mean())
    # As far as joints stay calm: little where a leg is folded at rest, as that of a kangaroo.
    assert off[1] < 0.9 * off[0]
    arm = goals - legs.places[:, 0]
    stretch = np.linalg.norm(arm, axis=-1) / legs.lengths
    stretch = np.maximum(stretch[1:], stretch[:-1])[:, own]
    speed = np.linalg.norm(np.diff(goals, axis=0), axis=-1)[:, own]
    needed = 2.0 * speed / (legs.lengths[own] * np.sqrt(1.0 - stretch**2))
    bends = np.abs(np.diff(held.q, axis=0))[:, own, 3:].max(axis=-1)
    calm = (stretch > 0.3) & (stretch < 0.97)
    assert (bends <= 2.0 * needed + 1e-3)[calm].all()


@pytest.mark.sample(7)
def test_frames_and_residuals_match_joint_values(shipped: Figure) -> None:
    legs, owner = _legs([shipped, shipped])
    if not len(owner):
        return
    goals = _goals(legs, np.random.default_rng(6))
    settled = solve_tips(legs, group_chains(legs, owner), goals)
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


@pytest.mark.nightly
@pytest.mark.parametrize("block", [1, 7, 64, 100_000])
def test_results_do_not_depend_on_other_limbs(
    library: Callable[[str], Figure], monkeypatch: pytest.MonkeyPatch, block: int
) -> None:
    legs, owner = _legs([library(name) for name in ("beetle", "antelope", "person", "beetle")])
    goals = _goals(legs, np.random.default_rng(8))
    whole = solve_tips(legs, group_chains(legs, owner), goals)
    monkeypatch.setattr(tip_ik, "BLOCK_SIZE", block)
    for c in range(4):
        own = np.flatnonzero(owner == c)
        alone = legs.rows(own)
        for some in (slice(0, 1), slice(1, 4), slice(4, MOMENTS)):
            part = solve_tips(alone, group_chains(alone, owner[own]), goals[some][:, own])
            assert np.array_equal(part.q, whole.q[some][:, own])
            assert np.array_equal(part.X_BJ, whole.X_BJ[some][:, own])
            assert np.array_equal(part.residual, whole.residual[some][:, own])


FLAT_FEET = """
pronk: 1
duration: 1
figures:
  walker:
    style: mammal
    pitch_deg: 80
    nodes: {chest: [0, -0.35], pelvis: [0, 0.15], hip_l: [-0.12, 0.15], knee_l: [-0.5, %s],
            ankle_l: [-0.95, 0.15], toe_l: [-0.98, -0.05]}
    chains: [[chest, pelvis], [pelvis, hip_l, chest], [hip_l, knee_l, ankle_l, toe_l]]
    then: [{mirror: x}]
cast: [{figure: walker}]
"""


@pytest.mark.parametrize("knee", [0.05, 0.1, 0.15])
def test_knees_fold_legs_that_stand_on_flat_feet(knee: float) -> None:
    """The foot has the longest lever, and mostly keeps its direction: its ankle does not fold."""
    scene = read_scene(FLAT_FEET % knee)
    legs, owner = _legs([build_figure("walker", scene.figures["walker"], 1.0)])
    rest = legs.pose(legs.preferred)
    hips = legs.places[:, 0]
    parts = np.linspace(1.0, 0.55, 20)[:, None, None]
    found = solve_tips(legs, group_chains(legs, owner), hips + parts * (rest.tips - hips))
    assert found.residual.max() < 1e-6
    last = legs.is_joint.sum(axis=1)[0] - 1
    feet = turn(found.X_BJ[:, :, last, :3, :3], legs.tips - legs.places[:, last])
    angles = np.arctan2(feet[..., 1], feet[..., 0])
    assert np.abs(angles - angles[0]).max() < np.radians(25.0)
    assert (np.abs(found.q[-1] - found.q[0])[:, last - 1] > np.radians(50.0)).all()
