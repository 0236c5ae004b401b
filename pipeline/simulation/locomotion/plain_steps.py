"""Plain steps: what most feet do, planned for all that lift in one world step together.

A foot mostly comes down where it would rest in the middle of its stance, with its body no
lower than it goes anyway, by a swing that its leg does without being asked. Whether it may
is the same for many feet at once; those that may not are left to `Footholds`, which looks
farther, and finds the same where a plain step is good.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.footholds import (
    EASY_ARCH,
    EASY_WAY,
    LAGS,
    MOST_ARCH,
    PLANNED_REACH,
    STANCE,
    Foothold,
    Footholds,
)
from pipeline.simulation.locomotion.paces import Step
from pipeline.simulation.locomotion.route import Route
from pipeline.simulation.locomotion.sole import lowest
from pipeline.simulation.locomotion.swing import arches
from pipeline.simulation.spatial import Array, turn, unturn

MIDDLE = len(STANCE) // 2


@dataclass(frozen=True, eq=False)
class Lift:
    """A foot that is to stand somewhere else.

    Attributes:
        leg: whose.
        travelled: way that its body has gone at `phase` [m].
        phase: of the gait, whole cycles counted.
        step: when it swings and stands.
        drive: part of its speed at which the body goes.
        present: (3,) where its tip is; None for one that just stands there at the start [m].
    """

    leg: int
    travelled: float
    phase: float
    step: Step
    drive: float
    present: Array | None = None


class PlainSteps:
    """The plain steps of a herd.

    Attributes:
        footholds: where the others are put.
    """

    def __init__(self, footholds: Footholds) -> None:
        self.footholds = footholds
        self.herd = footholds.herd
        self.path = footholds.path
        self._found: dict[int, tuple[Foothold, Route]] = {}

    def foresee(self, lifts: Sequence[Lift]) -> None:
        """Plan all steps of `lifts` that are plain, and forget all others."""
        self._found.clear()
        owner = self.herd.owner
        # Who goes over into another pace is not plain.
        lifts = [one for one in lifts if int(owner[one.leg]) not in self.path.paces.changes]
        if lifts:
            for one, place in zip(lifts, self._planned(lifts), strict=True):
                if place is not None:
                    self._found[one.leg] = place, self.path.routes[int(owner[one.leg])]

    def of(self, leg: int) -> Foothold | None:
        """Return where a foot that was foreseen comes down by a plain step, if it does."""
        if leg not in self._found:
            return None
        place, route = self._found[leg]
        # Its creature may have been led elsewhere since.
        return place if route is self.path.routes[int(self.herd.owner[leg])] else None

    def _planned(self, lifts: Sequence[Lift]) -> list[Foothold | None]:
        legs = np.array([one.leg for one in lifts])
        R, p, xz = self._stances(legs, lifts)
        herd, ground = self.herd, self.footholds.ground
        lengths, sole = herd.legs.lengths[legs], herd.sole[legs]
        heights, normals = ground.surface(xz[:, 0], xz[:, 1])
        places = np.stack([xz[:, 0], heights, xz[:, 1]], axis=-1)
        tips = places + sole[:, None] * normals
        safe = self.path.footing.allows_each(herd.owner[legs], xz[:, 0], xz[:, 1])
        good = safe & self._upright(legs, tips, R, p)
        held = np.flatnonzero(good)
        goals = unturn(R[held], tips[held, None] - p[held])
        good[held] = self.footholds.grasp.holds_each(legs[held], goals)
        tips[:, 1] = np.maximum(tips[:, 1], lowest(ground, tips[:, 0], tips[:, 2], sole))
        swings = np.array([one.present is not None for one in lifts])
        start = np.array(
            [tips[i] if one.present is None else one.present for i, one in enumerate(lifts)]
        )
        least, stride = herd.step_height[legs], herd.stride[herd.owner[legs]]
        arch = np.where(swings, 0.0, -np.inf)
        which = np.flatnonzero(good & swings)
        arch[which] = arches(ground, start[which], tips[which], sole[which], least[which])
        across = tips - start
        plain = (arch < EASY_ARCH * least) & (np.abs(across[:, 1]) < least)
        plain &= arch <= MOST_ARCH * lengths
        plain &= np.hypot(across[:, 0], across[:, 2]) <= EASY_WAY * stride
        good &= plain
        return [
            Foothold(places[i], normals[i], tips[i], 0.0, max(float(arch[i]), 0.0))
            if good[i]
            else None
            for i in range(len(lifts))
        ]

    def _stances(self, legs: NDArray[np.int64], lifts: Sequence[Lift]) -> tuple[Array, Array, Array]:
        """Return what footholds are for, see `Footholds`.

        Returns:
            R_WB (N, m, 3, 3) and p_WB (N, m, 3) of the bodies while the feet are there, and
            where these would rest in the middle of their stances (N, 2) [m].
        """
        herd, path = self.herd, self.path
        up, swing, stance = np.array([(s.step.up, s.step.swing, s.step.stance) for s in lifts]).T
        way, phase, drive = np.array([(s.travelled, s.phase, s.drive) for s in lifts]).T
        parts = np.concatenate([stance[:, None] * STANCE, (stance + LAGS * swing)[:, None]], axis=1)
        moments = (up + swing)[:, None] + parts
        owner = herd.owner[legs]
        gone = (moments - phase[:, None]) * herd.stride[owner, None]
        ways = way[:, None] + gone * np.sqrt(drive)[:, None]
        creature = np.repeat(owner, moments.shape[1])
        flat = path.pose(creature, ways.ravel(), moments.ravel())
        R, p = flat[0].reshape(*moments.shape, 3, 3), flat[1].reshape(*moments.shape, 3)
        x, z = herd.rest[legs].T
        rest = np.stack([x, -herd.body_height[owner], z + herd.aside[owner]], axis=-1)
        below = path.below(owner, moments[:, MIDDLE], rest)
        wished = p[:, MIDDLE] + turn(R[:, MIDDLE], below)
        return R, p, wished[:, [0, 2]]

    def _upright(self, legs: NDArray[np.int64], tips: Array, R: Array, p: Array) -> NDArray[np.bool_]:
        """Say whether legs reach `tips` (N, 3) by their length while bodies (N, m) do not stoop."""
        hips = p + turn(R, self.herd.hips[legs, None])
        x, y, z = np.moveaxis(tips[:, None] - hips, -1, 0)
        reach = PLANNED_REACH * self.herd.legs.lengths[legs]
        room = (reach**2)[:, None] - x**2 - z**2
        up = np.sqrt(np.maximum(room, 0.0))
        result: NDArray[np.bool_] = ((room >= 0.0) & (np.abs(y) <= up)).all(axis=1)
        return result
