"""Force fields that pull a hand to a moving equilibrium point.

    F = c (v_desired - v),    v_desired = k (x_EP - x) + v_EP

Basis field i has the equilibrium point p_i; its desired velocity falls with the distance to p_i
and is zero there. The weights w_i >= 0 of superposed fields sum to one:

    Σ w_i k (p_i - x) = k (Σ w_i p_i - x),

so the sum is a field whose equilibrium point lies in the convex hull of the p_i. With
winner-take-all, only the field of the largest weight acts. A move shifts the weights from each
field to the next by a minimum-jerk step in time: the equilibrium point moves with a bell-shaped
speed v_EP. Feedback: the next field of a sequence of sub-goals starts when the hand approaches
the previous sub-goal.

The paper prints F = c (v_actual - v_desired), which diverges for c > 0; the sign here converges.

Source: Matarić, Zordan and Mason 1998, section 5; Flash and Hogan 1985; Henis and Flash 1995.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from pipeline.simulation.spatial import Array

# Tuples, not arrays: three components, many thousand evaluations a second.
Point = tuple[float, float, float]

ZERO_VELOCITY: Point = (0.0, 0.0, 0.0)

FIELD_RATE = 18.0
"""Rate k: desired speed per distance to the equilibrium point [1/s]."""

SPEED_LIMIT = 4.0
"""Limit of the desired speed [m/s]."""

WINNER_RATE_FACTOR = 0.4
"""Factor of the rate under winner-take-all, where the equilibrium point jumps."""

OVERLAP_FRACTION = 0.55
"""Fraction of the duration of a leg after which the next leg may start."""

APPROACH_FRACTION = 0.6
"""Distance to a sub-goal at which the next leg starts, as a fraction of the leg's length."""

SURFACE_FRACTION_LIMIT = 0.6
"""Largest fraction of a leg below a surface."""

MIN_LEG_DURATION = 0.12
"""Shortest duration of a leg [s]."""


def weighted_point(points: Sequence[Point], weights: Sequence[float]) -> Point:
    """Returns the equilibrium point of a weighted sum of fields [m]."""
    x = y = z = 0.0
    for (a, b, c), w in zip(points, weights, strict=True):
        x, y, z = x + w * a, y + w * b, z + w * c
    return x, y, z


def strongest_point(points: Sequence[Point], weights: Sequence[float]) -> Point:
    """Returns the equilibrium point of the field with the largest weight [m]."""
    return points[max(range(len(weights)), key=lambda i: weights[i])]


def desired_velocity(
    point: Point, x: Point, rate: float, point_velocity: Point = ZERO_VELOCITY
) -> Point:
    """Returns the desired velocity of a hand in a field [m/s].

    Args:
        point: equilibrium point x_EP [m].
        x: position of the hand [m].
        rate: k [1/s].
        point_velocity: v_EP [m/s].
    """
    u = rate * (point[0] - x[0]) + point_velocity[0]
    v = rate * (point[1] - x[1]) + point_velocity[1]
    w = rate * (point[2] - x[2]) + point_velocity[2]
    # A smooth speed limit keeps the direction.
    scale = 1.0 / math.sqrt(1.0 + (u * u + v * v + w * w) / SPEED_LIMIT**2)
    return u * scale, v * scale, w * scale


def minimum_jerk_step(s: float) -> tuple[float, float]:
    """Returns the minimum-jerk step at phase `s`, and its derivative."""
    if s <= 0.0:
        return 0.0, 0.0
    if s >= 1.0:
        return 1.0, 0.0
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s)


def minimum_jerk_phase(s: float) -> float:
    """Returns the phase in [0, 1] at which the minimum-jerk step has the value `s`."""
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if minimum_jerk_step(middle)[0] < s else (low, middle)
    return high


@dataclass(slots=True)
class Leg:
    """Transfer of the weight to one sub-goal.

    Attributes:
        site: number of the sub-goal's site.
        start: start [s].
        duration: duration [s].
    """

    site: int
    start: float
    duration: float


class HandField:
    """The force field of one hand.

    Args:
        anchor: initial equilibrium point (3,) [m].
        rate: k [1/s].
        winner_takes_all: whether only the field of the largest weight acts.

    Attributes:
        point: equilibrium point at the last call of `desired` [m].
        sites: numbers of the sub-goals of the move.
        legs: legs started so far.
        land: arrival at the last sub-goal [s].
        press: depth of the last sub-goal below a surface [m].
    """

    def __init__(self, anchor: Array, rate: float, winner_takes_all: bool) -> None:
        self.rate, self.winner_takes_all = rate, winner_takes_all
        self.sites: list[int] = []
        self.legs: list[Leg] = []
        self.land = self.press = 0.0
        self._end = math.inf
        # Time of the last control and the remaining distance then; time of the approach.
        self._last_distance, self._approach_time = (0.0, math.inf), math.inf
        self.stay(anchor)

    def stay(self, anchor: Array) -> None:
        """Sets the equilibrium point to a fixed position (3,) [m]."""
        self.point = self.anchor = as_point(anchor)
        self.sites, self.legs, self._end = [], [], math.inf

    def go(
        self, sites: Sequence[int], now: float, land: float, places: Array, press: float = 0.0
    ) -> None:
        """Starts a move of the equilibrium point through `sites`.

        Args:
            sites: numbers of the sub-goals.
            now: start [s].
            land: arrival at the last sub-goal, or at the surface above it [s].
            places: (S, 3) positions of all sites [m].
            press: depth of the last sub-goal below a surface [m].
        """
        self.anchor = self.point
        self.sites, self.land, self.legs = list(sites), land, []
        self.press, self._end = press, math.inf
        self._start_leg(now, places)

    def is_there(self, now: float) -> bool:
        """Returns whether the equilibrium point has reached its last sub-goal."""
        return now >= self._end

    def desired(self, x: Point, now: float, places: Array) -> Point:
        """Returns the desired velocity of the hand at `x` [m/s]."""
        if now >= self._end:
            self.point = as_point(places[self.sites[-1]])
            return desired_velocity(self.point, x, self.rate)
        if len(self.legs) < len(self.sites):
            self._start_next_leg(x, now, places)
        weights, points, before, last = [1.0], [self.anchor], self.anchor, 1.0
        u = v = w = 0.0
        for leg in self.legs:
            s, slope = minimum_jerk_step((now - leg.start) / leg.duration)
            if s > last:
                # Weights stay non-negative.
                s, slope = last, 0.0
            here = as_point(places[leg.site])
            slope /= leg.duration
            u += slope * (here[0] - before[0])
            v += slope * (here[1] - before[1])
            w += slope * (here[2] - before[2])
            # Each weight is taken from the previous field.
            weights[-1] -= s
            weights.append(s)
            points.append(here)
            before, last = here, s
        self.point = weighted_point(points, weights)
        if self.winner_takes_all:
            strongest = strongest_point(points, weights)
            return desired_velocity(strongest, x, WINNER_RATE_FACTOR * self.rate)
        return desired_velocity(self.point, x, self.rate, (u, v, w))

    def _start_next_leg(self, x: Point, now: float, places: Array) -> None:
        """Starts the next leg once the hand approaches, at a time between two controls."""
        leg = self.legs[-1]
        goal = as_point(places[leg.site])
        before = as_point(places[self.legs[-2].site]) if len(self.legs) > 1 else self.anchor
        remaining = math.dist(x, goal) - APPROACH_FRACTION * math.dist(before, goal)
        last_time, last_remaining = self._last_distance
        if remaining < 0.0 and math.isinf(self._approach_time):
            # The distance is linear in time between two controls of one leg.
            fraction = (
                last_remaining / (last_remaining - remaining) if last_remaining < math.inf else 1.0
            )
            self._approach_time = last_time + fraction * (now - last_time)
        elif remaining >= 0.0:
            self._approach_time = math.inf
        self._last_distance = now, remaining
        early = max(self._approach_time, leg.start + OVERLAP_FRACTION * leg.duration)
        start = min(early, leg.start + leg.duration)
        if start <= now:
            self._start_leg(start, places)

    def _start_leg(self, start: float, places: Array) -> None:
        """Starts a leg; the remaining legs divide the time by the square roots of their lengths."""
        done = len(self.legs)
        points = [self.point if not done else as_point(places[self.sites[done - 1]])]
        points += [as_point(places[site]) for site in self.sites[done:]]
        shares = [math.sqrt(max(math.dist(a, b), 1e-4)) for a, b in pairwise(points)]
        total = OVERLAP_FRACTION * sum(shares[:-1]) + shares[-1]
        duration = max((self.land - start) * shares[0] / total, MIN_LEG_DURATION)
        if done == len(self.sites) - 1 and self.press:
            # The hand meets the surface before the equilibrium point below it.
            below = min(self.press / max(math.dist(*points), self.press), SURFACE_FRACTION_LIMIT)
            duration /= minimum_jerk_phase(1.0 - below)
        self.legs.append(Leg(self.sites[done], start, duration))
        self._last_distance, self._approach_time = (start, math.inf), math.inf
        if len(self.legs) == len(self.sites):
            self._end = max(leg.start + leg.duration for leg in self.legs)


def as_point(place: Array) -> Point:
    """Returns a position (3,) as a tuple [m]."""
    x, y, z = place.tolist()
    return x, y, z
