"""Jacobians: how tips move and turn with the joint values, and how that itself changes.

The rows are the velocity, then the angular velocity of the tip. The thesis writes the
last three as derivatives of three angles (ρ, φ, ψ); the axes that it puts there give the
angular velocity, which no three angles have as their derivative. An orientation error
that goes with them is a rotation vector.

Jacobians are kept transposed, joint after joint: Jᵀ (..., n, 3) or (..., n, 6).

Source: Sims 1987, 5.4, eq. 5.1 and 5.2.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose, Tree
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.spatial import Array, cross, turn


def turning(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return the axes (L, n, 3) that the tips turn about; zero for joints that slide."""
    axes = turn(pose.X_BJ[..., :3, :3], batch.axes)
    return np.where(batch.prismatic[..., None], 0.0, axes)


def jacobian(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return Jᵀ (L, n, 6), position and orientation of the tips [m/rad, 1 and 1/m].

    Source: Sims 1987, eq. 5.1.
    """
    return np.concatenate([pose.jacobian, turning(batch, pose)], axis=-1)


def hessian(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return H (L, n, n, 6), how the column of joint j (second) changes with joint i (first).

    What lies beyond the nearer of two joints is turned with it, so the column of the
    farther one turns, and the nearer one's lever is moved by the farther one: in both cases
    the change of position is ω_near × J_far. Only the nearer joint changes an axis.
    """
    ω, J = turning(batch, pose), pose.jacobian
    n = J.shape[1]
    near = np.minimum.outer(np.arange(n), np.arange(n))
    far = np.maximum.outer(np.arange(n), np.arange(n))
    H = np.zeros((len(J), n, n, 6))
    H[..., :3] = cross(ω[:, near], J[:, far])
    i, j = np.triu_indices(n, 1)
    H[:, i, j, 3:] = cross(ω[:, i], ω[:, j])
    return H


def tree_jacobian(tree: Tree, q: Array, joint: int, place: Array) -> Array:
    """Return Jᵀ (..., J, 6) of a point of the link that `joint` moves, relative to the body.

    Args:
        tree: the joints.
        q: (..., J) joint values [rad or m].
        joint: number; `BODY` gives zeros.
        place: (3,) the point in the creation frame [m].
    """
    J = np.zeros((*q.shape, 6))
    if joint == BODY:
        return J
    X = tree.pose(q)
    R, p = X[..., :3, :3], X[..., :3, 3]
    tip = p[..., joint, :] + turn(R[..., joint, :, :], place - tree.places[joint])
    axes = turn(R, tree.axes)
    while joint != BODY:
        if tree.prismatic[joint]:
            J[..., joint, :3] = axes[..., joint, :]
        else:
            J[..., joint, :3] = cross(axes[..., joint, :], tip - p[..., joint, :])
            J[..., joint, 3:] = axes[..., joint, :]
        joint = int(tree.parents[joint])
    return J
