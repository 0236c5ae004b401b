"""Footholds: where a foot is put next.

    1. The place where the foot would rest in the middle of its next stance.
    2. If that is forbidden or out of reach, the farthest good place that is nearer.
    3. If there is none, the good place nearest to the wished one on any side of it.

Sims 1987, 10.2, steps 1 and 2. The thesis leaves reach to chance; here it is checked at
the begin, the middle and the end of the stance, first as the body wants to go, then
with the body as low as it may be.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.body_path import BodyPath
from pipeline.simulation.locomotion.herd import REACH, Herd
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.terrain import Ground

NEARER = np.linspace(1.0, 0.0, 49)
"""Places looked at between the wished foothold and the present one."""

RINGS, SPOKES = 24, 16
"""Places looked at around a wished foothold."""

AROUND = 0.4
"""How far around it, as a part of the leg's length."""

STOOP = 0.45
"""How far a body may be lowered so that its feet reach, as a part of its height."""


class Footholds:
    """Plans footholds for the legs of a herd."""

    def __init__(self, herd: Herd, ground: Ground, path: BodyPath) -> None:
        self.herd = herd
        self.ground = ground
        self.path = path

    def next(self, leg: int, present: Array, travelled: float, phase: float) -> Array | None:
        """Return where the tip of `leg`, about to lift, is to come down.

        Args:
            leg: which.
            present: (3,) where its tip is [m].
            travelled: way that the body has gone [m].
            phase: of the gait at lifting, whole cycles counted.

        Returns:
            (3,) place of the tip [m], or None if there is no foothold between the wished
            one and the present one.
        """
        swing, stance = self._times(leg)
        moments = phase + swing + stance * np.array([0.0, 0.5, 1.0])
        R, p = self._bodies(leg, travelled, phase, moments)
        wished = (p[1] + turn(R[1], self._rest(leg)))[[0, 2]]
        here = present[[0, 2]]
        line = here + NEARER[:, None] * (wished - here)
        for places in (line, self._around(leg, wished)):
            best = self._best(leg, places, R, p)
            if best is not None:
                return best
        return None

    def first(self, leg: int, phase: float) -> Array | None:
        """Return where `leg` stands at the start: the good place nearest to where it would.

        Args:
            leg: which.
            phase: its gait's phase from which its foot has been down, at most 0.
        """
        _, stance = self._times(leg)
        moments = phase + stance * np.array([0.0, 0.5, 1.0])
        R, p = self._bodies(leg, 0.0, 0.0, moments)
        wished = (p[1] + turn(R[1], self._rest(leg)))[[0, 2]]
        return self._best(leg, self._around(leg, wished), R, p)

    def _around(self, leg: int, middle: Array) -> Array:
        """Return places (n, 2) on rings around `middle`, the nearest first [m]."""
        angle = np.arange(SPOKES) * (2.0 * np.pi / SPOKES)
        spokes = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        radii = np.linspace(0.0, AROUND * self.herd.legs.lengths[leg], RINGS)
        result: Array = middle + (radii[:, None, None] * spokes).reshape(-1, 2)
        return result

    def _best(self, leg: int, xz: Array, R: Array, p: Array) -> Array | None:
        """Return the tip (3,) on the first good one of the places `xz` (n, 2), if there is one.

        Args:
            leg: which.
            xz: places, the best first [m].
            R: (m, 3, 3) and
            p: (m, 3), poses of the body during the stance [m].
        """
        tips = self.stand(leg, xz)
        safe = self.ground.steppable(xz[:, 0], xz[:, 1])
        height = self.herd.body_height[self.herd.owner[leg]]
        for stoop in (0.0, STOOP * height):
            good = safe & self._reached(leg, tips, R, p - [0.0, stoop, 0.0])
            if good.any():
                best: Array = tips[int(np.argmax(good))]
                return best
        return None

    def stand(self, leg: int, xz: Array) -> Array:
        """Return the places (n, 3) of a tip whose sole touches the ground at `xz` (n, 2) [m]."""
        x, z = xz[:, 0], xz[:, 1]
        ground = np.stack([x, self.ground.height(x, z), z], axis=-1)
        sole = float(self.herd.sole[leg])
        return ground + sole * self.ground.normal(x, z)

    def _times(self, leg: int) -> tuple[float, float]:
        """Return the parts of a cycle that a leg swings and stands."""
        swing = float(np.mod(self.herd.down[leg] - self.herd.up[leg], 1.0))
        return swing, 1.0 - swing

    def _rest(self, leg: int) -> Array:
        x, z = self.herd.rest[leg]
        height = self.herd.body_height[self.herd.owner[leg]]
        rest: Array = np.array([float(x), -float(height), float(z)])
        return rest

    def _bodies(
        self, leg: int, travelled: float, phase: float, moments: Array
    ) -> tuple[Array, Array]:
        """Return the poses of the leg's body at phases `moments` if it goes on as it goes."""
        owner = self.herd.owner[leg]
        creature = np.full(len(moments), owner)
        way = travelled + (moments - phase) * self.herd.stride[owner]
        return self.path.pose(creature, way, moments)

    def _reached(self, leg: int, tips: Array, R: Array, p: Array) -> NDArray[np.bool_]:
        """Say which of `tips` (n, 3) the leg reaches from all bodies (m, ...)."""
        hips = p + turn(R, self.herd.hips[leg])
        distance = np.linalg.norm(tips[:, None] - hips, axis=-1).max(axis=1)
        result: NDArray[np.bool_] = distance <= REACH * self.herd.legs.lengths[leg]
        return result
