"""Fields: forces on a hand that converge to a point, and the point as it moves.

    F = c (v_desired - v),    v_desired = k (x_EP - x) + v_EP

A basis field i has its point p_i; its desired velocity falls with the distance to it and is
zero at it. Fields act together by weights w_i >= 0 that sum to one:

    Σ w_i k (p_i - x) = k (Σ w_i p_i - x),

so that the sum is a field again, whose point lies in the hull of theirs; the strongest alone
acts where the winner takes all. A move shifts the weights from one field to the next by a
smooth step in time: the point of the sum then runs along a curve of bell-shaped speed, and
carries its velocity v_EP. The next field of a row of sub-goals begins to act when the hand
comes near the one before it: that is the feedback.

The paper prints F = c (v_actual - v_desired), which drives a hand away for c > 0; it converges
as written here.

Source: Matarić, Zordan and Mason 1998, section 5; Flash and Hogan 1985; Henis and Flash 1995.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from pipeline.simulation.spatial import Array

# Numbers, not arrays: there are three of each, many thousand times a second.
Point = tuple[float, float, float]

STILL: Point = (0.0, 0.0, 0.0)

FIELD_RATE = 18.0
"""k: speed by distance to the point [1/s]."""

SPEED_LIMIT = 4.0
"""Speed that no desired velocity exceeds [m/s]."""

SLOWER = 0.4
"""Part of the rate with which the strongest field acts alone: its point jumps."""

OVERLAP = 0.55
"""Part of a leg after which the next may begin."""

NEAR = 0.6
"""The next begins when the hand is as near to a sub-goal as this, in lengths of the leg to it."""

SURFACE_FRACTION_LIMIT = 0.6
"""Most of a leg that may lie under a surface."""

SHORTEST = 0.12
"""Least time that a leg takes [s]."""


def weighted_point(points: Sequence[Point], weights: Sequence[float]) -> Point:
    """Returns the point of a weighted sum of fields, in the hull of their points [m]."""
    x = y = z = 0.0
    for (a, b, c), w in zip(points, weights, strict=True):
        x, y, z = x + w * a, y + w * b, z + w * c
    return x, y, z


def strongest_point(points: Sequence[Point], weights: Sequence[float]) -> Point:
    """Returns the point of the field that acts alone where the winner takes all [m]."""
    return points[max(range(len(weights)), key=lambda i: weights[i])]


def desired_velocity(point: Point, x: Point, rate: float, own: Point = STILL) -> Point:
    """Returns the velocity that a field asks of a hand [m/s].

    Args:
        point: of the field [m].
        x: of the hand [m].
        rate: k [1/s].
        own: velocity of the point [m/s].
    """
    u = rate * (point[0] - x[0]) + own[0]
    v = rate * (point[1] - x[1]) + own[1]
    w = rate * (point[2] - x[2]) + own[2]
    # Never faster than the fastest, in the same direction.
    share = 1.0 / math.sqrt(1.0 + (u * u + v * v + w * w) / SPEED_LIMIT**2)
    return u * share, v * share, w * share


def minimum_jerk_step(s: float) -> tuple[float, float]:
    """Returns the smooth step of least jerk at `s`, and its slope."""
    if s <= 0.0:
        return 0.0, 0.0
    if s >= 1.0:
        return 1.0, 0.0
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s)


def minimum_jerk_phase(s: float) -> float:
    """Returns where the smooth step has come to `s`, between 0 and 1."""
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if minimum_jerk_step(middle)[0] < s else (low, middle)
    return high


@dataclass(slots=True)
class Leg:
    """Weights that go over to one sub-goal: its spot, its begin and its time [s]."""

    spot: int
    begin: float
    time: float


class HandField:
    """The fields of one hand.

    Args:
        anchor: where it begins [m].
        rate: k [1/s].
        winner: whether the strongest acts alone.

    Attributes:
        point: of all that act together, as it was last asked for [m].
    """

    def __init__(self, anchor: Array, rate: float, winner: bool) -> None:
        self.rate, self.winner = rate, winner
        self.spots: list[int] = []
        self.legs: list[Leg] = []
        self.land = self.press = 0.0
        self._over = math.inf
        self._seen, self._near = (0.0, math.inf), math.inf
        self.stay(anchor)

    def stay(self, anchor: Array) -> None:
        """Stay at a place (3,) [m]."""
        self.point = self.anchor = as_point(anchor)
        self.spots, self.legs, self._over = [], [], math.inf

    def go(
        self, spots: Sequence[int], now: float, land: float, places: Array, press: float = 0.0
    ) -> None:
        """Go from where the point is now through `spots`, to be at the last one at `land`.

        Args:
            spots: numbers of places.
            now: the time [s].
            land: the time when it is to be there [s].
            places: (S, 3) of all spots [m].
            press: how far the last lies under a surface, which is to be touched at `land` [m].
        """
        self.anchor = self.point
        self.spots, self.land, self.legs = list(spots), land, []
        self.press, self._over = press, math.inf
        self._begin(now, places)

    def is_there(self, now: float) -> bool:
        """Returns whether the point has come to its last place."""
        return now >= self._over

    def desired(self, x: Point, now: float, places: Array) -> Point:
        """Returns the velocity that the hand at `x` is to have [m/s]."""
        if now >= self._over:
            self.point = as_point(places[self.spots[-1]])
            return desired_velocity(self.point, x, self.rate)
        if len(self.legs) < len(self.spots):
            self._switch(x, now, places)
        weights, points, before, last = [1.0], [self.anchor], self.anchor, 1.0
        u = v = w = 0.0
        for leg in self.legs:
            s, slope = minimum_jerk_step((now - leg.begin) / leg.time)
            if s > last:
                # No weight is less than none.
                s, slope = last, 0.0
            here = as_point(places[leg.spot])
            slope /= leg.time
            u += slope * (here[0] - before[0])
            v += slope * (here[1] - before[1])
            w += slope * (here[2] - before[2])
            # What the next has is taken from the one before.
            weights[-1] -= s
            weights.append(s)
            points.append(here)
            before, last = here, s
        self.point = weighted_point(points, weights)
        if self.winner:
            return desired_velocity(strongest_point(points, weights), x, SLOWER * self.rate)
        return desired_velocity(self.point, x, self.rate, (u, v, w))

    def _switch(self, x: Point, now: float, places: Array) -> None:
        """Begin the next leg at the moment when the hand came near, between two controls."""
        leg = self.legs[-1]
        goal = as_point(places[leg.spot])
        before = as_point(places[self.legs[-2].spot]) if len(self.legs) > 1 else self.anchor
        left = math.dist(x, goal) - NEAR * math.dist(before, goal)
        since, was_left = self._seen
        if left < 0.0 and math.isinf(self._near):
            # Both are of this leg; how far is left falls evenly for so short a time.
            share = was_left / (was_left - left) if was_left < math.inf else 1.0
            self._near = since + share * (now - since)
        elif left >= 0.0:
            self._near = math.inf
        self._seen = now, left
        early = max(self._near, leg.begin + OVERLAP * leg.time)
        begin = min(early, leg.begin + leg.time)
        if begin <= now:
            self._begin(begin, places)

    def _begin(self, now: float, places: Array) -> None:
        """Begin the next leg at `now`; the time left is shared by the roots of the lengths."""
        done = len(self.legs)
        ways = [self.point if not done else as_point(places[self.spots[done - 1]])]
        ways += [as_point(places[spot]) for spot in self.spots[done:]]
        shares = [math.sqrt(max(math.dist(a, b), 1e-4)) for a, b in pairwise(ways)]
        whole = OVERLAP * sum(shares[:-1]) + shares[-1]
        time = max((self.land - now) * shares[0] / whole, SHORTEST)
        if done == len(self.spots) - 1 and self.press:
            # The surface is met before the point below it is reached.
            under = min(self.press / max(math.dist(*ways), self.press), SURFACE_FRACTION_LIMIT)
            time /= minimum_jerk_phase(1.0 - under)
        self.legs.append(Leg(self.spots[done], now, time))
        self._seen, self._near = (now, math.inf), math.inf
        if len(self.legs) == len(self.spots):
            self._over = max(leg.begin + leg.time for leg in self.legs)


def as_point(place: Array) -> Point:
    """Returns a place (3,) as numbers."""
    x, y, z = place.tolist()
    return x, y, z
