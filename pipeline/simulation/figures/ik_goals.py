"""Goals of inverse kinematics, each expressed as a task at the current pose.

Any of them can be the first, and any can follow at lower priority. An orientation error is a
rotation vector, the axis times the remaining angle; differences of Euler angles are no velocity
and depend on their convention.

Goals may also concern an inner node of a limb: joints beyond the node do not move it, so their
columns are zero and they are left to the goals that follow. "The elbow on the table, the hand at
the chin" are two such goals.

Dexterity is the ability to move the tip in all directions. The thesis measures the distance from a
singularity by the determinant of the Jacobian, which only a square one has: for a redundant limb
√det(J Jᵀ), the product of its singular values, is the same measure. Lengths count in the limb's,
so it has no unit.

Source: Sims 1987, 6.2, 6.3, B.2 and B.3; Yoshikawa 1985.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pipeline.simulation.figures.kinematics import (
    LimbBatch,
    LimbPose,
    LimbRows,
    hessian,
    rotation_axes,
)
from pipeline.simulation.figures.task_priority import Task
from pipeline.simulation.spatial import Array, cross, quaternion, turn


class Goal(Protocol):
    """A demand on limbs."""

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Return the demand at `pose`."""
        ...


@dataclass(frozen=True, eq=False)
class TipPlacement:
    """Tips at given places, and in given orientations if there are any.

    Attributes:
        places: (L, 3) relative to the base [m].
        orientations: (L, 3, 3) R_BF, the identity being that of joint values zero.
    """

    places: Array
    orientations: Array | None = None

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Demand the whole error; an angle of one radian counts as one length of the limb."""
        size = batch.lengths[:, None]
        J = pose.jacobian / size[..., None]
        error = (self.places - pose.tips) / size
        if self.orientations is not None:
            J = np.concatenate([J, rotation_axes(batch, pose)], axis=-1)
            left = rotation_vector(self.orientations @ pose.R_BF.transpose(0, 2, 1))
            error = np.concatenate([error, left], axis=-1)
        return Task(J.transpose(0, 2, 1), error)

    def rows(self, chosen: LimbRows) -> TipPlacement:
        """Return the goals of some limbs alone."""
        turned = None if self.orientations is None else self.orientations[chosen]
        return TipPlacement(self.places[chosen], turned)


def rotation_vector(R: Array) -> Array:
    """Return axis times angle (..., 3) [rad] of rotations (..., 3, 3), at most half a turn."""
    q = quaternion(R)
    q = np.where(q[..., :1] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    # Near the identity the angle is twice the sine, to the last digit.
    factor = np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)
    return factor * q[..., 1:]


def singular_values(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return singular values of the translational Jacobian (L, min(3, n)), in descending order."""
    J = pose.jacobian / batch.lengths[:, None, None]
    # For doubles this is numpy's type, which its stubs leave open.
    return np.asarray(np.linalg.svd(J, compute_uv=False), dtype=np.float64)


def dexterity(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return w = √det(J Jᵀ) (L,); for n < 3 joints the volume over the directions it has."""
    return np.prod(singular_values(batch, pose), axis=-1)


def dexterity_gradient(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return ∂w/∂θ (L, n), padding zero.

    ∂w/∂θ_k = w tr(J⁺ ∂J/∂θ_k): with singular values, Σ_i (∏_{j≠i} σ_j) u_iᵀ ∂J/∂θ_k v_i,
    which stays finite where one of them is zero.
    """
    scale = batch.lengths[:, None, None]
    U, σ, Vt = np.linalg.svd((pose.jacobian / scale).transpose(0, 2, 1), full_matrices=False)
    others = np.stack(
        [np.prod(np.delete(σ, i, axis=-1), axis=-1) for i in range(σ.shape[-1])], axis=-1
    )
    change = hessian(batch, pose)[..., :3] / scale[..., None]
    G = (U * others[:, None, :]) @ Vt
    return np.einsum("lxj,lkjx->lk", G, change)


@dataclass(frozen=True, eq=False)
class LimbPoint:
    """A node of a limb, on the link that ends there.

    Attributes:
        column: number, within the limb, of the joint that moves that link.
        place: (3,) of the node in the creation frame [m].
        along: (3,) unit direction of the link in the creation frame.
    """

    column: int
    place: Array
    along: Array

    def at(self, batch: LimbBatch, pose: LimbPose) -> Array:
        """Return its place (L, 3), relative to the limb's base [m]."""
        X = pose.X_BJ[:, self.column]
        return X[:, :3, 3] + turn(X[:, :3, :3], self.place - batch.places[:, self.column])

    def orientation(self, pose: LimbPose) -> Array:
        """Return the rotation (L, 3, 3) of its link."""
        return pose.X_BJ[:, self.column, :3, :3]

    def place_jacobian(self, batch: LimbBatch, pose: LimbPose) -> Array:
        """Return Jᵀ (L, n, 3) of its place [m/rad or 1]."""
        axes = turn(pose.X_BJ[..., :3, :3], batch.axes)
        J = cross(axes, self.at(batch, pose)[:, None] - pose.X_BJ[..., :3, 3])
        J = np.where(batch.prismatic[..., None], axes, J)
        J[:, self.column + 1 :] = 0.0
        return J

    def orientation_jacobian(self, batch: LimbBatch, pose: LimbPose) -> Array:
        """Return Jᵀ (L, n, 3) of its link's orientation [1]."""
        J = rotation_axes(batch, pose)
        J[:, self.column + 1 :] = 0.0
        return J


@dataclass(frozen=True, eq=False)
class PointPlacement:
    """A node at a place.

    Attributes:
        point: the node.
        place: (L, 3) relative to the limb's base [m].
    """

    point: LimbPoint
    place: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Demand the whole error, in lengths of the limb."""
        size = batch.lengths[:, None]
        J = self.point.place_jacobian(batch, pose) / size[..., None]
        error = (self.place - self.point.at(batch, pose)) / size
        return Task(J.transpose(0, 2, 1), error)


@dataclass(frozen=True, eq=False)
class PointOrientation:
    """The link that ends at a node in a given orientation.

    Attributes:
        point: the node.
        orientation: (L, 3, 3), the identity being as drawn.
    """

    point: LimbPoint
    orientation: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Demand the whole rotation [rad]."""
        left = rotation_vector(self.orientation @ self.point.orientation(pose).transpose(0, 2, 1))
        return Task(self.point.orientation_jacobian(batch, pose).transpose(0, 2, 1), left)


@dataclass(frozen=True, eq=False)
class PointDirection:
    """The link that ends at a node pointing in a direction, free to roll about it.

    Attributes:
        point: the node.
        direction: (L, 3) unit vectors.
    """

    point: LimbPoint
    direction: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Demand the shortest rotation [rad]."""
        now = turn(self.point.orientation(pose), self.point.along)
        axis = cross(now, self.direction)
        sine = np.linalg.norm(axis, axis=-1, keepdims=True)
        cosine = np.sum(now * self.direction, axis=-1, keepdims=True)
        # Half a turn away, any perpendicular axis serves.
        behind = cross(now, np.where(np.abs(now[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 0, 1.0]]))
        axis = np.where((sine < 1e-9) & (cosine < 0.0), behind, axis)
        length = np.linalg.norm(axis, axis=-1, keepdims=True)
        error = np.arctan2(sine, cosine) * axis / np.where(length > 0.0, length, 1.0)
        J = self.point.orientation_jacobian(batch, pose).transpose(0, 2, 1)
        across = np.eye(3) - now[:, :, None] * now[:, None, :]
        return Task(across @ J, error)


@dataclass(frozen=True, eq=False)
class JointTargets:
    """Some joints at given values.

    Attributes:
        columns: (n,) 1 for these joints, 0 for the others.
        values: (L, n) [rad or m].
    """

    columns: Array
    values: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Demand the whole error."""
        del batch
        rows = np.broadcast_to(np.diag(self.columns), (len(pose.q), *np.diag(self.columns).shape))
        return Task(rows, self.columns * (self.values - pose.q))
