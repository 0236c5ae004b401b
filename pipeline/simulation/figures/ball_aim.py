"""Ball aim: the angles of a ball joint that point a limb at its goal, with its knee in its plane.

Two of the three angles bring the tip to the goal; the third is free, the swivel of the knee about
the line from base to tip. Here the axis across the limb, about which its knee bends, stays as near
as possible to where it points at rest. So a knee keeps to its plane, and the pose is a function of
the goal that has no gap but where the goal lies on that axis. Limbs that turn about an upright axis
first, as those of insects, turn their plane with the goal: it stays upright.

Notation: a₁, a₂, a₃ axes of the ball joint, perpendicular to each other; g goal and t tip from the
base as unit vectors, all in the components of these axes; n the axis across the limb.

Source: Sims 1987, 6.3.1; angles about three axes after Murray, Li and Sastry 1994, ch. 2, 2.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import bounded, ease
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.spatial import Array

MOST_TURN = 1.1
"""Greatest angle by which the plane of a limb turns with its goal [rad]."""

OUTWARD = 0.1, 0.6
"""Distance of the goal from the upright axis, outward and as a part of the way to it, between which
the plane of a limb begins to turn with it: nearer, its direction means little."""


def ball_joints(batch: LimbBatch) -> NDArray[np.bool_]:
    """Return which limbs (L,) turn about three perpendicular axes through their bases."""
    if batch.is_joint.shape[1] < 3:
        return np.zeros(len(batch.lengths), dtype=bool)
    places, axes = batch.places[:, :3], batch.axes[:, :3]
    together = np.abs(places - places[:, :1]).max(axis=(1, 2)) < 1e-9 * batch.lengths
    turns = (batch.is_joint & ~batch.prismatic)[:, :3].all(axis=1)
    square = np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)) < 1e-9
    result: NDArray[np.bool_] = together & turns & square
    return result


@dataclass(frozen=True, eq=False)
class BallAim:
    """Ball joints of l limbs; a last axis of 1 stands for the moments.

    Attributes:
        axes: (3, 3, l, 1) a₁, a₂, a₃, each (3, l, 1).
        hand: (l, 1) 1 where they are right-handed, else -1.
        across: (3, l, 1) n at joint values zero.
        rest_across: (3, l, 1) n at rest.
        rest: (2, l, 1) direction of the tip at rest about a₁, by a₂ and a₃; zero for limbs whose
            plane does not turn.
    """

    axes: Array
    hand: Array
    across: Array
    rest_across: Array
    rest: Array

    @staticmethod
    def of(batch: LimbBatch) -> BallAim:
        """Return the ball joints of `batch`; see `ball_joints`."""
        axes = batch.axes[:, :3]
        # A joint that slides bends nothing; limbs without a knee have theirs about a level axis.
        bends = batch.axes[:, 3:] * ~batch.prismatic[:, 3:, None]
        along = np.abs(np.einsum("lij,lnj->lin", axes, bends)).sum(axis=-1)
        stiff = along.max(axis=1) == 0.0
        along[stiff] = np.where(np.abs(axes[stiff, :1, 1]) < 0.5, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
        number = np.arange(len(axes))
        which = along.argmax(axis=1)
        across = np.eye(3)[which]
        pose = batch.pose(batch.preferred)
        R_rest = pose.X_BJ[:, 2, :3, :3]
        rest_across = np.einsum("lij,lj->li", axes, _turned(R_rest, axes[number, which]))
        tip = np.einsum("lij,lj->li", axes, pose.tips - batch.places[:, 0])
        level = tip[:, 1:] / np.maximum(np.linalg.norm(tip[:, 1:], axis=1, keepdims=True), 1e-300)
        level[which == 0] = 0.0
        return BallAim(
            axes=np.moveaxis(axes, 0, -1)[..., None],
            hand=np.sign(np.linalg.det(axes))[:, None],
            across=across.T[..., None],
            rest_across=rest_across.T[..., None],
            rest=level.T[..., None],
        )

    def subset(self, chosen: slice | NDArray[np.int64]) -> BallAim:
        """Return some limbs alone; numbers may repeat."""
        arrays = (self.axes, self.hand, self.across, self.rest_across, self.rest)
        return BallAim(*(pick_limbs(values, chosen) for values in arrays))

    @cached_property
    def _turns(self) -> bool:
        return bool(self.rest.any())

    def angles(self, tip: Array, goal: Array, across: Array | None = None) -> Array:
        """Return the angles (3, l, m) that turn tips (3, l, m) towards goals (3, l, m) [rad].

        Args:
            tip: from the base, at joint values zero of the ball joint.
            goal: from the base.
            across: (3, l, m) n, if it is given.
        """
        t, g = _unit(self._components(tip)), _unit(self._components(goal))
        m = _unit(_across(self.across, t))
        n = self._swivel(g) if across is None else _unit(_across(self._components(across), g))
        # R maps (t, m, t × m) to (g, n, g × n); only its first row and last column count.
        u, v = _cross(t, m), _cross(g, n)

        def R(i: int, j: int) -> Array:
            return g[i] * t[j] + n[i] * m[j] + v[i] * u[j]

        first = np.arctan2(-R(1, 2), R(2, 2))
        second = np.arcsin(np.clip(R(0, 2), -1.0, 1.0))
        third = np.arctan2(-R(0, 1), R(0, 0))
        result: Array = self.hand * np.stack([first, second, third])
        return result

    def _components(self, v: Array) -> Array:
        return np.stack([_dot(axis, v) for axis in self.axes])

    def _swivel(self, g: Array) -> Array:
        """Return n (3, l, m) for goals in directions g (3, l, m)."""
        if not self._turns:
            return _unit(_across(self.rest_across, g))
        # Turned about a₁ with the goal, from the tip's direction at rest.
        (x, z), (a, b) = g[1:], self.rest
        cosine, sine = a * x + b * z, a * z - b * x
        level = np.sqrt(cosine * cosine + sine * sine)
        low, high = OUTWARD
        part = ease(np.clip((0.5 * (level + cosine) - low) / (high - low), 0.0, 1.0))
        angle = part * MOST_TURN * bounded(np.arctan2(sine, cosine) / MOST_TURN)
        c, s = np.cos(angle), np.sin(angle)
        p, q, r = self.rest_across
        turned = np.stack(np.broadcast_arrays(p, c * q - s * r, s * q + c * r))
        return _unit(_across(turned, g))


def pick_limbs(values: Array, which: slice | NDArray[np.int64]) -> Array:
    """Return `values` (..., l, 1) of some limbs, with limbs last in memory."""
    if isinstance(which, slice):
        return values[..., which, :]
    return values.take(which, axis=-2)


def _across(v: Array, g: Array) -> Array:
    """Return the part of `v` that is perpendicular to the unit vectors `g`."""
    return v - _dot(v, g) * g


def _turned(R: Array, v: Array) -> Array:
    return np.einsum("lij,lj->li", R, v)


def _cross(a: Array, b: Array) -> Array:
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _dot(a: Array, b: Array) -> Array:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _unit(v: Array) -> Array:
    return v / np.maximum(np.sqrt(_dot(v, v)), 1e-300)
