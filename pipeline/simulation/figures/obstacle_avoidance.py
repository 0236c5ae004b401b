"""Distances of limbs from obstacles, and the directions away from them.

Obstacles are capsules; a ball is one without length. Joints beyond a link do not move it: a
Jacobian J_0 of its own describes the limb up to its nearest point.

Source: Sims 1987, B.2; closest points of two segments after Ericson 2005, 5.1.9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.kinematics import LimbBatch, LimbPose, rotation_axes
from pipeline.simulation.spatial import Array, cross, turn


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Capsules, in the frame that limbs are relative to.

    Attributes:
        ends: (O, 2, 3) ends of their axes [m].
        radii: (O,) [m].
    """

    ends: Array
    radii: Array


@dataclass(frozen=True, eq=False)
class NearestObstacles:
    """The nearest obstacle to each link of each limb.

    Attributes:
        gap: (L, n) distance of the link's line from the obstacle's surface, negative inside [m].
            Link k is moved by joint k.
        away: (L, n, 3) unit direction away from the obstacle.
        jacobian: (L, n, n, 3) J_0ᵀ of the nearest point of each link (second).
    """

    gap: Array
    away: Array
    jacobian: Array


def nearest_obstacles(batch: LimbBatch, pose: LimbPose, obstacles: Obstacles) -> NearestObstacles:
    """Return the obstacle nearest to each link."""
    R, joints = pose.X_BJ[..., :3, :3], pose.X_BJ[..., :3, 3]
    ends = np.concatenate([joints[:, 1:], pose.tips[:, None]], axis=1)
    ours, theirs = closest_points(
        joints[:, :, None],
        ends[:, :, None],
        obstacles.ends[None, None, :, 0],
        obstacles.ends[None, None, :, 1],
    )
    distance = np.linalg.norm(ours - theirs, axis=-1)
    which = (distance - obstacles.radii).argmin(axis=-1)[..., None]
    ours, theirs = (
        np.take_along_axis(p, which[..., None], axis=2)[:, :, 0] for p in (ours, theirs)
    )
    distance = np.linalg.norm(ours - theirs, axis=-1)
    away = (ours - theirs) / np.maximum(distance, 1e-300)[..., None]
    turned = cross(rotation_axes(batch, pose)[:, None], ours[:, :, None] - joints[:, None])
    J = np.where(batch.prismatic[:, None, :, None], turn(R, batch.axes)[:, None], turned)
    n = joints.shape[1]
    J = J * np.tri(n)[None, :, :, None]
    return NearestObstacles(distance - obstacles.radii[which[..., 0]], away, J)


def closest_points(a: Array, b: Array, c: Array, d: Array) -> tuple[Array, Array]:
    """Return the nearest points (..., 3) of the segments from `a` to `b` and from `c` to `d`.

    All are (..., 3), and either segment may be a point.
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = _dot(u, u), _dot(v, v), _dot(u, v)
    uw, vw = _dot(u, w), _dot(v, w)
    square = uu * vv - uv * uv
    # For parallel segments any start is valid.
    apart = square > 1e-12 * uu * vv
    s = np.where(apart, np.clip((uv * vw - vv * uw) / np.where(apart, square, 1.0), 0, 1), 0.0)
    long = vv > 0.0
    t = np.where(long, np.clip((uv * s + vw) / np.where(long, vv, 1.0), 0, 1), 0.0)
    wide = uu > 0.0
    s = np.where(wide, np.clip((uv * t - uw) / np.where(wide, uu, 1.0), 0, 1), 0.0)
    return a + s[..., None] * u, c + t[..., None] * v


def _dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)
