"""Inverse kinematics by pseudo-inverse iterations, for many limbs at once.

`damped_step` is one iteration; redundancy pulls towards the preferred values.

`closest_pose` finds the pose within the limits nearest to an unreachable goal. There the error
does not vanish, and with it remains the change of the Jacobian, which pseudo-inverse iterations
leave out. A stretched limb shows it best: to first order a bend costs nothing, so the iterations
bend it to and fro. Newton's method with the full second derivative of half the squared error e,

    JᵀJ - Σ_x e_x ∂²x/∂θ²,

arrives in a few steps.

Notation of the thesis: x tip position, θ joint values (here q), J Jacobian.

Source: Sims 1987, 6.1, 6.2 and appendix B; Bertsekas 1982 (projected Newton).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.ik_goals import TipPlacement
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose, hessian
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, slots=True)
class TipIteration:
    """Constants of the pseudo-inverse iterations, distances in lengths of the limb.

    Attributes:
        segment: longest step of a tip in one iteration.
        rest_gain: gain of the secondary goal (α in eq. B.7), the fraction of the way to the
            preferred values in one iteration.
        redundancy_cutoff: distance of tip from goal below which redundancy is left alone after the
            first iteration: its disturbance would have to be corrected again.
        tolerance: accepted distance of tip from goal.
    """

    segment: float = 0.15
    rest_gain: float = 0.25
    redundancy_cutoff: float = 1e-2
    tolerance: float = 1e-6


@dataclass(frozen=True, slots=True)
class NewtonSearch:
    """Constants of the search for the closest pose.

    Attributes:
        flat_slope: slope of half the squared error, per radian, that counts as flat.
        min_curvature: least curvature assumed by a step.
        max_move: longest movement of a joint in one step [rad or m].
        halvings: of a step that leads farther away, in a line search.
    """

    flat_slope: float = 1e-9
    min_curvature: float = 1e-6
    max_move: float = 0.3
    halvings: int = 12


@dataclass(frozen=True, slots=True)
class GoalPursuit:
    """Constants of the steps that follow goals through time.

    Attributes:
        stiffness: λ as a fraction of the error, λ² = |e|²/2 (Sugihara 2011): it calms joints of
            limbs out of reach, and vanishes where the goal is reached.
        damping: least λ, which bounds a joint's speed near full extension.
        max_move: greatest movement of a joint in one step [rad or m].
        tolerance: accepted error of the first goals, in lengths of the limb and radians.
        stall_fraction: fraction of the error that a step must remove to be worth another one.
    """

    stiffness: float = 0.7
    damping: float = 1e-3
    max_move: float = 0.25
    tolerance: float = 1e-5
    stall_fraction: float = 1e-3


TIP_ITERATION, NEWTON_SEARCH, GOAL_PURSUIT = TipIteration(), NewtonSearch(), GoalPursuit()


@dataclass(frozen=True, eq=False)
class IKSolution:
    """The result of the iterations.

    Attributes:
        batch: the limbs.
        pose: their pose, within the limits.
        residual: (L,) distance of tip from goal [m].
        iterations: number of iterations.
        turn: (L,) angle of tip from goal [rad]; None without an orientation goal.
    """

    batch: LimbBatch
    pose: LimbPose
    residual: Array
    iterations: int
    turn: Array | None = None

    @property
    def at_limit(self) -> NDArray[np.bool_]:
        """(L, n) joints that are at one of their limits."""
        q, batch = self.pose.q, self.batch
        result: NDArray[np.bool_] = (q <= batch.lower) | (q >= batch.upper)
        return result & batch.is_joint


def damped_step(batch: LimbBatch, pose: LimbPose, dx: Array, gain: Array, damping: Array) -> Array:
    """Return the joint values (L, n) after one step of the tips, within the limits.

    Joints that the step would push through a limit are held there and the others carry the motion,
    by a second pass with their columns removed.

    Args:
        batch: the limbs.
        pose: their pose.
        dx: (L, 3) the step [m].
        gain: (L,) α, the fraction of the way to the preferred values that redundancy goes.
        damping: (L, x, x) λ² I for steps of x components.
    """
    q, jacobian = pose.q, pose.jacobian
    z = gain[:, None] * (batch.preferred - q)
    wanted = q + _pseudo_inverse_step(jacobian, dx, z, damping)
    bounded = np.minimum(np.maximum(wanted, batch.lower), batch.upper)
    held = bounded != wanted
    if not held.any():
        return wanted
    free = ~held
    moved = np.where(held, bounded - q, 0.0)
    rest = dx - _apply_jacobian(jacobian, moved)
    again = _pseudo_inverse_step(jacobian * free[..., None], rest, z * free, damping)
    again = q + np.where(held, moved, again)
    return np.minimum(np.maximum(again, batch.lower), batch.upper)


def _pseudo_inverse_step(jacobian: Array, dx: Array, z: Array, damping: Array) -> Array:
    """Return J⁺ dx + (I - J⁺ J) z with the damped J⁺ = Jᵀ (J Jᵀ + λ² I)⁻¹, for given λ² I.

    Written as z + J⁺ (dx - J z), which needs no projector.

    Source: Sims 1987, eq. B.4 and B.7, with z = preferred - q (B.2 has the opposite sign); damping
    after Wampler 1986.
    """
    square = np.add.reduce(jacobian[..., None] * jacobian[..., None, :], axis=1)
    square += damping
    y = np.linalg.solve(square, (dx - _apply_jacobian(jacobian, z))[..., None])[..., 0]
    return z + (jacobian @ y[..., None])[..., 0]


def _apply_jacobian(jacobian: Array, q: Array) -> Array:
    """Return J q (L, 3) for Jᵀ (L, n, 3) and q (L, n).

    Summed joint by joint, unlike a BLAS, so that padding does not affect the last bit.
    """
    return np.add.reduce(jacobian * q[..., None], axis=1)


def _norm(v: Array) -> Array:
    return np.sqrt(np.einsum("li,li->l", v, v))


def closest_pose(
    batch: LimbBatch, pose: LimbPose, aim: TipPlacement, max_iterations: int = 40
) -> LimbPose:
    """Return limbs at a pose from which no small movement brings them nearer to `aim`."""
    for _ in range(max_iterations):
        task = aim.task(batch, pose)
        down = (task.velocity[:, None] @ task.jacobian)[:, 0]
        stopped = (pose.q <= batch.lower) & (down < 0.0) | (pose.q >= batch.upper) & (down > 0.0)
        free = batch.is_joint & ~stopped
        down = down * free
        if (np.abs(down).max(axis=1, initial=0.0) < NEWTON_SEARCH.flat_slope).all():
            break
        step = _newton_step(batch, pose, aim, down, free)
        after = _downhill(batch, pose, aim, step)
        if after is None:
            break
        pose = after
    return pose


def _newton_step(
    batch: LimbBatch, pose: LimbPose, aim: TipPlacement, down: Array, free: NDArray[np.bool_]
) -> Array:
    """Return the step (L, n) to the minimum of a convex model, moving `free` joints alone."""
    task = aim.task(batch, pose)
    size = batch.lengths[:, None, None]
    curved = np.einsum("lijx,lx->lij", hessian(batch, pose)[..., :3], task.velocity[:, :3]) / size
    # The change of the axes with orientation is left out: the model only has to lead down.
    H = task.jacobian.transpose(0, 2, 1) @ task.jacobian - 0.5 * (
        curved + curved.transpose(0, 2, 1)
    )
    both = free[:, :, None] & free[:, None, :]
    H = np.where(both, H, 0.0) + (~free)[:, :, None] * np.eye(free.shape[1])
    w, V = np.linalg.eigh(H)
    curvature = np.maximum(np.abs(w), NEWTON_SEARCH.min_curvature)
    model = (V.transpose(0, 2, 1) @ down[..., None])[..., 0] / curvature
    step: Array = (V @ model[..., None])[..., 0] * free
    largest = np.abs(step).max(axis=1, keepdims=True, initial=0.0)
    step *= NEWTON_SEARCH.max_move / np.maximum(largest, NEWTON_SEARCH.max_move)
    return step


def _downhill(batch: LimbBatch, pose: LimbPose, aim: TipPlacement, step: Array) -> LimbPose | None:
    """Return limbs one step on, halved until it leads nearer; None if no limb gets nearer."""
    before = np.linalg.norm(aim.task(batch, pose).velocity, axis=-1)
    moved = np.zeros(len(before), dtype=bool)
    result = pose
    for _ in range(NEWTON_SEARCH.halvings):
        q = np.clip(pose.q + step, batch.lower, batch.upper)
        candidate = batch.pose(q)
        nearer = np.linalg.norm(aim.task(batch, candidate).velocity, axis=-1) < before
        result = candidate.where(nearer & ~moved, result)
        moved |= nearer
        if moved.all():
            break
        step = 0.5 * step
    return result if moved.any() else None
