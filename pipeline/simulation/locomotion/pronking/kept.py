"""Kept: moments of a herd that are kept for the take, and the poses worked out of them.

Poses are worked out for many moments at once, and sooner where a creature falls: limbs go on
from where they were.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.pronking.falling import Limbs
from pipeline.simulation.locomotion.pronking.posing import Moment, Poses, Posing
from pipeline.simulation.locomotion.pronking.state import Moved
from pipeline.simulation.spatial import Array

NEAR = 0.3
"""Part of a row that is too short a time to tell speeds from."""


class Kept:
    """What is kept of one herd.

    Attributes:
        posing: works out the poses.
        dt: time of a step [s].
    """

    def __init__(self, posing: Posing, dt: float) -> None:
        self.posing, self.dt = posing, dt
        self._waiting: list[Moment] = []
        self._posed: list[tuple[list[Moment], Poses]] = []
        # The last two moments, and all values that were written of them.
        self._last: list[tuple[Moment, Array]] = []

    def keep(self, moment: Moment) -> None:
        """Keep a moment as the next row."""
        self._waiting.append(moment)

    def taken(self) -> list[tuple[list[Moment], Poses]]:
        """Return what was kept since this was asked, in its order, with its poses."""
        self._pose()
        found, self._posed = self._posed, []
        return found

    def limbs(self, c: int, now: Moved, tips: Array, down: NDArray[np.bool_]) -> Limbs:
        """Return the joints of one creature, between two rows.

        Args:
            c: its number.
            now: its body.
            tips: (n, 3) its feet [m].
            down: (n,) which of them are on the ground.
        """
        self._pose()
        herd, columns = self.posing.herd, self._columns(c)
        skeleton = herd.figures[c].skeleton
        (before, earlier), (moment, last) = self._last[0], self._last[-1]
        q, speeds = last[columns], np.zeros(len(columns))
        row = (moment.step - before.step) * self.dt
        since = now.time - moment.step * self.dt
        if row > 0.0:
            speeds = (q - earlier[columns]) / row
        # Heads and tails go on; legs follow their feet.
        ahead = np.clip(q + since * speeds, skeleton.lower, skeleton.upper)
        joints = [j for limb in skeleton.legs for j in limb.joints]
        ahead[joints] = self._legs(c, moment, now, tips, down)
        if since > NEAR * row > 0.0:
            speeds[joints] = ((ahead - q) / since)[joints]
        return Limbs(ahead, speeds)

    def _legs(
        self, c: int, moment: Moment, now: Moved, tips: Array, down: NDArray[np.bool_]
    ) -> Array:
        """Return the values of the leg joints of one creature, one after the other [rad or m]."""
        herd = self.posing.herd
        own = herd.owner == c
        R, p, feet = moment.R.copy(), moment.p.copy(), moment.tips.copy()
        on = moment.down.copy()
        R[c], p[c], feet[own], on[own] = now.R, now.origin, tips, down
        q = self.posing.legs(replace(moment, R=R, p=p, tips=feet, down=on))
        result: Array = q[own][herd.legs.is_joint[own]]
        return result

    def _columns(self, c: int) -> NDArray[np.int64]:
        """Return where the joints (J,) of a creature are among all values of a row."""
        herd, idlers = self.posing.herd, self.posing.idlers
        skeleton, is_joint = herd.figures[c].skeleton, herd.legs.is_joint
        columns = np.empty(len(skeleton.joint_names), dtype=np.int64)
        legs = [j for limb in skeleton.legs for j in limb.joints]
        first = 2 * len(herd.names) + int(is_joint[herd.owner < c].sum())
        columns[legs] = np.arange(first, first + len(legs))
        idle = np.flatnonzero(idlers.owner == c)
        columns[idlers.number[idle]] = 2 * len(herd.names) + int(is_joint.sum()) + idle
        return columns

    def _pose(self) -> None:
        if not self._waiting:
            return
        times = np.array([moment.step for moment in self._waiting]) * self.dt
        poses = self.posing.poses(self._waiting, times)
        self._posed.append((self._waiting, poses))
        self._last += zip(self._waiting, poses.values, strict=True)
        self._last, self._waiting = self._last[-2:], []
