"""Convex distance: the nearest points of two convex hulls, and the distance between them."""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from pipeline.simulation.spatial import Array

PENALTY = 1e3
"""Weight of the condition that coefficients of a convex combination add up to 1."""


def nearest_points(a: Array, b: Array) -> tuple[Array, Array]:
    """Returns the nearest points (3,) of the convex hulls of points (n, 3) and (m, 3) [m].

    The nearest points are convex combinations: least squares with coefficients that are not
    negative, and a penalty that makes them add up to 1.
    """
    middle = a.mean(axis=0)
    coordinates = np.hstack([(a - middle).T, -(b - middle).T])
    scale = max(float(np.abs(coordinates).max()), 1e-9)
    sums = np.zeros((2, len(a) + len(b)))
    sums[0, : len(a)] = sums[1, len(a) :] = PENALTY * scale
    target = np.array([0.0, 0.0, 0.0, PENALTY * scale, PENALTY * scale])
    weights, _ = nnls(np.vstack([coordinates, sums]), target)
    own, others = weights[: len(a)], weights[len(a) :]
    return own @ a / own.sum(), others @ b / others.sum()


def convex_distance(a: Array, b: Array) -> float:
    """Returns the distance between the convex hulls of points (n, 3) and (m, 3) [m]."""
    one, other = nearest_points(a, b)
    return float(np.linalg.norm(one - other))


def box_distance(a: Array, b: Array) -> float:
    """Returns the distance between the bounding boxes of points (n, 3) and (m, 3) [m]."""
    gaps = np.maximum(b.min(axis=0) - a.max(axis=0), a.min(axis=0) - b.max(axis=0))
    return float(np.linalg.norm(np.maximum(gaps, 0.0)))
