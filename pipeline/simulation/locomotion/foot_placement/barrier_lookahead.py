"""Barrier lookahead: ends routes before ground that a creature cannot cross.

For each leg it tests the footholds that the leg would need while its body brakes, and that the
ground ahead is not higher than the belly. Where a test fails, the route ends before that place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.foot_placement.foothold_search import FootholdSearch
from pipeline.simulation.locomotion.foot_placement.step_batch import StepRequest
from pipeline.simulation.locomotion.gaits.pace_schedule import StepTiming
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.locomotion.routes.route_progress import RouteProgress
from pipeline.simulation.spatial import Array

# Greatest distance between ground and support surface where a leg stands without a search, in leg
# lengths.
EVEN_GROUND = 0.15

# Least distance to a barrier for which a creature sets out at all, in strides.
MIN_START_DISTANCE = 0.25

# Resting places tried within the stride before a barrier.
REST_CANDIDATES = 8

# Samples of the ground before the belly, in the part of the route that is new.
BELLY_SAMPLES = np.linspace(0.0, 1.0, 13)


@dataclass(frozen=True)
class Barrier:
    """An obstacle that ends a route.

    Attributes:
        distance: after which the body has to rest [m].
        cause: text for the note.
    """

    distance: float
    cause: str


class BarrierLookahead:
    """Looks ahead for barriers on the routes of a herd."""

    def __init__(self, search: FootholdSearch, progress: RouteProgress) -> None:
        self.search, self.progress = search, progress
        self.herd, self.trajectory = search.herd, search.trajectory
        self._tested = np.full(len(self.herd.owner), -math.inf)
        self._clear = np.zeros(len(self.herd.names))
        self._even = dict[tuple[int, float, Route], bool]()

    def forget(self, c: int) -> None:
        """Forget all tests on the route of a creature that has been given another one."""
        self._tested[self.herd.owner == c] = -math.inf
        self._clear[c] = 0.0

    # --- before the start -----------------------------------------------------------

    def predict_initial(self, legs: Sequence[int]) -> None:
        """Test together the ground that `initial_barrier` will need."""
        self.predict([self._first_step(leg) for leg in legs], first_cycle=0)

    def initial_barrier(self, leg: int) -> Barrier | None:
        """Return the barrier on a leg's way from the start; a near one keeps the creature there."""
        step = self._first_step(leg)
        stride = float(self.progress.stride[self.herd.owner[leg]])
        barrier = self.next_barrier(leg, step.distance, step.phase, first_cycle=0)
        if barrier is None:
            return None
        near = barrier.distance < MIN_START_DISTANCE * stride
        return Barrier(0.0, barrier.cause) if near else barrier

    def _first_step(self, leg: int) -> StepRequest:
        phase = float(np.mod(self.herd.up[leg], 1.0))
        distance = phase * float(self.progress.stride[self.herd.owner[leg]])
        return StepRequest(leg, distance, phase, self.trajectory.paces.step(leg, phase))

    # --- on the way -----------------------------------------------------------------

    def next_barrier(
        self, leg: int, distance: float, phase: float, first_cycle: int = 1
    ) -> Barrier | None:
        """Return the barrier on the way of a leg that lifts.

        Args:
            leg: its number.
            distance: that its body has gone [m].
            phase: of the gait there, whole cycles counted.
            first_cycle: first of its swings to come that is not planned; 0 before the start, when
                the creature may set out as slowly as it has to.
        """
        c = int(self.herd.owner[leg])
        stride = float(self.progress.stride[c])
        timing = self.trajectory.paces.step(leg, phase)
        braking = self.progress.braking_room(c)
        nearest = distance + braking if first_cycle else 0.0
        for k, middle in self._stances_ahead(leg, distance, timing, first_cycle):
            if middle <= self._tested[leg] + 0.5 * stride:
                continue
            if not self._is_even(leg, middle):
                up = phase + k
                later = StepRequest(leg, distance + k * stride, up, replace(timing, up=up))
                if self.search.find_ahead(later) is None:
                    # One stride earlier the leg stood well; no nearer than the brakes allow.
                    last = self._last_rest(c, middle - stride, middle)
                    return Barrier(max(last, nearest), "no foothold ahead")
            self._tested[leg] = middle
        return self._belly_barrier(c, distance, braking, nearest)

    def predict(
        self,
        requests: Sequence[StepRequest],
        first_cycle: int = 1,
        upcoming: Callable[[], Sequence[StepRequest]] = tuple,
    ) -> None:
        """Test together the ground that `next_barrier` will need.

        Args:
            requests: steps of feet that lift now.
            first_cycle: see `next_barrier`.
            upcoming: returns steps that are expected soon, which are tested together with those
                of `requests` that were not expected.
        """
        if all(key in self._even for key in self._keys(requests, first_cycle)):
            return
        self._even.clear()
        keys = list(dict.fromkeys(self._keys([*requests, *upcoming()], first_cycle)))
        legs, middles = np.array([leg for leg, *_ in keys]), np.array([s for _, s, _ in keys])
        self._even.update(zip(keys, self._are_even(legs, middles).tolist(), strict=True))

    def _keys(
        self, requests: Sequence[StepRequest], first_cycle: int
    ) -> Iterator[tuple[int, float, Route]]:
        """Yield leg, distance of its body in the middle of the stance [m], and its route."""
        for step in requests:
            route = self._route(step.leg)
            ahead = self._stances_ahead(step.leg, step.distance, step.timing, first_cycle)
            for _, middle in ahead:
                yield step.leg, middle, route

    def _route(self, leg: int) -> Route:
        return self.trajectory.routes[int(self.herd.owner[leg])]

    def _stances_ahead(
        self, leg: int, distance: float, timing: StepTiming, first_cycle: int
    ) -> list[tuple[int, float]]:
        """Return cycles to come, and the body's distance in the middle of their stances [m]."""
        c = int(self.herd.owner[leg])
        stride, end = float(self.progress.stride[c]), self.trajectory.routes[c].length
        middle = distance + (timing.swing + 0.5 * timing.stance) * stride
        last = 1 + math.ceil(self.progress.braking_room(c) / stride)
        ahead = [(k, middle + k * stride) for k in range(first_cycle, last + 1)]
        new = self._tested[leg] + 0.5 * stride
        return [(k, s) for k, s in ahead if new < s <= end]

    def _is_even(self, leg: int, middle: float) -> bool:
        """Return whether a leg stands without a search if its body has gone `middle` [m] then."""
        known = self._even.get((leg, middle, self._route(leg)))
        if known is None:
            return bool(self._are_even(np.array([leg]), np.array([middle]))[0])
        return known

    def _are_even(self, legs: NDArray[np.int64], middle: Array) -> NDArray[np.bool_]:
        herd, surface = self.herd, self.trajectory.surface
        owner = herd.owner[legs]
        xz, headings, _ = self.trajectory.on_route(owner, middle)
        cos, sin = np.cos(headings), np.sin(headings)
        along, across = herd.rest[legs].T
        x, z = xz[:, 0] + (along * cos + across * sin), xz[:, 1] + (across * cos - along * sin)
        smooth, _ = surface.heights(owner, x[:, None], z[:, None])
        off = np.abs(self.trajectory.ground.height(x, z) - smooth[:, 0])
        near: NDArray[np.bool_] = off < EVEN_GROUND * herd.legs.lengths[legs]
        return near & surface.is_allowed(owner, x, z)

    def _last_rest(self, c: int, first: float, last: float) -> float:
        """Return the longest distance up to `last` at which all feet can stand neutral [m]."""
        own = np.flatnonzero(self.herd.owner == c).tolist()
        for k in range(REST_CANDIDATES):
            distance = last + (first - last) * k / REST_CANDIDATES
            if distance >= 0.0 and all(self.search.can_stand_neutral(leg, distance) for leg in own):
                return distance
        return first

    def _belly_barrier(
        self, c: int, distance: float, braking: float, nearest: float
    ) -> Barrier | None:
        """Return ground too high for the belly, on the part of the route that is new."""
        nose, support = float(self.herd.footprint[c, 0]), self.trajectory.surface.of(c)
        last = distance + braking + float(self.progress.stride[c])
        first = max(self._clear[c], distance)
        if last <= first:
            return None
        if support.has_walls:
            samples = first + (last - first) * BELLY_SAMPLES
            xz, *_ = self.trajectory.on_route(np.full(len(samples), c), samples + nose)
            high = support.barred(xz[:, 0], xz[:, 1])
            if high.any():
                before = float(samples[max(int(np.argmax(high)) - 1, 0)])
                return Barrier(max(before, nearest), "the ground ahead is higher than its belly")
        self._clear[c] = last
        return None
