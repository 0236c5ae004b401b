"""Support surface: the ground that each creature can stand on, smoothed for its body.

Ground supports a creature if a foot may be placed there and footholds lead there from its start:
neither the floor of a pit nor what lies beyond a cliff. Body and feet both use this ground only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.simulation.terrain.islands import Islands
from pipeline.simulation.terrain.smooth_ground import SmoothGround, SmoothGrounds

# Greatest rise and widest gap between two footholds, in leg lengths.
MAX_RISE, MAX_GAP = 0.4, 1.0

# Least standard deviation of the smoothing: in half extents of the feet at rest across and along,
# in leg lengths and in strides. A body does not follow single stones.
SMOOTHING = {"across": 0.4, "along": 0.25, "leg": 0.12, "stride": 0.12}

# Height above its standing height to which a creature can lift its belly, in leg lengths.
BELLY_LIFT = 0.15

# Half the width of the corridor that the belly needs, as a fraction of half the stance width.
CORRIDOR_WIDTH = 0.4


class SupportSurface:
    """The support surfaces of a herd; creatures with equal needs share one."""

    def __init__(self, herd: Herd, ground: Ground) -> None:
        self.herd, self.ground = herd, ground
        islands = Islands(ground)
        masks = dict[bytes, NDArray[np.bool_]]()
        numbers = dict[tuple[bytes, float, float, float], int]()
        self._masks = list[NDArray[np.bool_]]()
        self._supports = list[SmoothGround]()
        self._number = np.zeros(len(herd.names), dtype=np.int64)
        for c in range(len(herd.names)):
            lengths = herd.legs.lengths[herd.owner == c]
            leg = float(lengths.mean()) if len(lengths) else float(herd.footprint[c].max())
            around = float(np.hypot(*herd.footprint[c]))
            mask = islands.reached(herd.starts[c], around, MAX_GAP * leg, MAX_RISE * leg)
            name = mask.tobytes()
            blur = max(
                SMOOTHING["across"] * float(herd.footprint[c, 1]),
                SMOOTHING["along"] * float(herd.footprint[c, 0]),
                SMOOTHING["leg"] * leg,
                SMOOTHING["stride"] * float(herd.stride[c]),
            )
            room = float(herd.body_height[c] - herd.belly[c]) + BELLY_LIFT * leg
            key = (name, blur, CORRIDOR_WIDTH * float(herd.footprint[c, 1]), room)
            if key not in numbers:
                numbers[key] = len(self._supports)
                self._masks.append(masks.setdefault(name, mask))
                self._supports.append(SmoothGround.of(ground, self._masks[-1], *key[1:]))
            self._number[c] = numbers[key]
        self._all = SmoothGrounds(self._supports) if self._supports else None

    def of(self, c: int) -> SmoothGround:
        """Return the support surface of creature `c`."""
        return self._supports[int(self._number[c])]

    def is_allowed(self, creature: NDArray[np.int64], x: Array, z: Array) -> NDArray[np.bool_]:
        """Return whether creatures (N,) may place a foot at x, z (N,); never outside the grid."""
        field, number = self.ground.field, self._number[creature]
        result, (row, column) = field.inside(x, z), field.cell_of(x, z)
        for k in set(number.tolist()):
            own = number == k
            result[own] &= self._masks[k][row[own], column[own]]
        return result

    def heights(self, creature: NDArray[np.int64], x: Array, z: Array) -> tuple[Array, Array]:
        """Return the smoothed surface under bodies, and how far obstacles rise above it.

        Args:
            creature: (N,) numbers of the creatures.
            x: (N, m) and
            z: (N, m) places [m].

        Returns:
            Heights and rises, (N, m) each [m].
        """
        if self._all is None:
            return np.zeros(x.shape), np.zeros(x.shape)
        return self._all.at(self._number[creature], x, z)
