"""Closest: the pose between the limits that is nearest to a goal which cannot be reached.

There the error does not vanish, and with it stays what pseudo-inverse iterations leave
out: how the Jacobian changes. A stretched limb shows it best: to first order a bend costs
nothing, so the iterations bend it to and fro. Newton's method with the whole second
derivative of half the squared error e,

    JᵀJ - Σ_x e_x ∂²x/∂θ²,

arrives in a few steps.

Source: Bertsekas 1982 (projected Newton).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.goals import Placement
from pipeline.simulation.figures.jacobian import hessian
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.spatial import Array

FLAT = 1e-9
"""Slope of half the squared error, per radian, at which there is no way further down."""

STIFF = 1e-6
"""Least curvature that a step counts on."""

LONGEST = 0.3
"""Longest movement of a joint in one step [rad or m]."""

HALVINGS = 12


def closest(batch: LimbBatch, pose: LimbPose, aim: Placement, most: int = 40) -> LimbPose:
    """Return the limbs at a pose from which no small movement brings them nearer to `aim`."""
    for _ in range(most):
        task = aim.task(batch, pose)
        down = (task.velocity[:, None] @ task.jacobian)[:, 0]
        stopped = (pose.q <= batch.lower) & (down < 0.0) | (pose.q >= batch.upper) & (down > 0.0)
        free = batch.is_joint & ~stopped
        down = down * free
        if (np.abs(down).max(axis=1, initial=0.0) < FLAT).all():
            break
        step = _newton_step(batch, pose, aim, down, free)
        after = _downhill(batch, pose, aim, step)
        if after is None:
            break
        pose = after
    return pose


def _newton_step(
    batch: LimbBatch, pose: LimbPose, aim: Placement, down: Array, free: NDArray[np.bool_]
) -> Array:
    """Return the step (L, n) to the minimum of a convex model, in which `free` joints move."""
    task = aim.task(batch, pose)
    size = batch.lengths[:, None, None]
    curved = np.einsum("lijx,lx->lij", hessian(batch, pose)[..., :3], task.velocity[:, :3]) / size
    # Of orientations the change of the axes is left out: a model only has to lead down.
    H = task.jacobian.transpose(0, 2, 1) @ task.jacobian - 0.5 * (
        curved + curved.transpose(0, 2, 1)
    )
    both = free[:, :, None] & free[:, None, :]
    H = np.where(both, H, 0.0) + (~free)[:, :, None] * np.eye(free.shape[1])
    w, V = np.linalg.eigh(H)
    model = (V.transpose(0, 2, 1) @ down[..., None])[..., 0] / np.maximum(np.abs(w), STIFF)
    step: Array = (V @ model[..., None])[..., 0] * free
    largest = np.abs(step).max(axis=1, keepdims=True, initial=0.0)
    step *= LONGEST / np.maximum(largest, LONGEST)
    return step


def _downhill(batch: LimbBatch, pose: LimbPose, aim: Placement, step: Array) -> LimbPose | None:
    """Return the limbs one step on, halved until it leads nearer; None if none of them gets on."""
    before = np.linalg.norm(aim.task(batch, pose).velocity, axis=-1)
    moved = np.zeros(len(before), dtype=bool)
    result = pose
    for _ in range(HALVINGS):
        q = np.clip(pose.q + step, batch.lower, batch.upper)
        candidate = batch.pose(q)
        nearer = np.linalg.norm(aim.task(batch, candidate).velocity, axis=-1) < before
        result = candidate.where(nearer & ~moved, result)
        moved |= nearer
        if moved.all():
            break
        step = 0.5 * step
    return result if moved.any() else None
