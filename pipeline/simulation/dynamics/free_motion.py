"""Free motion: rotation of a rigid body without torque.

Euler's equations and the attitude's, in the frame of the body,

    I ω' = (I ω) × ω,        q' = q ⊗ (0, ω) / 2,

are quadratic, so each coefficient of their power series in time follows from those before. No
integration rule of fixed order is chosen: the series ends where its terms no longer count. It
gives the attitude at any time of the step for the price of a polynomial, which the search for
impacts needs. A body of isotropic inertia (`inertia: scalar`) turns at a constant rate.

Source: Sims 1987, 7.1. (7.7) lacks the gyroscopic term, which vanishes only for isotropic
inertia, and (7.9) with ω in the world is R' = Rot(ω Δt) R.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.compiled import compiled, entry
from pipeline.simulation.dynamics.vectors import (
    Quaternion,
    Rows,
    Vector,
    cross,
    normal_quaternion,
    plus,
    row,
    rows_of,
    times,
    turned,
)
from pipeline.simulation.spatial import Array

MAX_ORDER = 12
"""Highest power of time in the series."""

MAX_STEP_ANGLE = 0.15
"""Largest rotation in a step, about [rad]: the truncated terms are then below 1e-13."""

NEGLIGIBLE_TERM = 1e-17
"""Size of negligible terms, relative to the first."""

SERIES_COLUMNS = 10
"""Columns of a series: attitude, angular velocity, angular momentum."""


@compiled
def rotation_series(
    q: Quaternion, w: Vector, inertia: Rows, inverse: Rows, h: float, series: Array
) -> int:
    """Writes the power series of a free rotation; returns its highest significant power.

    Args:
        q: attitude.
        w: angular velocity in the frame of the body [rad/s].
        inertia: along the axes of the body [kg m²].
        inverse: inverse inertia.
        h: longest time that it is used for [s].
        series: (MAX_ORDER + 1, SERIES_COLUMNS) coefficients, written.
    """
    _write_coefficient(series, 0, q, w, turned(inertia, w))
    rate, power = abs(w[0]) + abs(w[1]) + abs(w[2]), 1.0
    small = 0
    for k in range(MAX_ORDER):
        turning, torque = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for i in range(k + 1):
            j = k - i
            a, b, c, d = series[i, 0], series[i, 1], series[i, 2], series[i, 3]
            x, y, z = _rate(series, j)
            turning = (
                turning[0] - b * x - c * y - d * z,
                turning[1] + a * x + c * z - d * y,
                turning[2] + a * y + d * x - b * z,
                turning[3] + a * z + b * y - c * x,
            )
            momentum = (series[i, 7], series[i, 8], series[i, 9])
            torque = plus(torque, cross(momentum, _rate(series, k - i)))
        torque = times(1.0 / (k + 1), torque)
        s = 0.5 / (k + 1)
        q = (s * turning[0], s * turning[1], s * turning[2], s * turning[3])
        w = turned(inverse, torque)
        _write_coefficient(series, k + 1, q, w, torque)
        power *= h
        most_q = power * (abs(q[0]) + abs(q[1]) + abs(q[2]) + abs(q[3]))
        most_w = power * (abs(w[0]) + abs(w[1]) + abs(w[2]))
        small = small + 1 if most_q <= NEGLIGIBLE_TERM and most_w <= NEGLIGIBLE_TERM * rate else 0
        if small == 2:
            return k
    return MAX_ORDER


@compiled
def evaluate_rotation(series: Array, order: int, t: float) -> tuple[Quaternion, Vector]:
    """Returns attitude and angular velocity after a time t [s]."""
    a, b, c, d = series[order, 0], series[order, 1], series[order, 2], series[order, 3]
    w = _rate(series, order)
    for k in range(order - 1, -1, -1):
        a, b = series[k, 0] + t * a, series[k, 1] + t * b
        c, d = series[k, 2] + t * c, series[k, 3] + t * d
        w = plus(_rate(series, k), times(t, w))
    return normal_quaternion((a, b, c, d)), w


@entry
def rotate_freely(q: Array, w: Array, inertia: Array, inverse: Array, h: float) -> None:
    """Rotates N bodies freely, in place.

    Args:
        q: (N, 4) attitudes wxyz.
        w: (N, 3) angular velocities in the frames of the bodies [rad/s].
        inertia: (N, 3, 3) [kg m²].
        inverse: (N, 3, 3) inverse inertia.
        h: duration [s]; see `MAX_STEP_ANGLE`.
    """
    series = np.empty((MAX_ORDER + 1, SERIES_COLUMNS))
    for i in range(len(q)):
        order = rotation_series(
            (q[i, 0], q[i, 1], q[i, 2], q[i, 3]),
            row(w, i),
            rows_of(inertia[i]),
            rows_of(inverse[i]),
            h,
            series,
        )
        after, rate = evaluate_rotation(series, order, h)
        for k in range(4):
            q[i, k] = after[k]
        for k in range(3):
            w[i, k] = rate[k]


@compiled
def rotate_by_vector(q: Quaternion, angle: Vector) -> Quaternion:
    """Returns an attitude rotated by a rotation vector in the world [rad]."""
    half = 0.5 * math.sqrt(angle[0] * angle[0] + angle[1] * angle[1] + angle[2] * angle[2])
    s = 0.5 * (math.sin(half) / half if half > 1e-8 else 1.0 - half * half / 6.0)
    a, b, c, d = math.cos(half), s * angle[0], s * angle[1], s * angle[2]
    w, x, y, z = q
    return normal_quaternion(
        (
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y + c * w + d * x - b * z,
            a * z + d * w + b * y - c * x,
        )
    )


@compiled
def _rate(series: Array, k: int) -> Vector:
    return (series[k, 4], series[k, 5], series[k, 6])


@compiled
def _write_coefficient(series: Array, k: int, q: Quaternion, w: Vector, momentum: Vector) -> None:
    for i in range(4):
        series[k, i] = q[i]
    for i in range(3):
        series[k, 4 + i], series[k, 7 + i] = w[i], momentum[i]
