"""Quaternions, vectors and matrices of one body as plain floats.

Use it in plain Python that integrates a single body step by step, such as a hopper: tuples of
floats cost a tenth of the arrays of `spatial`, and plain Python cannot call `dynamics.vectors`.
Quaternions are `wxyz`; a matrix is a tuple of its rows.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.spatial import Array

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Rows = tuple[Vector, Vector, Vector]


def quaternion_product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the product a ⊗ b."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
    )


def quaternion_conjugate(q: Quaternion) -> Quaternion:
    """Return the inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


def from_rotation_vector(vector: Vector) -> Quaternion:
    """Return the quaternion of a rotation vector (axis times angle) [rad]."""
    x, y, z = vector
    angle = math.sqrt(x * x + y * y + z * z)
    s = math.sin(0.5 * angle) / angle if angle > 1e-9 else 0.5
    return math.cos(0.5 * angle), s * x, s * y, s * z


def to_rotation_vector(q: Quaternion) -> Vector:
    """Return the rotation vector of a unit quaternion, at most half a turn long [rad]."""
    w, x, y, z = q if q[0] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    s = math.sqrt(x * x + y * y + z * z)
    k = 2.0 * math.atan2(s, w) / s if s > 1e-12 else 2.0
    return k * x, k * y, k * z


def matrix_rows(q: Quaternion) -> Rows:
    """Return the rows of the rotation matrix of a unit quaternion."""
    w, x, y, z = q
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def rotation_matrix(q: Quaternion) -> Array:
    """Return the rotation matrix (3, 3) of a unit quaternion as an array."""
    return np.array(matrix_rows(q))


def rotate(R: Rows, v: Vector) -> Vector:
    """Return R v."""
    a, b, c = R
    x, y, z = v
    return (
        a[0] * x + a[1] * y + a[2] * z,
        b[0] * x + b[1] * y + b[2] * z,
        c[0] * x + c[1] * y + c[2] * z,
    )


def rotate_inverse(R: Rows, v: Vector) -> Vector:
    """Return Rᵀ v."""
    a, b, c = R
    x, y, z = v
    return (
        a[0] * x + b[0] * y + c[0] * z,
        a[1] * x + b[1] * y + c[1] * z,
        a[2] * x + b[2] * y + c[2] * z,
    )


def cross_product(a: Vector, b: Vector) -> Vector:
    """Return a × b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def normalize_quaternion(q: Quaternion) -> Quaternion:
    """Return `q` scaled to length one."""
    n = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return n * q[0], n * q[1], n * q[2], n * q[3]


def vector_tuple(v: Array) -> Vector:
    """Return an array (3,) as plain floats."""
    x, y, z = v.tolist()
    return x, y, z
