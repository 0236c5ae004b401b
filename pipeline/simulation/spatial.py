"""Rotations and poses of many bodies as numpy arrays; the table of letters.

    W world      B body or link      J joint      F foot      C camera

`p_WB` is the position of B in W, `R_WB` its rotation matrix, `q_WB` the same as a
quaternion `wxyz`, `v_WB` its velocity. Neighbouring letters cancel:
`p_WF = p_WB + R_WB @ p_BF`. All functions work on the last axis (or the last two,
for matrices) and broadcast over the others.

Use this module wherever arrays are at hand. A loop over the sub-steps of one body in plain Python
uses `scalar_rotation`; compiled code uses `dynamics.vectors`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UP: Array = np.array([0.0, 1.0, 0.0])


def normalized(v: Array) -> Array:
    """Returns `v` (..., 3) scaled to length one; a zero vector stays zero."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(length > 0.0, length, 1.0)


def rotation(axis: Array, angle: Array | float) -> Array:
    """Returns the matrices (..., 3, 3) that rotate by `angle` [rad] about unit `axis` (..., 3).

    Source: Rodrigues' formula; it equals the product Qᵀ Z(θ) Q of Sims 1987, A.2 and A.3.
    """
    axis = np.asarray(axis, dtype=float)
    K = cross_matrix(axis)
    s, c = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
    return np.eye(3) + s * K + (1.0 - c) * (K @ K)


def cross_matrix(v: Array) -> Array:
    """Returns the matrices (..., 3, 3) whose product with w is v × w, for `v` (..., 3)."""
    K = np.zeros((*v.shape[:-1], 3, 3))
    K[..., 0, 1], K[..., 0, 2], K[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    K[..., 1, 0], K[..., 2, 0], K[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return K


def cross(a: Array, b: Array) -> Array:
    """Returns a × b (..., 3); a tenth of the time of numpy's for a few vectors."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    result[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    result[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    result[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return result


def heading(angle: Array | float) -> Array:
    """Returns the rotations (..., 3, 3) by `angle` [rad] about +Y; 0 looks along +X."""
    return rotation(UP, angle)


def quaternion(R: Array) -> Array:
    """Returns the unit quaternions (..., 4) `wxyz` of rotation matrices (..., 3, 3).

    Of the four equivalent formulas each matrix uses the one with the largest component, which
    keeps full precision near half turns.

    Source: Shepperd 1978.
    """
    # Component by component: contiguous arrays take a third of the time.
    m = np.ascontiguousarray(np.moveaxis(R.reshape(*R.shape[:-2], 9), -1, 0))
    m00, m01, m02, m10, m11, m12, m20, m21, m22 = m
    w, x, y, z = (
        1 + m00 + m11 + m22,
        1 + m00 - m11 - m22,
        1 - m00 + m11 - m22,
        1 - m00 - m11 + m22,
    )
    a, b, c = m21 - m12, m02 - m20, m10 - m01
    d, e, f = m10 + m01, m02 + m20, m21 + m12
    greatest, by_x = np.maximum(w, x), x > w
    by_y = y > greatest
    by_z = z > np.maximum(greatest, y)
    q = np.empty((4, *w.shape))
    for k, of_each in enumerate(((w, a, b, c), (a, x, d, e), (b, d, y, f), (c, e, f, z))):
        q[k] = of_each[0]
        for chosen, values in zip((by_x, by_y, by_z), of_each[1:], strict=True):
            np.copyto(q[k, ...], values, where=chosen)
    q /= np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return np.ascontiguousarray(np.moveaxis(q, 0, -1))


def matrix(q: Array) -> Array:
    """Returns the rotation matrices (..., 3, 3) of unit quaternions (..., 4) `wxyz`."""
    w, x, y, z = np.moveaxis(np.asarray(q, dtype=float), -1, 0)
    result = np.empty((*w.shape, 3, 3))
    result[..., 0, 0] = 1 - 2 * (y * y + z * z)
    result[..., 0, 1] = 2 * (x * y - w * z)
    result[..., 0, 2] = 2 * (x * z + w * y)
    result[..., 1, 0] = 2 * (x * y + w * z)
    result[..., 1, 1] = 1 - 2 * (x * x + z * z)
    result[..., 1, 2] = 2 * (y * z - w * x)
    result[..., 2, 0] = 2 * (x * z - w * y)
    result[..., 2, 1] = 2 * (y * z + w * x)
    result[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return result


def continuous(q: Array) -> Array:
    """Returns quaternions (K, ..., 4) with signs that keep each row near the one before.

    Both signs are the same rotation; continuous ones can be interpolated.
    """
    flips = np.sum(q[1:] * q[:-1], axis=-1, keepdims=True) < 0.0
    # Each flip negates all later rows, so a row's sign is the parity of the flips so far.
    odd = np.cumsum(flips, axis=0) % 2 == 1
    result = q.copy()
    result[1:] = np.where(odd, -q[1:], q[1:])
    return result


def turn(R: Array, v: Array) -> Array:
    """Returns the vectors `v` (..., 3) rotated by the matrices `R` (..., 3, 3)."""
    return (R @ v[..., None])[..., 0]


def turn_inverse(R: Array, v: Array) -> Array:
    """Returns the vectors `v` (..., 3) rotated by the inverses of `R` (..., 3, 3)."""
    return (v[..., None, :] @ R)[..., 0, :]


def from_directions(forward: Array, up: Array) -> Array:
    """Returns rotations (..., 3, 3) whose X is `forward` and whose Y is as near `up` as possible.

    Args:
        forward: (..., 3), not parallel to `up`; need not have length one.
        up: (..., 3).
    """
    x = normalized(forward)
    z = normalized(cross(x, np.broadcast_to(up, x.shape)))
    y = cross(z, x)
    return np.stack([x, y, z], axis=-1)
