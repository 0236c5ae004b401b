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

Source: Matarić et al. 1998, section 5; Flash and Hogan 1985; Henis and Flash 1995.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.spatial import Array

RATE = 18.0
"""k: speed by distance to the point [1/s]."""

FASTEST = 4.0
"""Speed that no desired velocity exceeds [m/s]."""

OVERLAP = 0.55
"""Part of a leg after which the next may begin."""

NEAR = 0.6
"""The next begins when the hand is as near to a sub-goal as this, in lengths of the leg to it."""

SHORTEST = 0.12
"""Least time that a leg takes [s]."""


def combined(points: Array, weights: Array, x: Array, rate: float, winner: bool) -> Array:
    """Return the velocity (3,) that fields with points (n, 3) and weights (n,) ask for at x [m/s]."""
    if winner:
        velocity = rate * (points[int(np.argmax(weights))] - x)
    else:
        velocity = (weights[:, None] * (rate * (points - x))).sum(axis=0)
    return bounded_speed(velocity)


def bounded_speed(velocity: Array) -> Array:
    """Return a velocity (3,) that is never faster than `FASTEST`, in the same direction."""
    x, y, z = velocity.tolist()
    result: Array = velocity / math.sqrt(1.0 + (x * x + y * y + z * z) / FASTEST**2)
    return result


def smooth(s: float) -> tuple[float, float]:
    """Return the smooth step of least jerk at `s`, and its slope."""
    if s <= 0.0:
        return 0.0, 0.0
    if s >= 1.0:
        return 1.0, 0.0
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s)


@dataclass(slots=True)
class Leg:
    """Weights that go over to one sub-goal: its spot, its begin and its time [s]."""

    spot: int
    begin: float
    time: float


class Fields:
    """The fields of one hand.

    Args:
        anchor: (3,) where it begins [m].
        rate: k [1/s].
        winner: whether the strongest acts alone.
    """

    def __init__(self, anchor: Array, rate: float, winner: bool) -> None:
        self.rate, self.winner = rate, winner
        self.anchor = anchor.copy()
        self.spots: list[int] = []
        self.legs: list[Leg] = []
        self.land = 0.0
        self.point = anchor.copy()

    def go(self, spots: Sequence[int], now: float, land: float, places: Array) -> None:
        """Go from where the point is now through `spots`, to be at the last one at `land`."""
        self.anchor = self.point.copy()
        self.spots, self.land, self.legs = list(spots), land, []
        self._begin(now, places)

    def hold(self, spot: int) -> None:
        """Stay at a spot, wherever it goes."""
        self.spots, self.legs = [spot], [Leg(spot, -1.0, 1.0)]

    def desired(self, x: Array, now: float, places: Array) -> Array:
        """Return the velocity (3,) that the hand at `x` is to have [m/s]."""
        if self.spots and len(self.legs) < len(self.spots):
            self._switch(x, now, places)
        weights, points, velocity = [1.0], [self.anchor], np.zeros(3)
        before, last = self.anchor, 1.0
        for leg in self.legs:
            s, slope = smooth((now - leg.begin) / leg.time)
            if s > last:
                # No weight is less than none.
                s, slope = last, 0.0
            last = s
            here = places[leg.spot]
            velocity += (slope / leg.time) * (here - before)
            # What the next has is taken from the one before.
            weights[-1] -= s
            weights.append(s)
            points.append(here)
            before = here
        stack, shares = np.array(points), np.array(weights)
        self.point = (shares[:, None] * stack).sum(axis=0)
        if self.winner:
            return combined(stack, shares, x, self.rate, True)
        return bounded_speed(self.rate * (self.point - x) + velocity)

    def _switch(self, x: Array, now: float, places: Array) -> None:
        leg = self.legs[-1]
        goal = places[leg.spot]
        before = places[self.legs[-2].spot] if len(self.legs) > 1 else self.anchor
        near = float(np.linalg.norm(x - goal)) < NEAR * float(np.linalg.norm(goal - before))
        since = (now - leg.begin) / leg.time
        if since >= 1.0 or (near and since >= OVERLAP):
            self._begin(now, places)

    def _begin(self, now: float, places: Array) -> None:
        """Begin the next leg; what time is left is shared by the roots of the lengths."""
        done = len(self.legs)
        ways = [self.point if not done else places[self.spots[done - 1]]]
        ways += [places[spot] for spot in self.spots[done:]]
        lengths = np.linalg.norm(np.diff(np.array(ways), axis=0), axis=1)
        shares = np.sqrt(np.maximum(lengths, 1e-4))
        whole = OVERLAP * float(shares[:-1].sum()) + float(shares[-1])
        time = max((self.land - now) * float(shares[0]) / whole, SHORTEST)
        self.legs.append(Leg(self.spots[done], now, time))
