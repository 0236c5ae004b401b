"""Footing: the ground that each creature can stand on, and the surface that it makes.

Ground counts for a creature if a foot may be put there and its legs lead there from where
it starts: not the floor of a pit, nor what lies beyond a cliff. Its body follows this
ground alone, and its feet are put on no other, so the two never part.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.simulation.terrain.islands import Islands
from pipeline.simulation.terrain.support_surface import Support, Supports

RISE, GAP = 0.4, 1.0
"""Greatest rise and widest gap between two footholds, in leg lengths."""

BLUR = {"across": 0.4, "along": 0.25, "leg": 0.12, "stride": 0.12}
"""Least standard deviation of the average: in half extents of the feet at rest, in lengths
of a leg and of a stride. A body as quick as it is wide feels no single stone."""

CLEARS = 0.15
"""How much higher than its body stands a creature can lift its belly, in leg lengths."""

WIDE = 0.4
"""Half the width of what must pass above the ground, in half the width between feet."""


class SupportSurface:
    """What the creatures of a herd can stand on.

    Attributes:
        herd: the creatures.
        ground: what they go over.
    """

    def __init__(self, herd: Herd, ground: Ground) -> None:
        self.ground = ground
        self.herd = herd
        count = len(herd.names)
        islands = Islands(ground)
        reached = dict[bytes, NDArray[np.bool_]]()
        made = dict[tuple[bytes, float, float, float], int]()
        self._counts = list[NDArray[np.bool_]]()
        self._supports = list[Support]()
        self._which = np.zeros(count, dtype=np.int64)
        for c in range(count):
            lengths = herd.legs.lengths[herd.owner == c]
            leg = float(lengths.mean()) if len(lengths) else float(herd.footprint[c].max())
            around = float(np.hypot(*herd.footprint[c]))
            free = islands.reached(herd.starts[c], around, GAP * leg, RISE * leg)
            name = free.tobytes()
            blur = max(
                BLUR["across"] * float(herd.footprint[c, 1]),
                BLUR["along"] * float(herd.footprint[c, 0]),
                BLUR["leg"] * leg,
                BLUR["stride"] * float(herd.stride[c]),
            )
            room = float(herd.body_height[c] - herd.belly[c]) + CLEARS * leg
            key = (name, blur, self.wide(c), room)
            if key not in made:
                made[key] = len(self._supports)
                self._counts.append(reached.setdefault(name, free))
                self._supports.append(Support.of(ground, self._counts[-1], *key[1:]))
            self._which[c] = made[key]
        self._together = Supports(self._supports) if self._supports else None

    def wide(self, c: int) -> float:
        """Return half the width of what must pass above the ground [m]."""
        return WIDE * float(self.herd.footprint[c, 1])

    def is_level(self, c: int) -> bool:
        """Tell whether all the ground is level for a creature, and can be stood on."""
        return self._of(c).is_level

    def barred(self, c: int, x: Array, z: Array) -> NDArray[np.bool_]:
        """Say where the ground is too high for a creature's belly."""
        return self._of(c).barred(x, z)

    def has_walls(self, c: int) -> bool:
        """Tell whether anything on the ground is a wall for a creature."""
        return self._of(c).has_walls

    def _of(self, c: int) -> Support:
        return self._supports[int(self._which[c])]

    def allows(self, c: int, x: Array, z: Array) -> NDArray[np.bool_]:
        """Say where creature `c` may put a foot; outside the grid it may not."""
        field = self.ground.field
        counts = self._counts[self._which[c]]
        result: NDArray[np.bool_] = field.inside(x, z) & counts[field.cell_of(x, z)]
        return result

    def allows_each(self, creature: NDArray[np.int64], x: Array, z: Array) -> NDArray[np.bool_]:
        """Say whether each of creatures (N,) may put a foot at its place x, z (N,)."""
        field, which = self.ground.field, self._which[creature]
        result, (row, column) = field.inside(x, z), field.cell_of(x, z)
        for k in set(which.tolist()):
            own = which == k
            result[own] &= self._counts[k][row[own], column[own]]
        return result

    def surface(self, creature: NDArray[np.int64], x: Array, z: Array) -> tuple[Array, Array]:
        """Return the surface that bodies follow, and how far anything rises above it.

        Args:
            creature: (N,) whose body.
            x: (N, m) and
            z: (N, m) places [m].

        Returns:
            Heights and rises, (N, m) each [m].
        """
        if self._together is None:
            return np.zeros(x.shape), np.zeros(x.shape)
        return self._together.at(self._which[creature], x, z)
