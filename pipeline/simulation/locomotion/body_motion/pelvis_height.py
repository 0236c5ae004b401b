"""Yielding: how bodies give way to legs that would be folded or stretched too far.

That is what no plan foresaw: a body is raised where a leg would fold up too far, and lowered
where one would be overstretched. One that falls is caught as a foot touches: while it is in
the air a foot that reaches ahead does not draw it down, for it comes down by itself; by as
much as the leg is stretched at the touch the body is low, a while before and a while after.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease, hinge
from pipeline.simulation.locomotion.foot_placement.leg_reachability import shortest_reaches
from pipeline.simulation.locomotion.gaits.spread import MAX_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.spatial import Array, turn

ROUNDED = 0.02
"""Stretch or fold over which bodies begin to give way, in leg lengths."""


@dataclass(frozen=True, eq=False)
class Going:
    """How bodies go at n moments, all (n, C); see `BodyPath.pose`.

    Attributes:
        way: gone [m].
        phase: of the gait, whole cycles counted.
        drive, vigour: parts of their speed.
        nose_up: [rad].
        planned: heights that their path gives them [m].
    """

    way: Array
    phase: Array
    drive: Array
    vigour: Array
    nose_up: Array
    planned: Array


@dataclass(frozen=True, eq=False)
class Touches:
    """The last foot-down of each leg, or the next one of a foot in the air, all (n, L).

    Attributes:
        at: phase, whole cycles counted.
        around: how long before and after it the body is low for it, in cycles.
        place: (n, L, 3) tip then [m].
        stoop: how far the body was planned to be lowered then [m].
        swinging: which feet are in the air.
    """

    at: Array
    around: Array
    place: Array
    stoop: Array
    swinging: NDArray[np.bool_]


class Yielding:
    """The giving way of the bodies of a herd.

    Attributes:
        folds: (L,) how near to its hip each leg can draw its foot [m].
    """

    def __init__(self, herd: Herd, path: BodyTrajectory) -> None:
        self.herd = herd
        self.path = path
        self.folds = shortest_reaches(herd)

    def give_way(
        self,
        R_WB: Array,
        p_WB: Array,
        tips: Array,
        grips: tuple[Array, Array],
        going: Going,
        touches: Touches,
    ) -> None:
        """Raise and lower bodies as their legs need it.

        Args:
            R_WB: (n, C, 3, 3) and
            p_WB: (n, C, 3), poses of the bodies; places are changed [m].
            tips: (n, L, 3) of the legs [m].
            grips: (n, L) how far feet count as being on the ground, 0 to 1, and how far they
                would if they were.
            going: how bodies go.
            touches: of the feet.
        """
        herd, (grip, free) = self.herd, grips
        lengths = herd.legs.lengths
        hips = p_WB[:, herd.owner] + turn(R_WB[:, herd.owner], herd.hips)
        raised = _greatest(herd, grip * self._overfold(hips, tips))
        p_WB[..., 1] += raised
        hips[..., 1] += raised[:, herd.owner]
        stretch = grip * _overstretch(hips, tips, lengths)
        flies = self.path.paces.flies(herd.owner, going.phase[:, herd.owner])
        if flies.any():
            near = flies & (np.abs(going.phase[:, herd.owner] - touches.at) < touches.around)
            down = np.where(touches.swinging[near], 0.0, stretch[near])
            lowered = np.maximum(going.planned - p_WB[..., 1], 0.0)
            catch = free[near] * self._caught(near, going, touches, lowered)
            stretch[near] = np.maximum(down, catch)
        p_WB[..., 1] -= _greatest(herd, stretch)

    def _overfold(self, hips: Array, tips: Array) -> Array:
        """Return how much too low hips (n, L, 3) are for tips (n, L, 3) [m]."""
        across = ((tips - hips)[..., [0, 2]] ** 2).sum(axis=-1) / self.folds**2
        # Less towards the rim, so that nothing jumps where a foot comes under the hip.
        below = np.maximum(1.0 - across, 0.0) ** 2
        least = tips[..., 1] + self.folds * np.sqrt(below)
        result: Array = below * hinge(least - hips[..., 1], ROUNDED * self.herd.legs.lengths)
        return result

    def _caught(
        self, near: NDArray[np.bool_], going: Going, touches: Touches, lowered: Array
    ) -> Array:
        """Return by how much bodies have to be low for legs that touch (N,) [m].

        Args:
            near: (n, L) which legs are looked at, N in all.
            going: how their bodies go; they are taken to go so at the touch.
            touches: of the legs.
            lowered: (n, C) how far the bodies are below their path [m].
        """
        herd = self.herd
        row, leg = np.nonzero(near)
        c, at = herd.owner[leg], touches.at[near]
        here = going.phase[row, c]
        stride = self.path.paces.value("stride", c, here)
        way = going.way[row, c] + (at - here) * stride * np.sqrt(going.drive[row, c])
        R_WB, p_WB = self.path.pose(c, way, at, going.vigour[row, c], going.nose_up[row, c])
        hips = p_WB + turn(R_WB, herd.hips[leg])
        hips[:, 1] -= np.maximum(lowered[row, c], touches.stoop[near])
        stretch = _overstretch(hips, touches.place[near], herd.legs.lengths[leg])
        apart = np.abs(here - at) / touches.around[near]
        result: Array = stretch * (1.0 - ease(apart))
        return result


def _overstretch(hips: Array, tips: Array, lengths: Array) -> Array:
    """Return how much too high hips (..., 3) are for tips (..., 3) of legs this long [m]."""
    across = ((tips - hips)[..., [0, 2]] ** 2).sum(axis=-1)
    highest = tips[..., 1] + np.sqrt(np.maximum((MAX_REACH * lengths) ** 2 - across, 0.0))
    return hinge(hips[..., 1] - highest, ROUNDED * lengths)


def _greatest(herd: Herd, values: Array) -> Array:
    """Return the greatest (n, C) of the values (n, L) of each creature's legs."""
    result = np.zeros((len(values), len(herd.names)))
    for owners, legs in herd.tiers:
        result[:, owners] = np.maximum(result[:, owners], values[:, legs])
    return result
