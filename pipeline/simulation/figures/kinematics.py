"""Kinematics: joint values -> poses of links; Jacobians of limbs. Batched over creatures.

A joint's frame is its parent's, moved to its place and turned about its axis by its
value. At value zero all frames are parallel to the creation frame, so a joint's place
relative to its parent is the difference of their places there.

Source: Sims 1987, 5.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.skeleton import BODY, Limb, Skeleton
from pipeline.simulation.spatial import Array, cross, cross_matrix, turn

ONE = np.eye(3)


@dataclass(frozen=True, eq=False)
class Turns:
    """Rotations about constant axes, prepared so that a value costs two sines.

    R = 1 + sin θ K + (1 - cos θ) K², K being the cross-product matrix of the axis.
    It stands for the stored Q of Sims 1987, A.3.
    """

    axes: Array

    @cached_property
    def _k(self) -> tuple[Array, Array]:
        K = cross_matrix(self.axes)
        return K, K @ K

    def __call__(self, values: Array) -> Array:
        """Return the rotations (..., n, 3, 3) for joint values (..., n) [rad]."""
        k, kk = self._k
        s, c = np.sin(values)[..., None, None], np.cos(values)[..., None, None]
        result: Array = ONE + s * k + (1.0 - c) * kk
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
    def turns(self) -> Turns:
        """The joints' rotations."""
        return Turns(self.axes)

    @cached_property
    def levels(self) -> list[tuple[NDArray[np.int64], NDArray[np.int64], Array]]:
        """Joints by distance from the body: their numbers, parents, and offsets (n, 3)."""
        parents, places = self.parents, self.places
        depth = np.zeros(len(parents), dtype=np.int64)
        for j, parent in enumerate(parents):
            depth[j] = 0 if parent == BODY else depth[parent] + 1
        found = []
        for level in range(int(depth.max(initial=-1)) + 1):
            here = np.flatnonzero(depth == level)
            above = parents[here]
            origin = np.where((above == BODY)[:, None], 0.0, places[above])
            found.append((here, above, places[here] - origin))
        return found

    def joint_poses(self, q: Array) -> tuple[Array, Array]:
        """Return the poses of all joint frames relative to the body.

        Args:
            q: (..., J) joint values [rad].

        Returns:
            R_BJ (..., J, 3, 3) and p_BJ (..., J, 3) [m].
        """
        R = self.turns(q)
        p = np.empty((*q.shape, 3))
        for level, (here, above, offset) in enumerate(self.levels):
            if level == 0:
                p[..., here, :] = offset
                continue
            R_above = R[..., above, :, :]
            p[..., here, :] = p[..., above, :] + turn(R_above, offset)
            R[..., here, :, :] = R_above @ R[..., here, :, :]
        return R, p


@dataclass(frozen=True, eq=False)
class LimbPose:
    """Limbs at certain joint values, and all that follows from them.

    Attributes:
        q: (L, n) joint values [rad].
        X_BJ: (L, n, 4, 4) frames of the joints relative to the body.
        tips: (L, 3) p_BF [m].
        jacobian: (L, 3, n), how the tips move with the joints [m/rad].
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
    """

    places: Array
    axes: Array
    tips: Array
    lower: Array
    upper: Array
    preferred: Array
    lengths: Array

    @staticmethod
    def of(limbs: list[tuple[Skeleton, Limb]]) -> LimbBatch:
        """Collect limbs, of several skeletons if need be, whose bases are on the body."""
        n = max((len(limb.joints) for _, limb in limbs), default=0)

        def rows(values: list[Array], fill: list[Array]) -> Array:
            padded = [
                np.concatenate([v, np.repeat(f[None], n - len(v), axis=0)])
                for v, f in zip(values, fill, strict=True)
            ]
            return np.array(padded)

        def taken(name: str) -> list[Array]:
            return [getattr(skeleton, name)[list(limb.joints)] for skeleton, limb in limbs]

        nothing = [np.zeros(3) for _ in limbs]
        zero = [np.zeros(()) for _ in limbs]
        return LimbBatch(
            places=rows(taken("places"), [limb.tip for _, limb in limbs]),
            axes=rows(taken("axes"), nothing),
            tips=np.array([limb.tip for _, limb in limbs]),
            lower=rows(taken("lower"), zero),
            upper=rows(taken("upper"), zero),
            preferred=rows(taken("preferred"), zero),
            lengths=np.array([limb.length for _, limb in limbs]),
        )

    @cached_property
    def turns(self) -> Turns:
        """The joints' rotations."""
        return Turns(self.axes)

    @cached_property
    def _offsets(self) -> Array:
        """(L, n + 1, 3) from each joint to the next, and from the last to the tip [m]."""
        points = np.concatenate(
            [np.zeros_like(self.places[:, :1]), self.places, self.tips[:, None]], axis=1
        )
        return np.diff(points, axis=1)

    def pose(self, q: Array) -> LimbPose:
        """Return frames, tips and Jacobians at joint values `q` (L, n) [rad].

        The column of a joint is a × (p_tip - p): the thesis's a × p is about the base's
        origin and holds only for a tip there.

        Source: Sims 1987, 5.4, eq. 5.2.
        """
        X = np.zeros((*q.shape, 4, 4))
        X[..., :3, :3] = self.turns(q)
        X[..., :3, 3] = self._offsets[:, :-1]
        X[..., 3, 3] = 1.0
        for j in range(1, q.shape[1]):
            np.matmul(X[:, j - 1], X[:, j], out=X[:, j])
        R, places = X[..., :3, :3], X[..., :3, 3]
        # An axis is not moved by its own turn, so the frame after it will do.
        axes = (R @ self.axes[..., None])[..., 0]
        p = places[:, -1] + (R[:, -1] @ self._offsets[:, -1, :, None])[..., 0]
        arm = p[:, None] - places
        columns = cross(axes, arm).transpose(0, 2, 1)
        return LimbPose(q, X, p, columns)
