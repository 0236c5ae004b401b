"""Refuges: where feet in the air go that are in the ground and cannot be lifted straight out.

Below a low body knees fold only so far, beside a wall there is no room above: then the leg is
looked for another place, out of the ground and near to where it was to be.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.figures.settling import brought
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.swing.swing_trajectory import lowest_center_height
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

MISSES = 1e-4
"""Distance of a foot from a place that it does not come to [m]."""

CLEAR = 2e-4
"""Height above the ground of a foot that is out of it, at least [m]."""

BANDS, AROUND = 9, 16
"""Directions in which a leg is looked for, from up to down and round the hip."""

STRETCHES = (0.97, 0.85, 0.7, 0.55, 0.4, 0.28)
"""How far it is stretched there, in its length; not farther than it folds."""


def refuge(
    herd: Herd, ground: Ground, R: Array, p: Array, leg: int, goal: Array, fold: float
) -> Array | None:
    """Return a place (3,) for a foot in the frame of its body, None if there is no better one [m].

    Args:
        herd: that the leg belongs to.
        ground: that the foot is to be out of.
        R: (3, 3) and
        p: (3,) of the body [m].
        leg: its number in the herd.
        goal: (3,) where the foot was to be, in the frame of the body [m].
        fold: least distance from hip to foot [m].
    """
    hip, length = herd.hips[leg], float(herd.legs.lengths[leg])
    far = np.array([k * length for k in STRETCHES if k * length > fold] + [1.02 * fold])
    places = hip + (far[:, None, None] * _directions()).reshape(-1, 3)
    places = places[np.argsort(((places - goal) ** 2).sum(axis=-1), kind="stable")]
    feet = places @ R.T + p
    least = lowest_center_height(ground, feet[:, 0], feet[:, 2], herd.sole[leg])
    places = places[feet[:, 1] >= least + CLEAR]
    legs = np.full(len(places), leg)
    _, gap = brought(herd.legs, herd.chains, legs, places)
    good: NDArray[np.int64] = np.flatnonzero(gap <= MISSES)
    return places[good[0]] if len(good) else None


def _directions() -> Array:
    """Return unit vectors (k, 3) all around."""
    y = np.linspace(-1.0, 1.0, BANDS)
    angle = np.arange(AROUND) * (2.0 * math.pi / AROUND)
    r = np.sqrt(1.0 - y * y)[:, None]
    level = np.broadcast_to(y[:, None], (BANDS, AROUND))
    result: Array = np.stack([r * np.cos(angle), level, r * np.sin(angle)], axis=-1)
    return result.reshape(-1, 3)
