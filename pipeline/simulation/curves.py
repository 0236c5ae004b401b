"""Curves: smooth steps, bumps, rounded corners and cyclic splines."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.spatial import Array


def ease(s: Array) -> Array:
    """Maps 0..1 to 0..1 with zero speed and acceleration at both ends.

    The minimum-jerk path between two points at rest.

    Source: Flash and Hogan 1985.
    """
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


def bump(s: Array) -> Array:
    """Maps 0..1 to a smooth arch that rises from 0 to 1 at the middle and falls to 0.

    It rises with the square of `s` where `ease` rises with its cube, so a foot that follows both
    leaves the ground upward before it moves forward.
    """
    return 16.0 * s * s * (1.0 - s) * (1.0 - s)


def hinge(x: Array, width: Array | float) -> Array:
    """Returns max(x, 0) with its corner rounded over ±`width`; never less than max(x, 0).

    The derivative stays continuous where a bound begins to act.
    """
    rounded = (x + width) ** 2 / (4.0 * width)
    return np.where(x <= -width, 0.0, np.where(x >= width, x, rounded))


def hermite(a: Array, b: Array, t_a: Array, t_b: Array, u: Array) -> Array:
    """Evaluates the cubic from `a` with tangent `t_a` to `b` with tangent `t_b`.

    Args:
        a: (..., m) where it begins.
        b: (..., m) where it ends.
        t_a: (..., m) derivative by `u` at the beginning.
        t_b: (..., m) derivative by `u` at the end.
        u: (..., 1) from 0 to 1.
    """
    result: Array = a + (b - a) * u * u * (3.0 - 2.0 * u)
    return result + u * (1.0 - u) * ((1.0 - u) * t_a - u * t_b)


def cyclic(values: Array, phase: Array | float) -> Array:
    """Evaluates a closed cubic spline through equally spaced `values` at `phase`.

    Args:
        values: (n,) values at phases 0, 1/n, 2/n, ...
        phase: any shape; wraps with period 1.

    Returns:
        The shape of `phase`; passes through `values` with continuous speed.

    Source: Catmull and Rom 1974; the cyclic spline of Sims 1987, 10.1.
    """
    n = len(values)
    position = np.mod(phase, 1.0) * n
    i = np.floor(position).astype(int) % n
    t = position - np.floor(position)
    a, b, c, d = (values[(i + k) % n] for k in (-1, 0, 1, 2))
    return b + 0.5 * t * ((c - a) + t * ((2 * a - 5 * b + 4 * c - d) + t * (3 * (b - c) + d - a)))


def bounded(x: Array) -> Array:
    """Returns x / (1 + x⁴)^(1/4): about x near 0, and never beyond ±1."""
    return x / np.sqrt(np.sqrt(1.0 + (x * x) * (x * x)))
