"""Bend: what the way of a swinging foot has beside the eased way and the arch.

A uniform cubic B-spline over the swing. Its first and last three control points are
nothing, so a bent swing begins and ends where and as the straight one does: place, speed
and acceleration. In between it is twice continuously differentiable.

Source: de Boor 1978.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.spatial import Array

SPANS = 16
"""Pieces that a swing is divided into."""

POINTS = SPANS - 3
"""Control points that are free."""

KNOTS: Array = np.linspace(0.0, 1.0, SPANS + 1)
"""Parts of the swing between the pieces; the free points belong to all but two at each end."""


def bent(bend: Array, s: Array) -> Array:
    """Return bends (L, 3) at parts `s` (L,) of swings [m].

    Args:
        bend: (L, `POINTS`, 3) free control points [m].
        s: in 0..1.
    """
    piece = np.minimum((s * SPANS).astype(np.int64), SPANS - 1)
    t = s * SPANS - piece
    result = np.zeros((len(s), 3))
    rows = np.arange(len(s))
    for k, weight in enumerate(_weights(t)):
        point = piece + k - 3
        free = (point >= 0) & (point < POINTS)
        held = bend[rows, np.where(free, point, 0)]
        result += np.where(free, weight, 0.0)[:, None] * held
    return result


def _weights(t: Array) -> tuple[Array, Array, Array, Array]:
    """Return the weights of the four points around parts `t` of their pieces."""
    u = 1.0 - t
    return (
        u * u * u / 6.0,
        (4.0 + t * t * (3.0 * t - 6.0)) / 6.0,
        (4.0 + u * u * (3.0 * u - 6.0)) / 6.0,
        t * t * t / 6.0,
    )


def bend_through(values: Array) -> Array:
    """Return the bends (..., `POINTS`, 3) that follow values at the `KNOTS`.

    Exact for cubics; otherwise of fourth order, and within the two pieces at each end what
    the fixed points leave.

    Args:
        values: (..., `SPANS` + 1, 3) [m].
    """
    curved = values[..., :-2, :] - 2.0 * values[..., 1:-1, :] + values[..., 2:, :]
    result: Array = values[..., 2:-2, :] - curved[..., 1:-1, :] / 6.0
    return result
