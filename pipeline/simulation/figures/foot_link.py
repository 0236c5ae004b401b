"""Foot link: the last link of a leg, a hoof, paw or foot, held in a wanted direction.

The joint before it, the ankle, is put where the wanted direction has it, within the plane of the
leg, and the leg without that link reaches for the ankle as it would for a tip. Where the ankle
would be out of the leg's reach, the link turns as far as it has to: a heel rises when its leg is
stretched.

Notation: n axis across the leg, d direction of the link from the ankle to the tip.

Source: the geometry is elementary; Sims 1987, 6.3.1 for the leg without the link.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import hinge
from pipeline.simulation.figures.bend_path import BendPath
from pipeline.simulation.figures.joint_limits import FOOT_LENGTH
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.spatial import Array

FEWEST_JOINTS = 5
"""Of a leg with a foot: a ball joint, a knee and an ankle."""

ROUNDING = 0.06
"""Angle over which a foot gives way to the reach of its leg [rad]."""

MAX_STRETCH = 0.985
"""Greatest distance of an ankle from the base, in the longest."""


def has_foot(batch: LimbBatch) -> NDArray[np.bool_]:
    """Return which limbs (L,) with hanging legs have a foot, as far as their links tell."""
    counts = batch.is_joint.sum(axis=1)
    last = np.maximum(counts - 1, 0)
    rows = np.arange(len(counts))
    length = np.linalg.norm(batch.tips - batch.places[rows, last], axis=-1)
    turns = ~batch.prismatic[rows, last]
    result: NDArray[np.bool_] = (
        (counts >= FEWEST_JOINTS) & turns & (length < FOOT_LENGTH * batch.lengths)
    )
    return result


@dataclass(frozen=True, eq=False)
class FootLink:
    """Legs without their feet.

    Attributes:
        path: of the bends, by distance from base to ankle; for the joints before the ankle.
    """

    path: BendPath

    @staticmethod
    def of(batch: LimbBatch) -> FootLink:
        """Return the feet of limbs with as many joints each."""
        k = batch.is_joint.shape[1]
        ankle = batch.places[:, k - 1]
        links = np.diff(np.concatenate([batch.places[:, : k - 1], ankle[:, None]], axis=1), axis=1)
        lengths = np.linalg.norm(links, axis=-1).sum(axis=1)
        legs = replace(batch.first_joints(k - 1), tips=ankle, lengths=lengths)
        return FootLink(BendPath.of(legs))

    def direction(
        self, own: NDArray[np.int64], goal: Array, natural: Array, wanted: Array, n: Array
    ) -> Array:
        """Return the directions (3, l, m) that feet can have.

        Args:
            own: (l, 1) numbers of the limbs.
            goal: (3, l, m) of the tips, from the base [m].
            natural: (3, l, m) ways from ankle to tip that the legs would have by themselves [m].
            wanted: (3, l, m) directions; their lengths are the parts of the way to them, 0 to 1.
            n: (3, l, m) unit vectors across the legs.
        """
        length = _norm(natural)
        d = natural / length
        side = _cross(n, d)
        along, aside = _dot(wanted, d), _dot(wanted, side)
        # As much of the way as the wanted direction is long; none if it is zero.
        angle = _norm(wanted) * np.arctan2(aside, along)
        # The ankle is at goal - length * d, no farther than it reaches.
        x, y = _dot(goal, d), _dot(goal, side)
        far = np.maximum(np.sqrt(x * x + y * y), 1e-300)
        reach = MAX_STRETCH * self.path.longest[own]
        cosine = (_dot(goal, goal) + length * length - reach * reach) / (2.0 * length * far)
        middle, most = np.arctan2(y, x), np.arccos(np.clip(cosine, -1.0, 1.0))
        low, high = np.minimum(middle - most, 0.0), np.maximum(middle + most, 0.0)
        angle = high - hinge(high - angle, ROUNDING)
        angle = low + hinge(angle - low, ROUNDING)
        c, s = np.cos(angle), np.sin(angle)
        return c * d + s * side


def _norm(v: Array) -> Array:
    return np.sqrt(_dot(v, v))


def _dot(a: Array, b: Array) -> Array:
    result: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return result


def _cross(a: Array, b: Array) -> Array:
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
