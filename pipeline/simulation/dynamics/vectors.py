"""Vectors in compiled code: triples, quaternions, and rotations as three rows.

Use it within compiled functions alone, where tuples stay in registers: these functions have no
Python wrapper and crash when plain Python calls them. Plain Python uses `spatial` for arrays and
`scalar_rotation` for a single body.
"""

from __future__ import annotations

import math

from pipeline.simulation.dynamics.compiled import compiled
from pipeline.simulation.spatial import Array

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Rows = tuple[Vector, Vector, Vector]


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Returns a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """Returns a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@compiled
def plus(a: Vector, b: Vector) -> Vector:
    """Returns a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@compiled
def minus(a: Vector, b: Vector) -> Vector:
    """Returns a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@compiled
def times(s: float, a: Vector) -> Vector:
    """Returns s a."""
    return (s * a[0], s * a[1], s * a[2])


@compiled
def length(a: Vector) -> float:
    """Returns |a|."""
    return math.sqrt(dot(a, a))


@compiled
def hypotenuse(x: float, y: float) -> float:
    """Returns √(x² + y²), more quickly than `math.hypot`, which heeds overflows."""
    return math.sqrt(x * x + y * y)


@compiled
def row(values: Array, i: int) -> Vector:
    """Returns row i of an array (n, 3)."""
    return (values[i, 0], values[i, 1], values[i, 2])


@compiled
def triple(values: Array) -> Vector:
    """Returns the three values of an array (3,)."""
    return (values[0], values[1], values[2])


@compiled
def put(values: Array, i: int, a: Vector) -> None:
    """Sets row i of an array (n, 3)."""
    values[i, 0], values[i, 1], values[i, 2] = a[0], a[1], a[2]


@compiled
def set_triple(values: Array, a: Vector) -> None:
    """Sets the three values of an array (3,)."""
    values[0], values[1], values[2] = a[0], a[1], a[2]


@compiled
def turned(R: Rows, a: Vector) -> Vector:
    """Returns R a."""
    return (dot(R[0], a), dot(R[1], a), dot(R[2], a))


@compiled
def inverse_turned(R: Rows, a: Vector) -> Vector:
    """Returns Rᵀ a."""
    x, y, z = R
    return (
        x[0] * a[0] + y[0] * a[1] + z[0] * a[2],
        x[1] * a[0] + y[1] * a[1] + z[1] * a[2],
        x[2] * a[0] + y[2] * a[1] + z[2] * a[2],
    )


@compiled
def rows_of(M: Array) -> Rows:
    """Returns the rows of a matrix (3, 3)."""
    return (row(M, 0), row(M, 1), row(M, 2))


@compiled
def carried(R: Rows, M: Rows) -> Rows:
    """Returns the symmetric R M Rᵀ: a tensor along body axes, in the world frame."""
    x, y, z = turned(M, R[0]), turned(M, R[1]), turned(M, R[2])
    xy, xz, yz = dot(R[0], y), dot(R[0], z), dot(R[1], z)
    return ((dot(R[0], x), xy, xz), (xy, dot(R[1], y), yz), (xz, yz, dot(R[2], z)))


@compiled
def rotation(q: Quaternion) -> Rows:
    """Returns the rotation of a unit quaternion wxyz."""
    w, x, y, z = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@compiled
def normal_quaternion(q: Quaternion) -> Quaternion:
    """Returns q / |q|."""
    s = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (q[0] / s, q[1] / s, q[2] / s, q[3] / s)
