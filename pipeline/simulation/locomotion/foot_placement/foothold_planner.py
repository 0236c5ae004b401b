"""Plain steps: what most feet do, planned together for all that lift within a few world steps.

A foot mostly comes down at the first place of those that it may choose from that its leg is
long enough for, with its body no lower than it goes anyway. That is worked out for many
feet at once; if joints cannot do it, the foot is left to `Footholds`, which looks farther,
and finds the same where a plain step is good.

Steps are planned before feet lift, from what their bodies will have done then. A plan counts
only if that is what they did, to the last bit; so it is the same whenever it was made.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.foot_placement.foothold_search import (
    EASY_ARCH,
    EASY_WAY,
    LAGS,
    MOST_ARCH,
    PLANNED_REACH,
    STANCE,
    SWUNG,
    Foothold,
    Footholds,
)
from pipeline.simulation.locomotion.gaits.gait_transition import StepTiming
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    clearance_heights,
    lowest_center_height,
    swing_positions,
)
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
    step: StepTiming
    drive: float
    present: Array | None = None

    @property
    def numbers(self) -> tuple[float, ...]:
        """All that says where the foot comes down."""
        present = () if self.present is None else self.present.tolist()
        return (self.travelled, self.phase, self.drive, self.step.swing, self.step.stance, *present)


@dataclass(frozen=True, eq=False)
class Plan:
    """What became of a lift.

    Attributes:
        lift: the lift.
        place: where the foot comes down, None if its step is not plain.
        route: that its body followed.
        bearing: that all bodies had.
    """

    lift: Lift
    place: Foothold | None
    route: Route
    bearing: MotionStyle


@dataclass(frozen=True, eq=False)
class Bodies:
    """How the bodies of N lifts go on; all arrays (N,), see `Lift`."""

    legs: NDArray[np.int64]
    owner: NDArray[np.int64]
    way: Array
    phase: Array
    drive: Array
    up: Array
    swing: Array
    stance: Array

    def some(self, which: NDArray[np.int64]) -> Bodies:
        """Return those of some lifts."""
        return Bodies(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def at(self, path: BodyTrajectory, moments: Array) -> tuple[Array, Array]:
        """Return R_WB (N, m, 3, 3) and p_WB (N, m, 3) at later phases (N, m) [m]."""
        gone = (moments - self.phase[:, None]) * path.herd.stride[self.owner, None]
        ways = self.way[:, None] + gone * np.sqrt(self.drive)[:, None]
        creature = np.repeat(self.owner, moments.shape[1])
        R, p = path.pose(creature, ways.ravel(), moments.ravel())
        return R.reshape(*moments.shape, 3, 3), p.reshape(*moments.shape, 3)


class PlainSteps:
    """The plain steps of a herd.

    Attributes:
        footholds: where the others are put.
    """

    def __init__(self, footholds: Footholds) -> None:
        self.footholds = footholds
        self.herd = footholds.herd
        self.path = footholds.path
        self._plans: dict[int, Plan] = {}
        self._found: dict[int, Plan] = {}

    def foresee(self, lifts: Sequence[Lift], later: Callable[[], Sequence[Lift]] = tuple) -> None:
        """Plan all steps of `lifts` that are plain, and forget all others.

        Args:
            lifts: of feet that lift now.
            later: returns some that are expected soon, which are planned together with
                those of `lifts` that were not expected.
        """
        lifts = [one for one in lifts if self._keeps_pace(one)]
        new = [one for one in lifts if not self._knows(one)]
        if new:
            now = {one.leg for one in lifts}
            soon = [one for one in later() if one.leg not in now and self._keeps_pace(one)]
            new += [one for one in soon if not self._knows(one)]
            for one, place in zip(new, self._planned(new), strict=True):
                self._plans[one.leg] = Plan(one, place, self._route(one.leg), self.path.bearing)
        self._found = {one.leg: self._plans[one.leg] for one in lifts}

    def of(self, leg: int) -> Foothold | None:
        """Return where a foot that was foreseen comes down by a plain step, if it does."""
        plan = self._found.get(leg)
        # Its creature may have been led elsewhere since.
        return plan.place if plan is not None and plan.route is self._route(leg) else None

    def _keeps_pace(self, lift: Lift) -> bool:
        """Tell whether a body goes on as it does: over into another pace no step is plain."""
        return int(self.herd.owner[lift.leg]) not in self.path.paces.changes

    def _knows(self, lift: Lift) -> bool:
        plan = self._plans.get(lift.leg)
        if plan is None or plan.route is not self._route(lift.leg):
            return False
        return plan.bearing is self.path.bearing and plan.lift.numbers == lift.numbers

    def _route(self, leg: int) -> Route:
        return self.path.routes[int(self.herd.owner[leg])]

    def _planned(self, lifts: Sequence[Lift]) -> list[Foothold | None]:
        legs = np.array([one.leg for one in lifts])
        bodies = self._bodies_of(legs, lifts)
        R, p, wished = self._stances(bodies)
        herd, ground = self.herd, self.footholds.ground
        xz, good = self._chosen(legs, lifts, wished, R, p)
        heights, normals = ground.surface(xz[:, 0], xz[:, 1])
        places = np.stack([xz[:, 0], heights, xz[:, 1]], axis=-1)
        tips = places + herd.sole[legs, None] * normals
        held = np.flatnonzero(good)
        goals = unturn(R[held], tips[held, None] - p[held])
        good[held] = self.footholds.grasp.holds_each(legs[held], goals).all(axis=-1)
        sole = lowest_center_height(ground, tips[:, 0], tips[:, 2], herd.sole[legs])
        tips[:, 1] = np.maximum(tips[:, 1], sole)
        arch = np.zeros(len(lifts))
        swings = np.flatnonzero(good & [one.present is not None for one in lifts])
        if len(swings):
            start = np.array([lifts[i].present for i in swings.tolist()])
            down = R[swings, 0], p[swings, 0]
            arch[swings], good[swings] = self._swung(bodies.some(swings), start, tips[swings], down)
        return [
            Foothold(places[i], normals[i], tips[i], 0.0, float(arch[i])) if good[i] else None
            for i in range(len(lifts))
        ]

    def _swung(
        self, bodies: Bodies, start: Array, end: Array, down: tuple[Array, Array]
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return how high feet arch (N,) on their way between places [m], and who can.

        Args:
            bodies: N.
            start: (N, 3) and
            end: (N, 3), tips [m].
            down: R_WB (N, 3, 3) and p_WB (N, 3) of the bodies when the feet come down [m].
        """
        herd, legs = self.herd, bodies.legs
        least, stride = herd.step_height[legs], herd.stride[herd.owner[legs]]
        arch = clearance_heights(self.footholds.ground, start, end, herd.sole[legs], least)
        good = arch <= MOST_ARCH * herd.legs.lengths[legs]
        across = end - start
        grasp = self.footholds.grasp
        easy = (arch < EASY_ARCH * least) & (np.abs(across[:, 1]) < least)
        easy &= np.hypot(across[:, 0], across[:, 2]) <= EASY_WAY * stride
        easy &= self.footholds.lifting[legs]
        R, p = bodies.at(self.path, bodies.up[:, None])
        for tip, (R_WB, p_WB) in ((start, (R[:, 0], p[:, 0])), (end, down)):
            easy &= grasp.beside_each(legs, unturn(R_WB, tip - p_WB))
        asked = np.flatnonzero(good & ~easy)
        if len(asked):
            some = bodies.some(asked)
            R, p = some.at(self.path, some.up[:, None] + some.swing[:, None] * SWUNG)
            first, last, height = (
                np.repeat(f[asked], len(SWUNG), axis=0) for f in (start, end, arch)
            )
            way = swing_positions(first, last, height, np.tile(SWUNG, len(asked))).reshape(p.shape)
            good[asked] = grasp.follows_each(legs[asked], unturn(R, way - p))
        return arch, good

    def _bodies_of(self, legs: NDArray[np.int64], lifts: Sequence[Lift]) -> Bodies:
        numbers = [
            (s.travelled, s.phase, s.drive, s.step.up, s.step.swing, s.step.stance) for s in lifts
        ]
        way, phase, drive, up, swung, stance = np.array(numbers).T
        return Bodies(legs, self.herd.owner[legs], way, phase, drive, up, swung, stance)

    def _stances(self, bodies: Bodies) -> tuple[Array, Array, Array]:
        """Return what footholds are for, see `Footholds`.

        Returns:
            R_WB (N, m, 3, 3) and p_WB (N, m, 3) of the bodies while the feet are there, and
            where these would rest in the middle of their stances (N, 2) [m].
        """
        herd, owner = self.herd, bodies.owner
        stance = bodies.stance[:, None]
        end = stance + LAGS * bodies.swing[:, None]
        parts = np.concatenate([stance * STANCE, end], axis=1)
        moments = (bodies.up + bodies.swing)[:, None] + parts
        R, p = bodies.at(self.path, moments)
        x, z = herd.rest[bodies.legs].T
        rest = np.stack([x, -herd.body_height[owner], z + herd.aside[owner]], axis=-1)
        below = self.path.below(owner, moments[:, MIDDLE], rest)
        wished = p[:, MIDDLE] + turn(R[:, MIDDLE], below)
        return R, p, wished[:, [0, 2]]

    def _chosen(
        self, legs: NDArray[np.int64], lifts: Sequence[Lift], wished: Array, R: Array, p: Array
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return the first place (N, 2) [m] of each foot that its leg is long enough for.

        Args:
            legs: (N,) which.
            lifts: N of them.
            wished: (N, 2) where feet would rest [m].
            R: (N, m, 3, 3) and
            p: (N, m, 3), poses of the bodies while the feet are there [m].

        Returns:
            The places, and which of them are any good.
        """
        xz, good = wished.copy(), self._fits(legs, wished[:, None], R, p)[:, 0]
        for back in (True, False):
            left = [
                i
                for i in np.flatnonzero(~good).tolist()
                if not back or lifts[i].present is not None
            ]
            if not left:
                continue
            places = np.array([self._choices(lifts[i], wished[i], back) for i in left])
            fits = self._fits(legs[left], places, R[left], p[left])
            good[left] = fits.any(axis=1)
            xz[left] = places[np.arange(len(left)), fits.argmax(axis=1)]
        return xz, good

    def _choices(self, lift: Lift, wished: Array, back: bool) -> Array:
        """Return places (k, 2) around where a foot would rest, or on the way `back` from there."""
        if back and lift.present is not None:
            return self.footholds.nearer(wished, lift.present[[0, 2]])
        return self.footholds.around(lift.leg, wished)

    def _fits(self, legs: NDArray[np.int64], xz: Array, R: Array, p: Array) -> NDArray[np.bool_]:
        """Say which of places (N, k, 2) legs may stand on and reach, no body (N, m) stooping.

        By their lengths: joints have not been asked yet.
        """
        herd = self.herd
        x, z = xz[..., 0], xz[..., 1]
        heights, normals = self.footholds.ground.surface(x, z)
        tips = np.stack([x, heights, z], axis=-1) + herd.sole[legs, None, None] * normals
        hips = p + turn(R, herd.hips[legs, None])
        x, y, z = np.moveaxis(tips[:, :, None] - hips[:, None], -1, 0)
        reach = PLANNED_REACH * herd.legs.lengths[legs]
        room = (reach**2)[:, None, None] - x**2 - z**2
        up = np.sqrt(np.maximum(room, 0.0))
        most = np.minimum(up, self.footholds.highest[legs, None, None])
        reached = ((room >= 0.0) & (y <= most) & (y >= -up)).all(axis=-1)
        owner = np.repeat(herd.owner[legs], xz.shape[1])
        allowed = self.path.footing.allows_each(owner, xz[..., 0].ravel(), xz[..., 1].ravel())
        result: NDArray[np.bool_] = reached & allowed.reshape(reached.shape)
        return result
