"""Folds: how near to its hip each leg can draw its foot.

Knees fold only so far. The limits of joints say so by inverse kinematics alone, which is
asked once for each leg, along the way from its hip to where its foot rests.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.rest_ik import solve_near_rest
from pipeline.simulation.locomotion.herd import REACH, Herd
from pipeline.simulation.spatial import Array

DISTANCES = np.linspace(REACH, 0.1, 30)
"""At which it is asked, in lengths of the leg."""

MISSES = 1e-4
"""Distance of tip from place that is none, in the leg's length."""


def folds_of(herd: Herd) -> Array:
    """Return the least distances (L,) from hips to feet at which all farther ones are reached [m].

    Args:
        herd: whose legs.
    """
    found, known = np.zeros(len(herd.owner)), dict[tuple[str, float, float], Array]()
    for c, figure in enumerate(herd.figures):
        own = np.flatnonzero(herd.owner == c)
        key = figure.name, figure.scale, float(herd.body_height[c])
        if len(own):
            found[own] = known[key] = known[key] if key in known else _folds(herd, own)
    return found


def _folds(herd: Herd, own: NDArray[np.int64]) -> Array:
    """Return the folds of some legs (n,) [m]."""
    legs, (x, z) = herd.legs.rows(own), herd.rest[own].T
    way = np.stack([x, -herd.body_height[herd.owner[own]], z], axis=-1) - herd.hips[own]
    at_rest = np.linalg.norm(way, axis=-1)
    way /= np.maximum(at_rest, 1e-9)[:, None]
    goals = herd.hips[own] + (DISTANCES[:, None] * legs.lengths)[..., None] * way
    residual = solve_near_rest(legs, group_chains(legs, herd.owner[own]), goals).residual
    # Where a foot rests it is, whatever limits stretched legs come to.
    nearer = DISTANCES[:, None] * legs.lengths < at_rest
    missed = nearer & (residual > MISSES * legs.lengths)
    # The last one before the first that is missed; those that miss none fold up wholly.
    first = np.where(missed.any(axis=0), missed.argmax(axis=0), len(DISTANCES))
    result: Array = DISTANCES[np.maximum(first - 1, 0)] * legs.lengths
    return result
