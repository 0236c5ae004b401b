"""Row motion: speeds and accelerations of a figure, from its poses in equally spaced rows.

By central differences, so the first and the last row have none, and what changes within a
row is seen as its mean.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.figures.goals import rotation_vector
from pipeline.simulation.figures.inverse_dynamics import Motion
from pipeline.simulation.spatial import Array


def motion_of_rows(q: Array, R_WB: Array, p_WB: Array, dt: float) -> Motion:
    """Return the motion in all rows but the first and the last.

    Args:
        q: (K, ..., J) joint values [rad or m].
        R_WB: (K, ..., 3, 3) orientation of the body.
        p_WB: (K, ..., 3) its place [m].
        dt: time between two rows [s].
    """
    X = np.zeros((*p_WB[1:-1].shape[:-1], 4, 4))
    X[..., :3, :3], X[..., :3, 3], X[..., 3, 3] = R_WB[1:-1], p_WB[1:-1], 1.0
    spins = between(R_WB[:-1], R_WB[1:]) / dt
    return Motion(
        q[1:-1],
        (q[2:] - q[:-2]) / (2.0 * dt),
        _second(q, dt),
        X,
        0.5 * (spins[1:] + spins[:-1]),
        (spins[1:] - spins[:-1]) / dt,
        _second(p_WB, dt),
    )


def between(before: Array, after: Array) -> Array:
    """Return the rotation vectors (..., 3) from `before` to `after` (..., 3, 3), in the world."""
    return rotation_vector(after @ np.swapaxes(before, -1, -2))


def _second(v: Array, dt: float) -> Array:
    result: Array = (v[2:] - 2.0 * v[1:-1] + v[:-2]) / (dt * dt)
    return result
