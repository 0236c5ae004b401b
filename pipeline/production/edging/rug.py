"""Rug: a woven field with a border, a medallion and motifs, a bound edge and fringes."""

from __future__ import annotations

import numpy as np

from pipeline.production.edging.carpentry import Carpentry
from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.simulation.spatial import Array

FIELDS = (("rug red", "rug blue"), ("rug blue", "rug red"), ("rug red", "rug green"))
"""Materials of the border and of the field, for each rug."""

BEGINS = (0.0, 0.16, 0.29, 0.33)
"""Where its bands begin, from the border to the middle [m]."""

MOTIF = 0.22
"""Distance between the diamonds along the border, about [m]."""

LATTICE = 0.46
"""Distance between the small motifs of the field, about [m]."""

HEIGHT = 0.0025
"""Height over the floor: what stands on the rug sinks in as far [m]."""

CORD = 0.013
"""Thickness of the bound edge [m]."""

FRINGE, THREAD = 0.085, 0.014
"""Length of a fringe, and distance from tuft to tuft [m]."""


def rug(plan: FloorPlan, carpentry: Carpentry, seed: int) -> None:
    """Add a rug under the cast on a floor."""
    low, high = plan.clearings.extent
    middle, half = 0.5 * (low + high), 0.5 * (high - low) + 0.75
    half = np.minimum(half, np.minimum(plan.high - middle, middle - plan.low) - 0.5)
    if (half < 0.4).any():
        return
    outer, field = FIELDS[seed % len(FIELDS)]
    for k, cloth in enumerate((outer, "rug cream", outer, field)):
        size = 2.0 * (half - BEGINS[k])
        up = plan.height + HEIGHT * (k + 1) / len(BEGINS) - 0.005
        center = np.array([middle[0], up, middle[1]])
        carpentry.add(f"edging {cloth}", center, (size[0], 0.01, size[1]))
    _Motifs(plan.height, carpentry, outer, field).woven(middle, half - 0.42)
    _edge(plan.height, carpentry, middle, half, seed, outer)


def _edge(
    level: float, carpentry: Carpentry, middle: Array, half: Array, seed: int, cloth: str
) -> None:
    """Add the bound edge, and fringes at both ends of the longer sides."""
    rng = np.random.default_rng([seed, 487])
    long = int(half[1] > half[0])
    for axis in (0, 1):
        for side in (-1.0, 1.0):
            at = middle.copy()
            at[1 - axis] += side * half[1 - axis]
            size = [CORD, CORD, CORD]
            size[2 * axis] = 2.0 * half[axis] + CORD
            center = np.array([at[0], level + 0.3 * CORD, at[1]])
            carpentry.add(f"edging {cloth}", center, tuple(size))
    across = 1 - long
    count = int(2.0 * half[across] / THREAD)
    for side in (-1.0, 1.0):
        spots = np.zeros((count, 2))
        spots[:, across] = ((np.arange(count) + 0.5) / count * 2.0 - 1.0) * half[across]
        spots[:, long] = side * (half[long] + 0.5 * FRINGE)
        spots += middle
        points = np.stack([spots[:, 0], np.full(count, level + 0.003), spots[:, 1]], axis=-1)
        lengths = FRINGE * rng.uniform(0.75, 1.0, count)
        sizes = np.column_stack([lengths, np.full(count, 0.006), np.full(count, 0.008)])
        turned = (np.pi / 2 if long else 0.0) + rng.normal(0.0, 0.16, count)
        carpentry.add("edging rug cream", points, sizes, turned)


class _Motifs:
    """Adds diamonds within diamonds to a rug at a height [m] of two materials."""

    def __init__(self, level: float, carpentry: Carpentry, outer: str, field: str) -> None:
        self._level, self._carpentry = level, carpentry
        self._outer, self._field = outer, field

    def woven(self, middle: Array, half: Array) -> None:
        """Add a medallion, smaller ones in the corners, a lattice and a border of diamonds."""
        least, medallion = (
            float(half.min()),
            (self._outer, "rug gold", self._outer, "rug cream", self._field),
        )
        axis = int(half[1] > half[0])
        long = np.eye(2)[axis]
        self._lattice(middle, half, 0.95 * least)
        self._diamonds(middle[None], 0.62 * least, medallion)
        beside = middle + np.array([[-1.0], [1.0]]) * long * 0.78 * least
        if (np.abs(beside - middle) + 0.26 * least < half).all():
            self._diamonds(beside, 0.2 * least, medallion[2:])
        corners = middle + np.array([[i, j] for i in (-1, 1) for j in (-1, 1)]) * 0.8 * half
        self._diamonds(corners, 0.16 * least, medallion[1:4])
        rim = []
        for k in (0, 1):
            count = max(round(2.0 * half[k] / MOTIF), 2)
            along = (np.arange(count + 1) / count - 0.5) * 2.0 * half[k]
            for side in (-1.0, 1.0):
                spots = np.zeros((count + 1, 2))
                spots[:, k], spots[:, 1 - k] = along, side * (half[1 - k] + 0.2)
                rim.append(middle + spots)
        self._diamonds(np.concatenate(rim), 0.055, (self._field, "rug gold"))

    def _lattice(self, middle: Array, half: Array, clear: float) -> None:
        """Add small motifs all over the field but for its middle."""
        counts = np.maximum((half / LATTICE).astype(int), 1)
        x, z = (np.arange(-n, n + 1) * LATTICE for n in counts)
        spots = np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2)
        odd = (np.rint(spots / LATTICE).sum(axis=1) % 2) == 0
        inside = (np.abs(spots) < half - 0.12).all(axis=1) & (np.abs(spots).sum(axis=1) > clear)
        inside &= (np.abs(np.abs(spots) - 0.8 * half).sum(axis=1)) > 0.22 * float(half.min())
        self._diamonds(middle + spots[inside & odd], 0.062, ("rug gold", self._outer))
        self._diamonds(middle + spots[inside & ~odd], 0.036, ("rug cream",))

    def _diamonds(self, spots: Array, half: float, cloths: tuple[str, ...]) -> None:
        """Add diamonds at places (N, 2), the largest half as wide as `half` [m]."""
        if not len(spots):
            return
        for k, cloth in enumerate(cloths):
            up = self._level + HEIGHT + 0.00025 * (k + 1) - 0.005
            centers = np.stack([spots[:, 0], np.full(len(spots), up), spots[:, 1]], axis=-1)
            wide = np.sqrt(2.0) * half * (1.0 - k / len(cloths)) ** 1.2
            self._carpentry.add(f"edging {cloth}", centers, (wide, 0.01, wide), np.pi / 4)
