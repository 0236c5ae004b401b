"""Jacobians against finite differences and MuJoCo."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.simulation.figures.base_change import limb_between
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.kinematics import (
    JointTree,
    LimbBatch,
    LimbPose,
    hessian,
    jacobian,
    tree_jacobian,
)
from pipeline.simulation.figures.skeleton import BODY, Skeleton
from pipeline.simulation.spatial import Array, turn

Maker = Callable[[np.random.Generator, int], Skeleton]

H = 1e-5


def _values(skeleton: Skeleton, rng: np.random.Generator) -> Array:
    return skeleton.lower + rng.random(len(skeleton.lower)) * (skeleton.upper - skeleton.lower)


def _spin(before: Array, after: Array) -> Array:
    """Return the angular velocity times the time between two close rotations (..., 3, 3)."""
    D = after @ np.swapaxes(before, -1, -2)
    return 0.5 * np.stack(
        [D[..., 2, 1] - D[..., 1, 2], D[..., 0, 2] - D[..., 2, 0], D[..., 1, 0] - D[..., 0, 1]],
        axis=-1,
    )


def _differences(batch: LimbBatch, pose: LimbPose) -> tuple[Array, Array]:
    """Return the numeric Jᵀ (L, n, 6) and how it changes (L, n, n, 6)."""
    L, n = pose.q.shape
    J, dJ = np.zeros((L, n, 6)), np.zeros((L, n, n, 6))
    for k in range(n):
        step = np.zeros((L, n))
        step[:, k] = H
        a, b = batch.pose(pose.q - step), batch.pose(pose.q + step)
        J[:, k, :3] = (b.tips - a.tips) / (2 * H)
        J[:, k, 3:] = _spin(a.R_BF, b.R_BF) / (2 * H)
        dJ[:, k] = (jacobian(batch, b) - jacobian(batch, a)) / (2 * H)
    return J, dJ


def _check(skeleton: Skeleton, batch: LimbBatch, q: Array) -> None:
    pose = batch.pose(q)
    J, dJ = _differences(batch, pose)
    scale = max(1.0, float(batch.lengths.max()))
    assert np.abs(jacobian(batch, pose) - J).max() < 1e-6 * scale
    assert np.abs(hessian(batch, pose) - dJ).max() < 1e-6 * scale


def test_library_limbs_match_finite_differences(shipped: Figure) -> None:
    skeleton, rng = shipped.skeleton, np.random.default_rng(1)
    if not skeleton.limbs:
        return
    batch = LimbBatch.of([(skeleton, limb) for limb in skeleton.limbs])
    for _ in range(3):
        _check(
            skeleton,
            batch,
            batch.lower + rng.random(batch.lower.shape) * (batch.upper - batch.lower),
        )


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 2**32), joints=st.integers(1, 9))
def test_random_limbs_match_finite_differences(
    random_skeleton: Maker, seed: int, joints: int
) -> None:
    rng = np.random.default_rng(seed)
    skeleton = random_skeleton(rng, joints)
    a, b = rng.integers(0, joints + 1, 2)
    if a == b:
        a, b = 0, joints
    rooted, limb = limb_between(skeleton, skeleton.links[a].name, skeleton.links[b].name)
    batch = LimbBatch.of([(rooted, limb)])
    _check(rooted, batch, _values(skeleton, rng)[list(limb.joints)][None])


def _mujoco(skeleton: Skeleton) -> mujoco.MjModel:
    """Build the same figure in MuJoCo, one body a joint."""
    spec = mujoco.MjSpec()
    bodies = [spec.worldbody]
    for j, (parent, name) in enumerate(zip(skeleton.parents, skeleton.joint_names, strict=True)):
        above = skeleton.places[parent] if parent != BODY else np.zeros(3)
        body = bodies[parent + 1].add_body(name=name, pos=skeleton.places[j] - above)
        body.mass, body.inertia, body.explicitinertial = 1.0, [1.0, 1.0, 1.0], True
        kind = mujoco.mjtJoint.mjJNT_SLIDE if skeleton.prismatic[j] else mujoco.mjtJoint.mjJNT_HINGE
        body.add_joint(name=name, type=kind, axis=skeleton.axes[j])
        bodies.append(body)
    return spec.compile()


def _agrees(skeleton: Skeleton, rng: np.random.Generator) -> None:
    """Compare all poses, and the Jacobians of the far ends of all links, at random values."""
    model = _mujoco(skeleton)
    data, tree = mujoco.MjData(model), JointTree.of(skeleton)
    # MuJoCo numbers joints depth first.
    address = [int(model.joint(name).qposadr[0]) for name in skeleton.joint_names]
    body = [int(model.body(name).id) for name in skeleton.joint_names]
    for _ in range(3):
        q = _values(skeleton, rng)
        data.qpos[address] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        X = tree.pose(q)
        assert np.abs(X[:, :3, 3] - data.xpos[body]).max() < 1e-9
        assert np.abs(X[:, :3, :3].reshape(-1, 9) - data.xmat[body]).max() < 1e-9
        for link in skeleton.links:
            if link.joint == BODY:
                continue
            place = link.ends[1]
            frame = X[link.joint]
            tip = frame[:3, 3] + turn(frame[:3, :3], place - skeleton.places[link.joint])
            linear, angular = np.zeros((2, 3, model.nv))
            mujoco.mj_jac(model, data, linear, angular, tip, body[link.joint])
            ours = tree_jacobian(tree, q, link.joint, place)
            assert np.abs(ours[:, :3].T - linear[:, address]).max() < 1e-9
            assert np.abs(ours[:, 3:].T - angular[:, address]).max() < 1e-9


def test_library_figures_match_mujoco(shipped: Figure) -> None:
    _agrees(shipped.skeleton, np.random.default_rng(1))


def test_random_figures_match_mujoco(random_skeleton: Maker) -> None:
    rng = np.random.default_rng(2)
    for _ in range(30):
        _agrees(random_skeleton(rng, int(rng.integers(1, 13))), rng)


def test_limb_and_tree_jacobians_agree(shipped: Figure) -> None:
    skeleton, rng = shipped.skeleton, np.random.default_rng(5)
    tree, values = JointTree.of(skeleton), _values(skeleton, rng)
    for limb in skeleton.limbs:
        batch = LimbBatch.of([(skeleton, limb)])
        joints = list(limb.joints)
        # A limb is relative to its carrier, such as a head, which is at zero here.
        q = np.zeros_like(values)
        q[joints] = values[joints]
        J = jacobian(batch, batch.pose(q[joints][None]))[0]
        whole = tree_jacobian(tree, q, joints[-1], limb.tip)
        assert np.allclose(J, whole[joints], atol=1e-12)
