"""Kinematic bodies: solids whose motion is given from step to step; nothing pushes them.

Letters as in `rigid_body`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, quaternion

TELEPORT_SPEED = 100.0
"""Speed above which a solid counts as placed elsewhere and pushes nothing on its way [m/s]."""

NO_VELOCITIES = np.zeros((0, 6))
"""Velocities of no bodies."""

NO_PATHS = np.zeros((0, 5))
"""Paths of no bodies."""


@dataclass(frozen=True, slots=True)
class Poses:
    """Poses of P solids: origins p (P, 3) [m] and rotations R (P, 3, 3)."""

    p: Array
    R: Array


class KinematicBodies:
    """P solids, and their motion within a step.

    Attributes:
        begin: (P, 7) p and q at the start of the step.
        speed: (P,) of their origins during it [m/s].
    """

    def __init__(self, count: int, step: float) -> None:
        self.step = step
        self.speed = np.zeros(count)
        self.begin = np.zeros((count, 7))
        self._now: Poses | None = None

    def put(self, poses: Poses) -> Array:
        """Places them without motion; returns p and q (P, 7)."""
        self._now = poses
        self.begin = np.concatenate([poses.p, quaternion(poses.R)], axis=1)
        return self.begin

    @property
    def now(self) -> Poses:
        """Poses at the start of the next step; valid once they were put."""
        assert self._now is not None
        return self._now

    def move(self, which: NDArray[np.int64], poses: Poses) -> None:
        """Places some of them without motion."""
        p, R = self.now.p.copy(), self.now.R.copy()
        p[which], R[which] = poses.p, poses.R
        self._now = Poses(p, R)

    def motion(self, poses: Poses | None) -> Array:
        """Returns velocities (P, 6), v and w, that reach `poses` at the end of the step."""
        before = self._now
        if poses is None or before is None:
            return NO_VELOCITIES
        self.begin = np.concatenate([before.p, quaternion(before.R)], axis=1)
        self._now = poses
        v = (poses.p - before.p) / self.step
        w = rotation_vectors(np.swapaxes(before.R, -1, -2) @ poses.R) / self.step
        self.speed = np.sqrt((v * v).sum(axis=1))
        leaps = self.speed > TELEPORT_SPEED
        if leaps.any():
            self.begin[leaps] = np.concatenate([poses.p, quaternion(poses.R)], axis=1)[leaps]
            v[leaps] = w[leaps] = self.speed[leaps] = 0.0
        return np.concatenate([v, w], axis=1)

    def paths(self, far: Array) -> Array:
        """Returns (P, 5): start, reach including the way of two steps [m], and speed [m/s].

        Args:
            far: (P,) distance of their farthest corner [m].
        """
        if not len(far):
            return NO_PATHS
        reach = far + 2.0 * self.step * self.speed
        return np.column_stack([self.begin[:, :3], reach, self.speed])


def rotation_vectors(R: Array) -> Array:
    """Returns the vectors (P, 3), axis times angle, of rotations (P, 3, 3)."""
    q = quaternion(R)
    q = np.where(q[:, :1] < 0.0, -q, q)
    sine = np.sqrt((q[:, 1:] ** 2).sum(axis=1))
    angle = 2.0 * np.arctan2(sine, q[:, 0])
    return q[:, 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)[:, None]
