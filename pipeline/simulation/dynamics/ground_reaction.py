"""Ground reaction: forces on standing feet that carry a given load.

Feet are points: they transmit forces, no moments, and push but do not pull. All standing feet
together give the whole force. They share it so as to give as much of the moment as possible, and
of all such shares the least (in the sum of squares). Feet that would have to pull are left out,
one by one. A single foot can only pass the force on. The remaining moment is what keeps a creature
from falling over without a cause in the scene: the less, the better balanced its motion.

Source: Winter 2009 (inverse dynamics from the ground up); Sims 1987, 7.3.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, cross, cross_matrix, turn

NEGLIGIBLE_LEVER = 1e-10
"""Squared lever, as a fraction of the greatest, that counts as zero."""


@dataclass(frozen=True, eq=False)
class GroundReaction:
    """Distribution of a load over feet.

    Attributes:
        forces: (K, F, 3) of the ground on the feet [N].
        force: (K, 3) remaining force, where no foot is down [N].
        moment: (K, 3) remaining moment [N m].
    """

    forces: Array
    force: Array
    moment: Array


def ground_reaction(
    points: Array, stands: NDArray[np.bool_], force: Array, moment: Array
) -> GroundReaction:
    """Returns how standing feet carry a load.

    Args:
        points: (K, F, 3) feet, relative to the point that the moment is about [m].
        stands: (K, F) which feet are down.
        force: (K, 3) load [N].
        moment: (K, 3) load [N m].
    """
    bears = stands.copy()
    forces = _shared_forces(points, bears, force, moment)
    # The mean vertical share equals that of the load, so one foot always remains.
    for _ in range(points.shape[1] - 1):
        pulls = np.where(bears, forces[..., 1], np.inf)
        worst = np.argmin(pulls, axis=1)
        rows = np.flatnonzero((pulls.min(axis=1) < 0.0) & (bears.sum(axis=1) > 1))
        if not len(rows):
            break
        bears[rows, worst[rows]] = False
        forces[rows] = _shared_forces(points[rows], bears[rows], force[rows], moment[rows])
    given = cross(points, forces).sum(axis=1)
    return GroundReaction(forces, force - forces.sum(axis=1), moment - given)


def _shared_forces(points: Array, bears: NDArray[np.bool_], force: Array, moment: Array) -> Array:
    """Returns the least forces (K, F, 3) of feet that give the force and best fit the moment."""
    K, F = bears.shape
    count = np.maximum(bears.sum(axis=1), 1)[:, None, None]
    even = bears[..., None] * force[:, None] / count
    # Differences of shares sum to zero: levers count from the mean of the feet.
    middle = (bears[..., None] * points).sum(axis=1, keepdims=True) / count
    levers = cross_matrix((points - middle) * bears[..., None])
    wide = levers.transpose(0, 2, 1, 3).reshape(K, 3, 3 * F)
    left = moment - cross(points, even).sum(axis=1)
    square = wide @ wide.transpose(0, 2, 1)
    inverse = np.asarray(
        np.linalg.pinv(square, rcond=NEGLIGIBLE_LEVER, hermitian=True), dtype=np.float64
    )
    return even + turn(wide.transpose(0, 2, 1), turn(inverse, left)).reshape(K, F, 3)
