"""Goals: what a limb is asked for, each said as a task at the pose that it is in.

Any of them can be the first, and any can follow it at lower priority. An error of
orientation is a rotation vector, the axis times the angle that is left; differences of
Euler angles are no velocity and depend on the way they are counted.

Source: Sims 1987, 6.2, B.2 and B.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pipeline.simulation.figures.avoidance import Obstacles, nearest
from pipeline.simulation.figures.dexterity import dexterity_gradient
from pipeline.simulation.figures.jacobian import turning
from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose, Rows
from pipeline.simulation.figures.priority import Task, prioritized
from pipeline.simulation.spatial import Array, quaternion


class Goal(Protocol):
    """Anything that can be asked of limbs."""

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Return what it asks for at `pose`."""
        ...


@dataclass(frozen=True, eq=False)
class Placement:
    """The tips at certain places, and in certain orientations if they are given.

    Attributes:
        places: (L, 3) relative to the base [m].
        orientations: (L, 3, 3) R_BF, the identity being that of joint values zero.
    """

    places: Array
    orientations: Array | None = None

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for the whole way; an angle of one radian counts as one length of the limb."""
        size = batch.lengths[:, None]
        J = pose.jacobian / size[..., None]
        error = (self.places - pose.tips) / size
        if self.orientations is not None:
            J = np.concatenate([J, turning(batch, pose)], axis=-1)
            left = rotation_vector(self.orientations @ pose.R_BF.transpose(0, 2, 1))
            error = np.concatenate([error, left], axis=-1)
        return Task(J.transpose(0, 2, 1), error)

    def rows(self, chosen: Rows) -> Placement:
        """Return the goals of some limbs alone."""
        turned = None if self.orientations is None else self.orientations[chosen]
        return Placement(self.places[chosen], turned)


@dataclass(frozen=True, eq=False)
class Orientation:
    """The tips in certain orientations, wherever they are.

    Attributes:
        orientations: (L, 3, 3) R_BF.
    """

    orientations: Array

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for the whole way."""
        left = rotation_vector(self.orientations @ pose.R_BF.transpose(0, 2, 1))
        return Task(turning(batch, pose).transpose(0, 2, 1), left)


@dataclass(frozen=True, slots=True)
class Preferred:
    """The preferred joint values, as near as may be.

    Attributes:
        gain: α, the part of the way that one step goes.
    """

    gain: float = 0.5

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for z = θ_preferred - θ; B.2 has the sign the other way round."""
        return Task.wish(self.gain * (batch.preferred - pose.q))


@dataclass(frozen=True, slots=True)
class Dexterity:
    """Far from singularities.

    Attributes:
        gain: α, joint values [rad] for a gradient of one.
    """

    gain: float = 1.0

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for the way that raises dexterity the most."""
        return Task.wish(self.gain * dexterity_gradient(batch, pose))


@dataclass(frozen=True, eq=False)
class Avoid:
    """All links clear of obstacles.

    Attributes:
        obstacles: in the frame that the limbs are relative to.
        margin: gap that the lines of the limbs shall keep, their thickness included [m].
    """

    obstacles: Obstacles
    margin: float

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask every link that is too near for what it lacks; those that are clear are free."""
        near = nearest(batch, pose, self.obstacles)
        size = batch.lengths[:, None]
        lacks = np.maximum(self.margin - near.gap, 0.0) / size
        rows = np.einsum("lknx,lkx->lkn", near.jacobian, near.away) / size[..., None]
        return Task(rows * (lacks > 0.0)[..., None], lacks)


@dataclass(frozen=True)
class Weighted:
    """Several goals at once, each with its weight; they may act against one another.

    Attributes:
        parts: weight and goal of each.
    """

    parts: tuple[tuple[float, Goal], ...]

    def task(self, batch: LimbBatch, pose: LimbPose) -> Task:
        """Ask for z = w₁ z₁ + w₂ z₂ + ..., each z what its goal would do alone.

        Source: Sims 1987, eq. B.10.
        """
        z = np.zeros_like(pose.q)
        for weight, goal in self.parts:
            z = z + weight * prioritized([goal.task(batch, pose)], 1e-3)
        return Task.wish(z)


def rotation_vector(R: Array) -> Array:
    """Return axis times angle (..., 3) [rad] of rotations (..., 3, 3), the shorter way round."""
    q = quaternion(R)
    q = np.where(q[..., :1] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    # Near the identity the angle is twice the sine, to the last digit.
    factor = np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)
    result: Array = factor * q[..., 1:]
    return result
