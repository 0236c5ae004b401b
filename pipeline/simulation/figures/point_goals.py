"""Point goals: what is asked of any node of a limb, not of its tip alone.

Joints beyond the node do not move it, so their columns are zero and they are left to the
goals that follow. "The elbow on the table, the hand at the chin" are two such goals.

Source: Sims 1987, 6.2 (goals for inner joints), B.2 and B.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.goals import Goal, rotation_vector
from pipeline.simulation.figures.jacobian import turning
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose
from pipeline.simulation.figures.priority import Task
from pipeline.simulation.spatial import Array, cross, turn


@dataclass(frozen=True, eq=False)
class LimbPoint:
    """A node of a limb, on the link that ends there.

    Attributes:
        column: which of the limb's joints moves that link.
        place: (3,) of the node in the creation frame [m].
        along: (3,) unit direction of the link in the creation frame.
    """

    column: int
    place: Array
    along: Array

    def at(self, batch: LimbBatch, pose: LimbPose) -> Array:
        """Return where it is (L, 3), relative to the limb's base [m]."""
        X = pose.X_BJ[:, self.column]
        result: Array = X[:, :3, 3] + turn(X[:, :3, :3], self.place - batch.places[:, self.column])
        return result

    def turned(self, pose: LimbPose) -> Array:
        """Return how its link is turned (L, 3, 3)."""
        R: Array = pose.X_BJ[:, self.column, :3, :3]
        return R

    def levers(self, batch: LimbBatch, pose: LimbPose) -> Array:
        """Return Jᵀ (L, n, 3) of its place [m/rad or 1]."""
        axes = turn(pose.X_BJ[..., :3, :3], batch.axes)
        J = cross(axes, self.at(batch, pose)[:, None] - pose.X_BJ[..., :3, 3])
        J = np.where(batch.prismatic[..., None], axes, J)
        J[:, self.column + 1 :] = 0.0
        return J

    def turns(self, batch: LimbBatch, pose: LimbPose) -> Array:
        """Return Jᵀ (L, n, 3) of its link's orientation [1]."""
        J = turning(batch, pose)
        J[:, self.column + 1 :] = 0.0
        return J


@dataclass(frozen=True, eq=False)
class PointAt:
    """A node at a place.

    Attributes:
        point: the node.
        place: (L, 3) relative to the limb's base [m].
    """

    point: LimbPoint
    place: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for the whole way, in lengths of the limb."""
        size = batch.lengths[:, None]
        J = self.point.levers(batch, pose) / size[..., None]
        error = (self.place - self.point.at(batch, pose)) / size
        return Task(J.transpose(0, 2, 1), error)


@dataclass(frozen=True, eq=False)
class PointTurned:
    """The link that ends at a node in a certain orientation.

    Attributes:
        point: the node.
        orientation: (L, 3, 3), the identity being the way it was drawn.
    """

    point: LimbPoint
    orientation: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for the whole turn [rad]."""
        left = rotation_vector(self.orientation @ self.point.turned(pose).transpose(0, 2, 1))
        return Task(self.point.turns(batch, pose).transpose(0, 2, 1), left)


@dataclass(frozen=True, eq=False)
class PointAimed:
    """The link that ends at a node pointing in a direction; free to roll about it.

    Attributes:
        point: the node.
        direction: (L, 3) unit vectors.
    """

    point: LimbPoint
    direction: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for the shortest turn [rad]."""
        now = turn(self.point.turned(pose), self.point.along)
        axis = cross(now, self.direction)
        sine = np.linalg.norm(axis, axis=-1, keepdims=True)
        cosine = np.sum(now * self.direction, axis=-1, keepdims=True)
        # Right behind it every axis across will do.
        behind = cross(now, np.where(np.abs(now[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 0, 1.0]]))
        axis = np.where((sine < 1e-9) & (cosine < 0.0), behind, axis)
        length = np.linalg.norm(axis, axis=-1, keepdims=True)
        error = np.arctan2(sine, cosine) * axis / np.where(length > 0.0, length, 1.0)
        J = self.point.turns(batch, pose).transpose(0, 2, 1)
        across = np.eye(3) - now[:, :, None] * now[:, None, :]
        return Task(across @ J, error)


@dataclass(frozen=True, eq=False)
class JointsAt:
    """Some joints at certain values.

    Attributes:
        columns: (n,) 1 for those that are asked for, 0 for the others.
        values: (L, n) [rad or m].
    """

    columns: Array
    values: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for the whole way."""
        del batch
        rows = np.broadcast_to(np.diag(self.columns), (len(pose.q), *np.diag(self.columns).shape))
        return Task(rows, self.columns * (self.values - pose.q))


@dataclass(frozen=True, eq=False)
class Toward:
    """All joints a little nearer to certain values.

    Attributes:
        values: (L, n) [rad or m].
        gain: the part of the way that one step goes.
    """

    values: Array
    gain: float

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for a part of the way."""
        del batch
        return Task.wish(self.gain * (self.values - pose.q))


@dataclass(frozen=True)
class Compromise:
    """Several goals at once, the sum of whose squared errors is to be least.

    The thesis adds the joint velocities that each goal would have alone (eq. B.10, see
    `Weighted`); goals that agree would then be served twice.

    Attributes:
        parts: weight and goal of each.
    """

    parts: Sequence[tuple[float, Goal]]

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for all, each error times the root of its weight."""
        tasks = [(weight**0.5, goal.task(batch, pose)) for weight, goal in self.parts]
        return Task(
            np.concatenate([w * task.jacobian for w, task in tasks], axis=1),
            np.concatenate([w * task.velocity for w, task in tasks], axis=1),
        )
