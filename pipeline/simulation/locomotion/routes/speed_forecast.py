"""Speed forecast: where a creature will be that speeds up, slows down or has to come to rest.

It follows the law of `speed_control` over the next cycle and a half, step by step, so that a foot
is placed for the body that will be above it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.locomotion.routes.route_progress import (
    ARRIVAL_DISTANCE,
    HURRY_RISE,
    MIN_SPEED_FRACTION,
    RouteProgress,
)
from pipeline.simulation.locomotion.routes.speed_control import slope_fractions
from pipeline.simulation.spatial import Array

HORIZON = 1.6
"""Cycles ahead: a swing, the stance after it, and the start of the next swing."""

MOST_STEPS = 600
"""Bound on the steps, of creatures that hardly move."""

SLOPES = 12
"""Places ahead at which slopes change the speed."""

LEAST_PART = 0.05
"""Least part of a stride in a cycle: legs that are stretched already step once."""


@dataclass(frozen=True, eq=False)
class StandingReach:
    """How far a creature that sets out goes before feet lift that were placed for a slower body.

    Attributes:
        lifts: (n,) phases at which the feet lift.
        distances: (n,) gone since the start at which they are stretched [m].
        end: phase from which on nothing holds the creature back.
    """

    lifts: Array
    distances: Array
    end: float

    def stride_part(self, phase: float, distance: float, stride: float) -> float:
        """Return the part of a stride in a cycle with which a foot is stretched when it lifts."""
        left = self.lifts - phase
        held = left > 0.0
        if phase >= self.end or not held.any():
            return math.inf
        room = np.maximum(self.distances - distance, 0.0)[held]
        return max(float((room / np.maximum(left[held] * stride, 1e-9)).min()), LEAST_PART)


@dataclass(frozen=True, eq=False)
class SpeedForecast:
    """The way of one creature.

    Attributes:
        phases: (n,) ascending, from now on.
        distances: (n,) gone since the start [m].
        fractions: (n,) of its speed.
        before: distance of a cycle just now [m].
    """

    phases: Array
    distances: Array
    fractions: Array
    before: float

    def distance(self, phases: Array) -> Array:
        """Return the distances (...) at phases (...) [m]."""
        since = np.minimum(phases - self.phases[0], 0.0)
        result: Array = np.interp(phases, self.phases, self.distances) + since * self.before
        return result

    def fraction(self, phases: Array) -> Array:
        """Return the speed fractions (...) at phases (...)."""
        result: Array = np.interp(phases, self.phases, self.fractions)
        return result


def speed_forecast(
    progress: RouteProgress, c: int, standing: StandingReach | None = None
) -> SpeedForecast:
    """Return the forecast of creature `c` if it gets no orders.

    Args:
        progress: of the herd.
        c: number of the creature.
        standing: how far its standing feet let it go; None if it does not set out.
    """
    limits, route = progress.limits, progress.trajectory.routes[c]
    distance, phase, fraction = (float(values[c]) for values in progress.sample)
    grid = phase + HORIZON * np.linspace(0.0, 1.0, 33)
    strides = progress.paces.number("stride", c, grid).tolist()
    braking = max(float(limits.braking_distance[c]), 1e-9)
    targets, ahead = _targets(progress, c, max(strides))
    step, rise, fall = (
        float(values[c]) for values in (progress.phase_per_step, limits.rise, limits.fall)
    )
    curve, restart = limits.curves.get(c), float(progress.restart_phase[c])
    end, last, rests = route.length, phase + HORIZON, bool(progress.arrived[c])
    rows = [(phase, distance, fraction)]
    for _ in range(MOST_STEPS):
        if phase >= last:
            break
        slope = min(int((distance - rows[0][1]) / ahead), SLOPES - 1)
        part, wanted = math.inf, progress.ramped(targets[slope], phase, restart)
        if curve is not None:
            part, most = curve.at(distance)
            wanted = min(wanted, most)
        if standing is not None:
            held = standing.stride_part(phase, distance, float(progress.stride[c]))
            part, wanted = min(part, held), min(wanted, held)
        left = route.distance_to_rest(distance)
        if left < math.inf:
            wanted = min(wanted, max(math.sqrt(max(left, 0.0) / braking), MIN_SPEED_FRACTION))
        wanted = 0.0 if rests else wanted
        faster = rise * (1.0 if fraction < 1.0 else HURRY_RISE)
        after = min(max(wanted, fraction - fall), fraction + faster)
        mean, rate = 0.5 * (fraction + after), 0.5 * (math.sqrt(fraction) + math.sqrt(after))
        rate = max(rate, min(mean / part, 1.0)) if after > 0.0 else 1.0
        at = int(32.0 * (phase - rows[0][0]) / HORIZON)
        distance = min(distance + mean * step * strides[at], max(end, distance))
        phase, fraction = phase + rate * step, after
        rests = rests or end - distance <= ARRIVAL_DISTANCE
        rows.append((phase, distance, fraction))
    present = rows[0][2]
    rate = max(math.sqrt(present), 1e-3)
    if curve is not None:
        rate = max(rate, min(present / curve.at(rows[0][1])[0], 1.0))
    phases, distances, fractions = np.array(rows).T
    return SpeedForecast(phases, distances, fractions, strides[0] * present / rate)


def _targets(progress: RouteProgress, c: int, stride: float) -> tuple[list[float], float]:
    """Return the speed fractions that creature `c` goes for from here on, and how far each lasts.

    Those are `SLOPES` in number; they last some metres [m]. Its strides are `stride` at most [m].
    """
    target, fastest = float(progress.limits.target[c]), float(progress.requested_fraction[c])
    each = HORIZON * stride * max(fastest, float(progress.speed_fraction[c])) / SLOPES
    each = max(each, 1e-6)
    ahead = float(progress.distance[c]) + each * np.arange(SLOPES, dtype=np.float64)
    slopes = slope_fractions(progress.trajectory, np.full(SLOPES, c), ahead)
    wanted = np.maximum(fastest * slopes, MIN_SPEED_FRACTION) if target > 0.0 else 0.0 * slopes
    # Until the next sample of the slope the speed stays what it is.
    wanted[0] = target
    return wanted.tolist(), each
