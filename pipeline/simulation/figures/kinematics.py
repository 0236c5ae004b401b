"""Forward kinematics and Jacobians, batched over creatures.

A joint's frame is its parent's, moved to its place and turned about its axis by its value, or slid
along it. At value zero all frames are parallel to the creation frame, so a joint's place relative
to its parent is the difference of their places there.

Jacobians are stored transposed, joint by joint: Jᵀ (..., n, 3) or (..., n, 6). Their rows are the
velocity, then the angular velocity of the tip. The thesis writes the last three as derivatives of
three angles (ρ, φ, ψ); its axes give the angular velocity, which is not the derivative of any
three angles. The matching orientation error is a rotation vector.

Source: Sims 1987, 5.4, eq. 5.1 and 5.2.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.skeleton import BODY, Limb, Skeleton
from pipeline.simulation.spatial import Array, cross, cross_matrix, turn

IDENTITY = np.eye(3)

MIN_REACH = 0.3
"""Reach below which limits hold a limb folded, in the length of its links."""

LimbRows = NDArray[np.bool_] | NDArray[np.int64]
"""Limbs of a batch: a mask (L,) or their numbers."""


@dataclass(frozen=True, eq=False)
class JointTransforms:
    """Joints with constant axes and offsets, prepared so that a value costs two sines.

    The frame of a joint in its parent's is a translation by its offset, then a rotation R = 1 +
    sin θ K + (1 - cos θ) K², where K is the cross-product matrix of the axis: linear in sin θ and
    cos θ. It replaces the stored Q of Sims 1987, A.3. A prismatic joint translates along its axis,
    which is linear in its value.

    Attributes:
        axes: (..., n, 3) unit axes in the creation frame; zero for fixed joints.
        offsets: (..., n, 3) from the joint before [m].
        prismatic: (..., n) whether they slide.
    """

    axes: Array
    offsets: Array
    prismatic: NDArray[np.bool_]

    @cached_property
    def _terms(self) -> tuple[Array, Array, Array]:
        """Constant, sine and cosine terms, (..., n, 4, 4) each."""
        constant, sine, cosine = np.zeros((3, *self.axes.shape[:-1], 4, 4))
        K = cross_matrix(np.where(self.prismatic[..., None], 0.0, self.axes))
        constant[..., :3, :3] = IDENTITY + K @ K
        constant[..., :3, 3] = self.offsets
        constant[..., 3, 3] = 1.0
        sine[..., :3, :3] = K
        cosine[..., :3, :3] = -K @ K
        return constant, sine, cosine

    @cached_property
    def _slides(self) -> Array | None:
        """Axes (..., n, 3) of prismatic joints, zero for others; None without any."""
        return self.axes * self.prismatic[..., None] if self.prismatic.any() else None

    def __call__(self, values: Array) -> Array:
        """Return the frames (..., n, 4, 4) in their parents', for values (..., n) [rad or m]."""
        constant, sine, cosine = self._terms
        result: Array = np.sin(values)[..., None, None] * sine
        result += np.cos(values)[..., None, None] * cosine
        result += constant
        if self._slides is not None:
            result[..., :3, 3] += values[..., None] * self._slides
        return result


@dataclass(frozen=True, eq=False)
class JointTree:
    """A tree of joints, of one figure or many, as arrays.

    Attributes:
        parents: (J,) joint before each; `BODY` for joints on a body.
        axes: (J, 3) unit axes in the creation frame.
        places: (J, 3) positions in the creation frame [m].
        prismatic: (J,) whether they slide along their axes instead of turning about them.
    """

    parents: NDArray[np.int64]
    axes: Array
    places: Array
    prismatic: NDArray[np.bool_]

    @staticmethod
    def of(skeleton: Skeleton) -> JointTree:
        """Return the tree of a skeleton."""
        return JointTree(skeleton.parents, skeleton.axes, skeleton.places, skeleton.prismatic)

    @cached_property
    def _depth(self) -> NDArray[np.int64]:
        depth = np.zeros(len(self.parents), dtype=np.int64)
        above = self.parents
        # Level by level: after a change of base a parent may have the higher number.
        while (inner := above != BODY).any():
            depth += inner
            above = np.where(inner, self.parents[above], BODY)
        return depth

    @cached_property
    def _order(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Joints by depth, and the place of each in that order."""
        order = np.argsort(self._depth, kind="stable")
        return order, np.argsort(order)

    @cached_property
    def outward(self) -> tuple[int, ...]:
        """The joints, each after its parent."""
        return tuple(self._order[0].tolist())

    @cached_property
    def _hinges(self) -> JointTransforms:
        """The joints by depth, each in the frame of its parent."""
        origins = np.where((self.parents == BODY)[:, None], 0.0, self.places[self.parents])
        order, _ = self._order
        return JointTransforms(
            self.axes[order], (self.places - origins)[order], self.prismatic[order]
        )

    @cached_property
    def _levels(self) -> list[tuple[slice, NDArray[np.int64]]]:
        """Joints of each depth, in that order, with their parents."""
        order, place = self._order
        counts = np.bincount(self._depth, minlength=1)
        ends = np.cumsum(counts)
        levels = [slice(a, b) for a, b in itertools.pairwise(ends)]
        return [(level, place[self.parents[order[level]]]) for level in levels]

    def pose(self, q: Array) -> Array:
        """Return the frames X_BJ (..., J, 4, 4) of all joints relative to the body.

        Args:
            q: (..., J) joint values [rad or m].
        """
        order, place = self._order
        X = self._hinges(q[..., order])
        for level, above in self._levels:
            X[..., level, :, :] = X[..., above, :, :] @ X[..., level, :, :]
        return X[..., place, :, :]


@dataclass(frozen=True, eq=False)
class LimbPose:
    """Limbs at given joint values.

    Attributes:
        q: (L, n) joint values [rad or m].
        X_BJ: (L, n, 4, 4) frames of the joints relative to the body.
        tips: (L, 3) p_BF [m].
        jacobian: (L, n, 3) Jᵀ of the tips [m/rad or 1].
    """

    q: Array
    X_BJ: Array
    tips: Array
    jacobian: Array

    @property
    def R_BF(self) -> Array:
        """(L, 3, 3) orientations of the tips; the identity at joint values zero."""
        return self.X_BJ[:, -1, :3, :3]

    def rows(self, chosen: LimbRows) -> LimbPose:
        """Return the limbs `chosen` alone."""
        return LimbPose(self.q[chosen], self.X_BJ[chosen], self.tips[chosen], self.jacobian[chosen])

    def where(self, chosen: NDArray[np.bool_], other: LimbPose) -> LimbPose:
        """Return this pose for the limbs `chosen` (L,), and `other` for the rest."""
        if chosen.all():
            return self
        by_limb, by_joint = chosen[:, None], chosen[:, None, None]
        return LimbPose(
            np.where(by_limb, self.q, other.q),
            np.where(by_joint[..., None], self.X_BJ, other.X_BJ),
            np.where(by_limb, self.tips, other.tips),
            np.where(by_joint, self.jacobian, other.jacobian),
        )


@dataclass(frozen=True, eq=False)
class LimbBatch:
    """Limbs of equal or unequal length as arrays (L, n, ...), the shorter ones padded.

    A padding joint is at the tip with axis zero: it moves nothing, and its Jacobian column is
    zero.

    Attributes:
        places: (L, n, 3) joints in the creation frame, relative to the body [m].
        axes: (L, n, 3).
        prismatic: (L, n) whether they slide.
        tips: (L, 3) in the creation frame [m].
        lower, upper, preferred, extended: (L, n) [rad or m].
        lengths: (L,) of the stretched limbs, from base to tip [m].
        is_joint: (L, n) False for padding.
    """

    places: Array
    axes: Array
    prismatic: NDArray[np.bool_]
    tips: Array
    lower: Array
    upper: Array
    preferred: Array
    extended: Array
    lengths: Array
    is_joint: NDArray[np.bool_]

    @staticmethod
    def of(limbs: list[tuple[Skeleton, Limb]]) -> LimbBatch:
        """Return limbs of any skeletons, each relative to its base link.

        The base link of a figure's own limbs is the body; `limb_between` gives others.
        """
        shape = len(limbs), max((len(limb.joints) for _, limb in limbs), default=1)
        places = np.empty((*shape, 3))
        axes = np.zeros((*shape, 3))
        lower, upper, preferred, extended = np.zeros((4, *shape))
        is_joint, prismatic = np.zeros((2, *shape), dtype=bool)
        for row, (skeleton, limb) in enumerate(limbs):
            joints, here = list(limb.joints), (row, slice(len(limb.joints)))
            places[row] = limb.tip
            places[here], axes[here] = skeleton.places[joints], skeleton.axes[joints]
            lower[here], upper[here] = skeleton.lower[joints], skeleton.upper[joints]
            preferred[here], extended[here] = skeleton.preferred[joints], skeleton.extended[joints]
            prismatic[here] = skeleton.prismatic[joints]
            is_joint[here] = True
        batch = LimbBatch(
            places,
            axes,
            prismatic,
            tips=np.array([limb.tip for _, limb in limbs]).reshape(-1, 3),
            lower=lower,
            upper=upper,
            preferred=preferred,
            extended=extended,
            lengths=np.array([limb.length for _, limb in limbs]),
            is_joint=is_joint,
        )
        return replace(batch, lengths=batch._stretched_lengths()) if limbs else batch

    def _stretched_lengths(self) -> Array:
        """Return the greatest distances (L,) from base to tip [m].

        Crooked links whose joints cannot align them are shorter together than one by one. Limbs
        that slide have the length that is drawn.
        """
        longest = np.minimum(self._reach(), self.lengths)
        slides = self.prismatic.any(axis=1) | (longest < MIN_REACH * self.lengths)
        return np.where(slides, self.lengths, longest)

    def _reach(self) -> Array:
        """Return the distances (L,) from base to tip of limbs as far out as they go [m]."""
        poses = (np.clip(self.extended, self.lower, self.upper), self.preferred)
        reach = [np.linalg.norm(self.pose(q).tips - self.places[:, 0], axis=-1) for q in poses]
        return np.maximum(*reach)

    def slid_out(self) -> LimbBatch:
        """Return limbs whose lengths are those that they have with all joints slid out."""
        slides = self.prismatic.any(axis=1)
        if not slides.any():
            return self
        most = self.lengths + np.where(self.prismatic, self.upper, 0.0).sum(axis=1)
        reach = np.minimum(self._reach(), most)
        own = slides & (reach >= MIN_REACH * self.lengths)
        return replace(self, lengths=np.where(own, reach, self.lengths))

    def rows(self, chosen: LimbRows) -> LimbBatch:
        """Return the limbs `chosen` alone."""
        return LimbBatch(**{f.name: getattr(self, f.name)[chosen] for f in fields(self)})

    def first_joints(self, count: int) -> LimbBatch:
        """Return the limbs without the padding after `count` joints."""
        whole = "tips", "lengths"
        arrays = {f.name: getattr(self, f.name) for f in fields(self)}
        return LimbBatch(**{k: v if k in whole else v[:, :count] for k, v in arrays.items()})

    @cached_property
    def _hinges(self) -> JointTransforms:
        origins = np.concatenate([np.zeros_like(self.places[:, :1]), self.places[:, :-1]], axis=1)
        return JointTransforms(self.axes, self.places - origins, self.prismatic)

    @cached_property
    def _slide(self) -> bool:
        return bool(self.prismatic.any())

    def pose(self, q: Array) -> LimbPose:
        """Return frames, tips and Jacobians at joint values `q` (L, n) [rad or m].

        The column of a joint is a × (p_tip - p), or a where it slides: the thesis's a × p is about
        the base's origin and holds only for a tip there.

        Source: Sims 1987, 5.4, eq. 5.2.
        """
        X = self._hinges(q)
        for j in range(1, q.shape[1]):
            X[:, j] = X[:, j - 1] @ X[:, j]
        R, places = X[..., :3, :3], X[..., :3, 3]
        # A joint's rotation leaves its own axis unchanged, so the frame after it serves.
        axes = turn(R, self.axes)
        tips = places[:, -1] + turn(R[:, -1], self.tips - self.places[:, -1])
        jacobian = cross(axes, tips[:, None] - places)
        if self._slide:
            jacobian = np.where(self.prismatic[..., None], axes, jacobian)
        return LimbPose(q, X, tips, jacobian)


def rotation_axes(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return the axes (L, n, 3) that the tips turn about; zero for prismatic joints."""
    axes = turn(pose.X_BJ[..., :3, :3], batch.axes)
    return np.where(batch.prismatic[..., None], 0.0, axes)


def jacobian(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return Jᵀ (L, n, 6) of position and orientation of the tips [m/rad, 1 and 1/m].

    Source: Sims 1987, eq. 5.1.
    """
    return np.concatenate([pose.jacobian, rotation_axes(batch, pose)], axis=-1)


def hessian(batch: LimbBatch, pose: LimbPose) -> Array:
    """Return H (L, n, n, 6), the change of the column of joint j (second) with joint i (first).

    The nearer of two joints turns all beyond it, hence the farther one's column; the farther one
    moves the nearer one's lever. In both cases the change of position is ω_near × J_far. Only the
    nearer joint changes an axis.
    """
    ω, J = rotation_axes(batch, pose), pose.jacobian
    n = J.shape[1]
    near = np.minimum.outer(np.arange(n), np.arange(n))
    far = np.maximum.outer(np.arange(n), np.arange(n))
    H = np.zeros((len(J), n, n, 6))
    H[..., :3] = cross(ω[:, near], J[:, far])
    i, j = np.triu_indices(n, 1)
    H[:, i, j, 3:] = cross(ω[:, i], ω[:, j])
    return H


def tree_jacobian(tree: JointTree, q: Array, joint: int, place: Array) -> Array:
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
