"""Speed control: how creatures speed up and slow down along their routes.

A creature slows down uphill and downhill, and before the end of its route, so that it comes to rest
there; then its feet close up. Stride and cadence share a change of speed, each by its root, as
animals do.

Source: Sims 1987, 3.2.3 and 10.1; Alexander 1989 for how stride and cadence grow with speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.locomotion.routes.route_progress import (
    ARRIVAL_DISTANCE,
    HURRY_RISE,
    MIN_SPEED_FRACTION,
    START_RAMP_CYCLES,
    START_SPEED_FRACTION,
    ProgressSample,
    RouteProgress,
    update_limits,
)
from pipeline.simulation.spatial import Array

# Lag of the speed fraction that bodies show, applied twice, in cycles; and difference that does not
# show.
SMOOTHING_CYCLES, SMOOTHING_TOLERANCE = 0.08, 1e-5

# Extra time on a slope of 1, as a fraction of that on level ground.
UPHILL_COST, DOWNHILL_COST = 0.9, 0.5

# Rate at which slopes are sampled, whatever the length of a step [1/s].
SLOPE_SAMPLES_PER_SECOND = 8

# Cycles in which feet close up after the body has come to rest.
CLOSING_CYCLES = 1.0


def advance(
    progress: RouteProgress, airborne: NDArray[np.bool_], most: Array | None = None
) -> None:
    """Advance by one step.

    Args:
        progress: of the herd.
        airborne: (C,) creatures with a foot in the air, which is brought down in any case.
        most: (C,) greatest parts of a stride that feet bear in a cycle; None without bounds.
    """
    sample = round(progress.steps * progress.dt * SLOPE_SAMPLES_PER_SECOND, 6)
    if sample >= progress.next_slope_sample:
        progress.slope_fraction = _slope_fraction(progress)
        progress.next_slope_sample = math.floor(sample) + 1
        update_limits(progress)
    progress.steps += 1
    if progress.transition_ends:
        _follow_pace_changes(progress)
    if progress.steady_step is not None and most is None:
        step, turn = progress.steady_step
        progress.distance, progress.phase = progress.distance + step, progress.phase + turn
        return
    before, limits = progress.speed_fraction, progress.limits
    target = limits.target
    if limits.route_ends is not None:
        target = np.minimum(target, _braking_fraction(progress))
    target = _ramped(progress, target, progress.phase)
    target, most = _in_curves(progress, target, most)
    progress.speed_fraction, step, rate = _next_speed(progress, before, target, most)
    over = progress.phase >= progress.restart_phase + START_RAMP_CYCLES
    progress.restart_phase[over] = -np.inf
    _smooth_speed(progress)
    if limits.route_ends is not None:
        step, rate = _near_route_end(progress, limits.route_ends, step, rate, airborne)
    turn = rate * progress.phase_per_step
    progress.stride_part = step / np.maximum(turn * progress.stride, 1e-12)
    progress.distance, progress.phase = progress.distance + step, progress.phase + turn
    is_steady = (before == progress.limits.target).all()
    is_steady &= (progress.smoothed_fraction == progress.speed_fraction).all()
    changes = progress.transition_ends or progress.limits.curves
    if progress.limits.route_ends is None and not changes and is_steady:
        progress.steady_step = step, turn


def _follow_pace_changes(progress: RouteProgress) -> None:
    """Set cycle and stride of creatures that change their pace."""
    for c, end in list(progress.transition_ends.items()):
        at = progress.phase[c : c + 1]
        progress.cycle[c] = progress.paces.number("cycle", c, at)[0]
        progress.stride[c] = progress.paces.number("stride", c, at)[0]
        progress.phase_per_step[c] = progress.dt / progress.cycle[c]
        if progress.phase[c] >= end:
            del progress.transition_ends[c]
    update_limits(progress)


def predicted(progress: RouteProgress) -> Iterator[ProgressSample]:
    """Yield the progress after each step up to the next slope sample.

    Exact for creatures that get no orders and do not brake.
    """
    distance, phase, fraction = progress.sample
    target = progress.limits.target
    left = progress.next_slope_sample / (progress.dt * SLOPE_SAMPLES_PER_SECOND) - progress.steps
    for _ in range(math.ceil(left - 1e-6)):
        ramped = _ramped(progress, target, phase)
        fraction, step, rate = _next_speed(progress, fraction, ramped)
        distance, phase = distance + step, phase + rate * progress.phase_per_step
        yield ProgressSample(distance, phase, fraction)


def _ramped(progress: RouteProgress, target: Array, phase: Array) -> Array:
    """Return target speed fractions (C,), less while creatures set out from rest."""
    if not np.isfinite(progress.restart_phase).any():
        return target
    since = phase - progress.restart_phase
    return np.minimum(target, START_SPEED_FRACTION + since / START_RAMP_CYCLES)


def _in_curves(
    progress: RouteProgress, target: Array, most: Array | None
) -> tuple[Array, Array | None]:
    """Return target speed fractions and greatest parts of a stride (C,), less in curves."""
    for c, limits in progress.limits.curves.items():
        part, fraction = limits.at(float(progress.distance[c]))
        if fraction == np.inf:
            continue
        most = np.full(len(target), np.inf) if most is None else most
        target, most = target.copy(), most.copy()
        target[c], most[c] = min(target[c], fraction), min(most[c], part)
    return target, most


def _next_speed(
    progress: RouteProgress, before: Array, target: Array, most: Array | None = None
) -> tuple[Array, Array, Array]:
    """Return speed fraction after a step, distance of the step [m], and phase rate, (C,) each."""
    limits = progress.limits
    target = target if most is None else np.minimum(target, most)
    rise = limits.rise * np.where(before < 1.0, 1.0, HURRY_RISE)
    after = np.minimum(np.maximum(target, before - limits.fall), before + rise)
    # The mean of both ends of the step: exact while the speed changes evenly.
    mean = 0.5 * (before + after)
    rate = 0.5 * (np.sqrt(before) + np.sqrt(after))
    if most is not None:
        # Short steps are quick ones.
        rate = np.maximum(rate, np.minimum(mean / most, 1.0))
    return after, mean * progress.phase_per_step * progress.stride, rate


def _smooth_speed(progress: RouteProgress) -> None:
    """Let the bodies' speed fraction follow by two lags, one after the other."""
    fraction, part = progress.speed_fraction, -np.expm1(-progress.phase_per_step / SMOOTHING_CYCLES)
    lagged = progress.lagged_fraction
    lagged = lagged + part * (fraction - lagged)
    smoothed = progress.smoothed_fraction + part * (lagged - progress.smoothed_fraction)
    off = np.maximum(np.abs(fraction - smoothed), np.abs(fraction - lagged))
    near = off < SMOOTHING_TOLERANCE
    progress.smoothed_fraction = np.where(near, fraction, smoothed)
    progress.lagged_fraction = np.where(near, fraction, lagged)


def _braking_fraction(progress: RouteProgress) -> Array:
    """Return the greatest speed fraction (C,) from which all come to rest where they have to."""
    left = np.full(len(progress.distance), np.inf)
    for c in progress.limits.curved:
        route = progress.trajectory.routes[c]
        left[c] = max(route.distance_to_rest(float(progress.distance[c])), 0.0)
    braking = np.maximum(progress.limits.braking_distance, 1e-9)
    fraction = np.maximum(np.sqrt(left / braking), MIN_SPEED_FRACTION)
    return np.where(progress.arrived, 0.0, fraction)


def _near_route_end(
    progress: RouteProgress, ends: Array, step: Array, rate: Array, airborne: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Return distance [m] and phase rate (C,) of this step, where some come to rest."""
    left = np.maximum(ends - progress.distance, 0.0)
    step = np.minimum(step, left)
    # Feet in the air, and those that close up, go on when the body rests.
    is_closing = progress.arrived & ~progress.halted & (progress.phase < progress.closing_phase)
    rests = progress.speed_fraction == 0.0
    rate = np.where(rests, np.where(airborne | is_closing, 1.0, 0.0), rate)
    there = progress.herd.walks & ~progress.arrived & (left - step <= ARRIVAL_DISTANCE)
    if there.any():
        closing = progress.phase + rate * progress.phase_per_step + CLOSING_CYCLES
        progress.closing_phase = np.where(there, closing, progress.closing_phase)
        progress.speed_fraction = np.where(there, 0.0, progress.speed_fraction)
        update_limits(progress)
    return step, rate


def _slope_fraction(progress: RouteProgress) -> Array:
    """Return the speed fractions (C,) that suit the slopes under the bodies."""
    creatures = np.flatnonzero(progress.herd.walks)
    result = np.ones(len(progress.herd.names))
    if len(creatures):
        distance = progress.distance[creatures]
        result[creatures] = slope_fractions(progress.trajectory, creatures, distance)
    return result


def slope_fractions(
    trajectory: BodyTrajectory, creature: NDArray[np.int64], distance: Array
) -> Array:
    """Return the speed fractions (N,) that suit the slopes under bodies.

    Args:
        trajectory: of the herd.
        creature: (N,) numbers of creatures.
        distance: (N,) gone since the start [m].
    """
    xz, headings, _ = trajectory.on_route(creature, distance)
    reach = trajectory.herd.footprint[creature, 0]
    ahead = reach[:, None] * heading_vector(headings)
    ends = np.stack([xz + ahead, xz - ahead], axis=1)
    # The smoothed surface: no single stone slows a body down.
    height, _ = trajectory.surface.heights(creature, ends[..., 0], ends[..., 1])
    slope = (height[:, 0] - height[:, 1]) / (2.0 * reach)
    cost = UPHILL_COST * np.maximum(slope, 0.0) + DOWNHILL_COST * np.maximum(-slope, 0.0)
    result: Array = 1.0 / (1.0 + cost)
    return result
