"""Scuffing: feet that drag over the ground while they swing, or slide as they come down.

A swing is planned as a whole when the foot lifts, so where it will scuff is known then.
It does so once a swing at most, where it rubs most: a foot is heard as it scrapes along,
not at every grain that it meets.

Source: Sims 1987, 13.1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.footing.footholds import Foothold
from pipeline.simulation.locomotion.gaits.paces import Step
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.swings.swing import swing
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

LOW = 0.015
"""A sole nearer to the ground than this part of its leg brushes over it."""

QUICK = 0.5
"""Slower than this along the ground nothing is heard, in lengths of the leg [1/s]."""

SHUFFLES = 0.1
"""Feet that step higher than this part of their legs do not scuff.

`lift_to_clear` leaves at least 0.4 of the step under the arch, whose height is 0.56 of its
top where the middle of a swing begins: 0.022 of the leg, more than `LOW` on slopes that can
be stepped on.
"""

MIDDLE = np.linspace(0.25, 0.75, 65)
"""Parts of a swing in which it scuffs; at its ends every foot is near the ground."""

LAST = np.array([0.999, 1.0])
"""The end of a swing: how fast it goes there is how fast the foot comes down."""

WEIGHT = 0.1
"""Part of a leg that its foot drags along as it scuffs, at most."""


@dataclass(frozen=True, eq=False)
class Scuff:
    """A foot that rubs over the ground.

    Attributes:
        part: of the swing at which it does so.
        place: (3,) on the ground [m].
        normal: (3,) of the ground there.
        way: how far it goes along the ground, per whole swing [m].
        weight: part of its leg that drags.
    """

    part: float
    place: Array
    normal: Array
    way: float
    weight: float


def brushed(ground: Ground, tips: Array, parts: Array, sole: float, low: float) -> Scuff | None:
    """Return where a foot scuffs the most, None if it is never as low as that.

    Args:
        ground: what it goes over.
        tips: (n, 3) places of its tip [m].
        parts: (n,) of its swing at which it is there.
        sole: radius of the tip [m].
        low: how near to the ground the sole has to come [m].
    """
    x, z = tips[:, 0], tips[:, 2]
    height, normals = ground.surface(x, z)
    depth = low - ((tips[:, 1] - height) * normals[:, 1] - sole)
    if (depth <= 0.0).all():
        return None
    way = _along(np.gradient(tips, parts, axis=0), normals)
    rubbed = depth * way
    # On level ground it rubs alike before and after the top; rounding is not to choose.
    worst = int(np.argmax(rubbed >= (1.0 - 1e-6) * rubbed.max()))
    place = np.array([x[worst], height[worst], z[worst]])
    weight = WEIGHT * min(float(depth[worst]) / low, 1.0)
    return Scuff(float(parts[worst]), place, normals[worst], float(way[worst]), weight)


def slid(tips: Array, parts: Array, place: Array, normal: Array) -> Scuff:
    """Return how a foot scuffs as it comes down.

    Args:
        tips: (2, 3) places of its tip at the end of its swing [m].
        parts: (2,) of the swing at which it is there.
        place: (3,) where it comes down [m].
        normal: (3,) of the ground there.
    """
    way = _along(np.diff(tips, axis=0) / np.diff(parts), normal)
    return Scuff(1.0, place, normal, float(way[0]), WEIGHT)


def _along(v: Array, normals: Array) -> Array:
    """Return the lengths (n,) of vectors (n, 3) along a surface."""
    across = (v * normals).sum(axis=-1, keepdims=True)
    result: Array = np.linalg.norm(v - across * normals, axis=-1)
    return result


class Scuffing:
    """The scuffs of a herd.

    Attributes of the state:
        at: (L,) phase at which the swing of each leg scuffs, infinite if it does not.
        span: (L,) how long the swing of each leg lasts, in cycles.
    """

    def __init__(self, herd: Herd, ground: Ground) -> None:
        self.herd = herd
        self.ground = ground
        self.at = np.full(len(herd.owner), np.inf)
        self.span = herd.swings.copy()
        self._planned: dict[int, Scuff] = {}
        # Swings are linear in their ways and heights, and plain ones come to rest.
        step, still = np.array([1.0, 0.0, 0.0]), np.zeros(3)
        ends = (
            _way(still, step, 0.0, LAST, None),
            _way(still, still, 1.0, LAST, None),
        )
        speeds = [np.linalg.norm(np.diff(tips, axis=0)) / np.diff(LAST)[0] for tips in ends]
        self._slides = float(max(speeds))

    def plan(
        self,
        leg: int,
        step: Step,
        start: Array,
        end: Array,
        heights: tuple[float, float],
        bend: Array | None = None,
    ) -> None:
        """Find out where a swing will scuff.

        Args:
            leg: which.
            step: when it swings.
            start: (3,) tip at lifting [m].
            end: (3,) tip at coming down [m].
            heights: of the arch, and of that on level ground [m].
            bend: what the swing has beside the arch.
        """
        self.at[leg], self.span[leg] = np.inf, step.swing
        height, level = heights
        if level >= SHUFFLES * self.herd.legs.lengths[leg]:
            return
        herd = self.herd
        tips = _way(start, end, height, MIDDLE, bend)
        low = LOW * float(herd.legs.lengths[leg])
        scuff = brushed(self.ground, tips, MIDDLE, float(herd.sole[leg]), low)
        if scuff is not None:
            self._planned[leg] = scuff
            self.at[leg] = step.up + scuff.part * step.swing

    def due(self, before: Array, phase: Array) -> NDArray[np.int64]:
        """Return the legs that scuff after their phases were `before` (L,), up to `phase` (L,)."""
        return np.flatnonzero((self.at > before) & (self.at <= phase))

    def heard(self, leg: int, rate: float) -> tuple[Scuff, float] | None:
        """Return the scuff planned for a leg and its speed [m/s], None if it is too slow.

        Args:
            leg: which.
            rate: of the phase, in cycles a second.
        """
        return self._loud(leg, self._planned[leg], rate)

    def landing(
        self,
        leg: int,
        start: Array,
        hold: Foothold,
        height: float,
        rate: float,
        bend: Array | None = None,
    ) -> tuple[Scuff, float] | None:
        """Return how a leg that comes down scuffs and its speed [m/s].

        Args:
            leg: which.
            start: (3,) tip at lifting [m].
            hold: where it comes down.
            height: of the arch [m].
            rate: of the phase, in cycles a second.
            bend: what the swing has beside the arch.

        Returns:
            None if it is too slow, or has scuffed in this swing already.
        """
        most = self._slides * (math.dist(start, hold.tip) + height)
        if np.isfinite(self.at[leg]) or not self._is_loud(leg, most, rate):
            return None
        tips = _way(start, hold.tip, height, LAST, bend)
        return self._loud(leg, slid(tips, LAST, hold.place, hold.normal), rate)

    def _loud(self, leg: int, scuff: Scuff, rate: float) -> tuple[Scuff, float] | None:
        speed = scuff.way * rate / float(self.span[leg])
        return (scuff, speed) if self._is_loud(leg, scuff.way, rate) else None

    def _is_loud(self, leg: int, way: float, rate: float) -> bool:
        return bool(way * rate >= QUICK * self.herd.legs.lengths[leg] * self.span[leg])


def _way(start: Array, end: Array, height: float, parts: Array, bend: Array | None) -> Array:
    """Return the tips (n, 3) of one foot at parts (n,) of its swing [m]."""
    n = len(parts)
    bends = None if bend is None else np.broadcast_to(bend, (n, *bend.shape))
    return swing(start, end, height, parts, bends)
