"""Scout: looks ahead, so that a creature stops before ground that it cannot go over.

For each leg the footholds are tried that it would need while its body brakes, and before
the body the ground must not rise higher than its belly. Where that fails the way ends
before, and the creature comes to rest there as at the end of any route.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.foot_placement.foothold_planner import Lift
from pipeline.simulation.locomotion.foot_placement.foothold_search import Footholds
from pipeline.simulation.locomotion.gaits.gait_transition import StepTiming
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.spatial import Array

PLAIN = 0.15
"""How far from the surface that bodies follow ground may lie to be plain, in leg lengths."""

SETS_OUT = 0.25
"""Way for which it is worth setting out, in strides."""

CLOSER = 8
"""Places looked at within the stride before what bars the way, to come as near as can be."""

NOSE = np.linspace(0.0, 1.0, 13)
"""Places looked at before the body, in the way that is new."""


@dataclass(frozen=True)
class Barrier:
    """What ends a way.

    Attributes:
        way: after which the body has to rest [m].
        cause: in words.
    """

    way: float
    cause: str


class BarrierLookahead:
    """Looks ahead for the creatures of a herd."""

    def __init__(self, footholds: Footholds, going: RouteProgress) -> None:
        self.footholds = footholds
        self.going = going
        self.herd = footholds.herd
        self.path = footholds.path
        legs, count = len(self.herd.owner), len(self.herd.names)
        self._seen = np.full(legs, -math.inf)
        self._clear = np.zeros(count)
        self._plain = dict[tuple[int, float, Route], bool]()

    def before(self, leg: int) -> Barrier | None:
        """Look for what bars the way of a leg from the start: if it is near, it stays."""
        lift, stride = self._first(leg), float(self.going.full[self.herd.owner[leg]])
        barrier = self.ahead(leg, lift.travelled, lift.phase, first=0)
        if barrier is None:
            return None
        return Barrier(0.0, barrier.cause) if barrier.way < SETS_OUT * stride else barrier

    def forget(self, c: int) -> None:
        """Forget what was seen on the way of a creature that goes another one."""
        self._seen[self.herd.owner == c] = -math.inf
        self._clear[c] = 0.0

    def _first(self, leg: int) -> Lift:
        """Return what is known of the first step of a leg after the start."""
        phase = float(np.mod(self.herd.up[leg], 1.0))
        way = phase * float(self.going.full[self.herd.owner[leg]])
        return Lift(leg, way, phase, self.path.paces.step(leg, phase), 1.0)

    def foresee_before(self, legs: Sequence[int]) -> None:
        """Look together at the ground that `before` will ask about."""
        self.foresee([self._first(leg) for leg in legs], first=0)

    def ahead(self, leg: int, way: float, phase: float, first: int = 1) -> Barrier | None:
        """Look for what bars the way of a leg that lifts.

        Args:
            leg: which.
            way: that its body has gone [m].
            phase: of the gait at that, whole cycles counted.
            first: the first of its next swings that is not planned yet; from 0 on, it has not
                set out, and may do so as slowly as it has to.
        """
        c = int(self.herd.owner[leg])
        stride, step = float(self.going.full[c]), self.path.paces.step(leg, phase)
        braking = float(self.going.braking[c])
        nearest = way + braking if first else 0.0
        for k, there in self._places(leg, way, step, first):
            if there <= self._seen[leg] + 0.5 * stride:
                continue
            later = replace(step, up=phase + k)
            stands = self._is_plain(leg, there)
            if not stands and self.footholds.later(leg, way + k * stride, later) is None:
                # One stride before it the leg stood well; no nearer than brakes allow.
                last = self._rests(c, there - stride, there)
                return Barrier(max(last, nearest), "no foothold ahead")
            self._seen[leg] = there
        return self._wall(c, way, braking, nearest)

    def foresee(
        self,
        lifts: Sequence[Lift],
        first: int = 1,
        later: Callable[[], Sequence[Lift]] = tuple,
    ) -> None:
        """Look together at the ground that all of `lifts` will be asked about.

        Args:
            lifts: of feet that lift now.
            first: see `ahead`.
            later: returns some that are expected soon, which are looked at together with
                those of `lifts` that were not expected.
        """
        if all(key in self._plain for key in self._asked(lifts, first)):
            return
        self._plain.clear()
        asked = list(dict.fromkeys(self._asked([*lifts, *later()], first)))
        legs, there = np.array([leg for leg, _, _ in asked]), np.array([way for _, way, _ in asked])
        self._plain.update(zip(asked, self._are_plain(legs, there).tolist(), strict=True))

    def _asked(self, lifts: Sequence[Lift], first: int) -> Iterator[tuple[int, float, Route]]:
        """Yield what `ahead` will want to know of lifts: leg, place of its body [m], its route."""
        for one in lifts:
            route = self.path.routes[int(self.herd.owner[one.leg])]
            for _, middle in self._places(one.leg, one.travelled, one.step, first):
                yield one.leg, middle, route

    def _places(
        self, leg: int, way: float, step: StepTiming, first: int
    ) -> list[tuple[int, float]]:
        """Return for cycles to come how far in the middle of its stance a body has gone [m]."""
        c = int(self.herd.owner[leg])
        stride, end = float(self.going.full[c]), self.path.routes[c].length
        middle = way + (step.swing + 0.5 * step.stance) * stride
        cycles = 1 + math.ceil(float(self.going.braking[c]) / stride)
        places = [(k, middle + k * stride) for k in range(first, cycles + 1)]
        new = self._seen[leg] + 0.5 * stride
        return [(k, there) for k, there in places if new < there <= end]

    def _is_plain(self, leg: int, middle: float) -> bool:
        """Tell whether a leg stands anyway if its body has gone `middle` [m] then."""
        route = self.path.routes[int(self.herd.owner[leg])]
        known = self._plain.get((leg, middle, route))
        if known is None:
            return bool(self._are_plain(np.array([leg]), np.array([middle]))[0])
        return known

    def _are_plain(self, legs: NDArray[np.int64], middle: Array) -> NDArray[np.bool_]:
        """Say which legs (N,) stand anyway in stances whose middles are after ways (N,) [m]."""
        herd, footing = self.herd, self.path.footing
        owner = herd.owner[legs]
        xz, turned, _ = self.path.on_route(owner, middle)
        cos, sin = np.cos(turned), np.sin(turned)
        along, across = herd.rest[legs].T
        x, z = xz[:, 0] + (along * cos + across * sin), xz[:, 1] + (across * cos - along * sin)
        surface, _ = footing.surface(owner, x[:, None], z[:, None])
        off = np.abs(self.path.ground.height(x, z) - surface[:, 0])
        near: NDArray[np.bool_] = off < PLAIN * herd.legs.lengths[legs]
        return near & footing.allows_each(owner, x, z)

    def _rests(self, c: int, first: float, last: float) -> float:
        """Return the longest way up to `last` after which all feet have places to rest [m]."""
        own = np.flatnonzero(self.herd.owner == c).tolist()
        for k in range(CLOSER):
            way = last + (first - last) * k / CLOSER
            if way >= 0.0 and all(self.footholds.rests(leg, way) for leg in own):
                return way
        return first

    def _wall(self, c: int, way: float, braking: float, nearest: float) -> Barrier | None:
        """Return what is too high for the belly on the way that has not been seen yet."""
        nose = float(self.herd.footprint[c, 0])
        last = way + braking + float(self.going.full[c])
        first = max(self._clear[c], way)
        if last <= first:
            return None
        if not self.path.footing.has_walls(c):
            self._clear[c] = last
            return None
        places = first + (last - first) * NOSE
        xz, _, _ = self.path.on_route(np.full(len(places), c), places + nose)
        high = self.path.footing.barred(c, xz[:, 0], xz[:, 1])
        if not high.any():
            self._clear[c] = last
            return None
        before = float(places[max(int(np.argmax(high)) - 1, 0)])
        return Barrier(max(before, nearest), "the ground ahead is higher than its belly")
