"""Kinematics: joint values -> poses of links; Jacobians of limbs. Batched over creatures.

A joint's frame is its parent's, moved to its place and turned about its axis by its
value. At value zero all frames are parallel to the creation frame, so a joint's place
relative to its parent is the difference of their places there.

Source: Sims 1987, 5.4.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.skeleton import BODY, Limb, Skeleton
from pipeline.simulation.spatial import Array, cross, cross_matrix, turn

ONE = np.eye(3)


@dataclass(frozen=True, eq=False)
class Hinges:
    """Joints with constant axes and offsets, prepared so that a value costs two sines.

    The frame of a joint in its parent's is a translation by its offset, then a rotation
    R = 1 + sin θ K + (1 - cos θ) K², K being the cross-product matrix of the axis: linear
    in sin θ and cos θ. It stands for the stored Q of Sims 1987, A.3.

    Attributes:
        axes: (..., n, 3) unit axes in the creation frame; zero for joints that do not turn.
        offsets: (..., n, 3) from the joint before [m].
    """

    axes: Array
    offsets: Array

    @cached_property
    def _terms(self) -> tuple[Array, Array, Array]:
        """Constant term, and those of sine and cosine, (..., n, 4, 4) each."""
        constant, sine, cosine = np.zeros((3, *self.axes.shape[:-1], 4, 4))
        K = cross_matrix(self.axes)
        constant[..., :3, :3] = ONE + K @ K
        constant[..., :3, 3] = self.offsets
        constant[..., 3, 3] = 1.0
        sine[..., :3, :3] = K
        cosine[..., :3, :3] = -K @ K
        return constant, sine, cosine

    def __call__(self, values: Array) -> Array:
        """Return the frames (..., n, 4, 4) in those before, for joint values (..., n) [rad]."""
        constant, sine, cosine = self._terms
        result: Array = np.sin(values)[..., None, None] * sine
        result += np.cos(values)[..., None, None] * cosine
        result += constant
        return result


@dataclass(frozen=True, eq=False)
class Tree:
    """Joints that hang on one another, of one figure or of many, as arrays.

    Attributes:
        parents: (J,) number of the joint before each, `BODY` for joints on a body.
        axes: (J, 3) unit axes in the creation frame.
        places: (J, 3) positions in the creation frame [m].
    """

    parents: NDArray[np.int64]
    axes: Array
    places: Array

    @cached_property
    def _depth(self) -> NDArray[np.int64]:
        depth = np.zeros(len(self.parents), dtype=np.int64)
        for j, parent in enumerate(self.parents):
            depth[j] = 0 if parent == BODY else depth[parent] + 1
        return depth

    @cached_property
    def _order(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Joints by distance from the body, and the place of each in that order."""
        order = np.argsort(self._depth, kind="stable")
        return order, np.argsort(order)

    @cached_property
    def _hinges(self) -> Hinges:
        """The joints by distance from the body, each in the frame of its parent."""
        origins = np.where((self.parents == BODY)[:, None], 0.0, self.places[self.parents])
        order, _ = self._order
        return Hinges(self.axes[order], (self.places - origins)[order])

    @cached_property
    def _levels(self) -> list[tuple[slice, NDArray[np.int64]]]:
        """In that order: joints that are equally far from the body, and their parents."""
        order, place = self._order
        counts = np.bincount(self._depth, minlength=1)
        ends = np.cumsum(counts)
        levels = [slice(a, b) for a, b in itertools.pairwise(ends)]
        return [(level, place[self.parents[order[level]]]) for level in levels]

    def pose(self, q: Array) -> Array:
        """Return the frames X_BJ (..., J, 4, 4) of all joints relative to the body.

        Args:
            q: (..., J) joint values [rad].
        """
        order, place = self._order
        X = self._hinges(q[..., order])
        for level, above in self._levels:
            X[..., level, :, :] = X[..., above, :, :] @ X[..., level, :, :]
        result: Array = X[..., place, :, :]
        return result


@dataclass(frozen=True, eq=False)
class LimbPose:
    """Limbs at certain joint values, and all that follows from them.

    Attributes:
        q: (L, n) joint values [rad].
        X_BJ: (L, n, 4, 4) frames of the joints relative to the body.
        tips: (L, 3) p_BF [m].
        jacobian: (L, n, 3) Jᵀ, how the tips move with each joint [m/rad].
    """

    q: Array
    X_BJ: Array
    tips: Array
    jacobian: Array

    def where(self, chosen: NDArray[np.bool_], other: LimbPose) -> LimbPose:
        """Return this pose for the limbs `chosen` (L,), and `other` for the rest."""
        if chosen.all():
            return self
        one, two = chosen[:, None], chosen[:, None, None]
        return LimbPose(
            np.where(one, self.q, other.q),
            np.where(two[..., None], self.X_BJ, other.X_BJ),
            np.where(one, self.tips, other.tips),
            np.where(two, self.jacobian, other.jacobian),
        )


@dataclass(frozen=True, eq=False)
class LimbBatch:
    """Limbs of equal or unequal length as arrays (L, n, ...), the shorter ones padded.

    A padding joint stands at the tip with axis zero: it moves nothing, and its column
    of the Jacobian is zero.

    Attributes:
        places: (L, n, 3) joints in the creation frame, relative to the body [m].
        axes: (L, n, 3).
        tips: (L, 3) in the creation frame [m].
        lower, upper, preferred: (L, n) [rad].
        lengths: (L,) of the stretched limbs [m].
        is_joint: (L, n) false for padding.
    """

    places: Array
    axes: Array
    tips: Array
    lower: Array
    upper: Array
    preferred: Array
    lengths: Array
    is_joint: NDArray[np.bool_]

    @staticmethod
    def of(limbs: list[tuple[Skeleton, Limb]]) -> LimbBatch:
        """Collect limbs, of several skeletons if need be, whose bases are on the body."""
        shape = len(limbs), max((len(limb.joints) for _, limb in limbs), default=1)
        places = np.empty((*shape, 3))
        axes = np.zeros((*shape, 3))
        lower, upper, preferred = np.zeros((3, *shape))
        is_joint = np.zeros(shape, dtype=bool)
        for row, (skeleton, limb) in enumerate(limbs):
            joints, here = list(limb.joints), (row, slice(len(limb.joints)))
            places[row] = limb.tip
            places[here], axes[here] = skeleton.places[joints], skeleton.axes[joints]
            lower[here], upper[here] = skeleton.lower[joints], skeleton.upper[joints]
            preferred[here] = skeleton.preferred[joints]
            is_joint[here] = True
        return LimbBatch(
            places,
            axes,
            tips=np.array([limb.tip for _, limb in limbs]).reshape(-1, 3),
            lower=lower,
            upper=upper,
            preferred=preferred,
            lengths=np.array([limb.length for _, limb in limbs]),
            is_joint=is_joint,
        )

    @cached_property
    def _hinges(self) -> Hinges:
        origins = np.concatenate([np.zeros_like(self.places[:, :1]), self.places[:, :-1]], axis=1)
        return Hinges(self.axes, self.places - origins)

    def pose(self, q: Array) -> LimbPose:
        """Return frames, tips and Jacobians at joint values `q` (L, n) [rad].

        The column of a joint is a × (p_tip - p): the thesis's a × p is about the base's
        origin and holds only for a tip there.

        Source: Sims 1987, 5.4, eq. 5.2.
        """
        X = self._hinges(q)
        for j in range(1, q.shape[1]):
            X[:, j] = X[:, j - 1] @ X[:, j]
        R, places = X[..., :3, :3], X[..., :3, 3]
        # An axis is not moved by its own turn, so the frame after it will do.
        axes = turn(R, self.axes)
        tips = places[:, -1] + turn(R[:, -1], self.tips - self.places[:, -1])
        return LimbPose(q, X, tips, cross(axes, tips[:, None] - places))
