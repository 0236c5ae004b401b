"""Route progress: how far creatures have gone along their routes, and how their speed changes.

The speed fraction is a creature's speed relative to its pace. Slower, it takes shorter steps and
takes them less often: stride and cadence share the change, each by its root, as animals do. It
slows down uphill and downhill, and before the end of its route, so that it comes to rest there;
then its feet close up.

Source: Sims 1987, 3.2.3 and 10.1; Alexander 1989 for how stride and cadence grow with speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.body_motion.gaze import LookTarget
from pipeline.simulation.locomotion.gaits.moods import MoodSchedule
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.locomotion.gaits.pace_schedule import PaceSchedule
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.route import Route, heading_vector
from pipeline.simulation.spatial import Array

# Time from rest to full speed and back, in cycles.
RISE_CYCLES, FALL_CYCLES = 1.0, 0.6

# Speed fraction with which a creature sets out from rest, and cycles until it reaches all of it:
# its feet are where they rest, not where they would be had it come walking.
START_SPEED_FRACTION, START_RAMP_CYCLES = 0.1, 2.0

# Shortest time [s], and usual deceleration [m/s²], of a stop without foothold.
MIN_STOP_TIME, SOFT_DECELERATION = 0.3, 3.0

# Greatest deceleration of a planned stop [m/s²].
MAX_DECELERATION = 4.0

# Lag of the speed fraction that bodies show, applied twice, in cycles; and difference that does not
# show.
SMOOTHING_CYCLES, SMOOTHING_TOLERANCE = 0.08, 1e-5

# Least speed fraction, at which the last bit of a route is gone.
MIN_SPEED_FRACTION = 0.02

# Extra time on a slope of 1, as a fraction of that on level ground.
UPHILL_COST, DOWNHILL_COST = 0.9, 0.5

# Rate at which slopes are sampled, whatever the length of a step [1/s].
SLOPE_SAMPLES_PER_SECOND = 8

# Cycles in which feet close up after the body has come to rest.
CLOSING_CYCLES = 1.0

# Distance within which a creature is at the end of its route [m].
ARRIVAL_DISTANCE = 1e-9


class ProgressSample(NamedTuple):
    """Distance gone [m], phase of the gait, and speed fraction of all creatures, (C,) each."""

    distance: Array
    phase: Array
    speed_fraction: Array


@dataclass(frozen=True, slots=True, eq=False)
class SpeedLimits:
    """Bounds on the speed that stay the same for a while.

    Attributes:
        target: (C,) speed fraction for the slope, without braking.
        rise, fall: (C,) greatest changes of the speed fraction in a step.
        braking_distance: (C,) from full speed to rest [m].
        curved: creatures whose routes turn or end.
        route_ends: (C,) lengths of the routes [m]; None while nobody can come to rest.
    """

    target: Array
    rise: Array
    fall: Array
    braking_distance: Array
    curved: list[int]
    route_ends: Array | None


@dataclass(slots=True, eq=False)
class RouteProgress:
    """The progress of a herd.

    Arrays that may be read later, as part of a moment, are replaced and never written to.

    Attributes:
        herd, trajectory, moods, dt: of the creatures; step [s].
        distance: (C,) gone [m].
        phase: (C,) of the gait, whole cycles counted.
        speed_fraction: (C,) speed relative to the pace.
        smoothed_fraction, lagged_fraction: (C,) speed fraction that bodies show, without corners,
            and the first of the two lags that lead to it.
        requested_fraction: (C,) ordered for level ground.
        slope_fraction: (C,) that suits the slope.
        halted: (C,) whether it found no foothold.
        closing_phase: (C,) at which its feet have closed up; infinite while it walks.
        restart_phase: (C,) at which it set out from rest; minus infinity long after.
        cycle, stride: (C,) duration [s] and length [m] of a cycle at full speed.
        phase_per_step: (C,) at full speed.
        blocked_at: (C,) distance at which a barrier ends its route, NaN without one [m].
        transition_ends: phases at which changes of pace end, by creature.
        stopping_distances: from full speed, of creatures without a foothold [m].
        look_targets: ordered, by creature; the others look where they go.
        steps: done since the start.
        next_slope_sample: number of the sample.
        limits: bounds on the speed.
        steady_step: distance and phase of a step while nothing changes.
    """

    herd: Herd
    trajectory: BodyTrajectory
    moods: MoodSchedule
    dt: float
    distance: Array
    phase: Array
    speed_fraction: Array
    smoothed_fraction: Array
    lagged_fraction: Array
    requested_fraction: Array
    slope_fraction: Array
    halted: NDArray[np.bool_]
    closing_phase: Array
    restart_phase: Array
    cycle: Array
    stride: Array
    phase_per_step: Array
    blocked_at: Array
    transition_ends: dict[int, float]
    stopping_distances: dict[int, float]
    look_targets: Mapping[int, LookTarget]
    limits: SpeedLimits
    steps: int = 0
    next_slope_sample: int = 0
    steady_step: tuple[Array, Array] | None = None

    @property
    def paces(self) -> PaceSchedule:
        """The paces of the herd."""
        return self.trajectory.paces

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.steps * self.dt

    @property
    def braking_distance(self) -> Array:
        """(C,) distance from full speed to rest [m]."""
        return self.limits.braking_distance

    @property
    def can_rest(self) -> bool:
        """Whether any creature rests, or may come to rest at the end of its route."""
        return self.limits.route_ends is not None

    @property
    def arrived(self) -> NDArray[np.bool_]:
        """(C,) whether it has come to the end of its route."""
        result: NDArray[np.bool_] = np.isfinite(self.closing_phase)
        return result

    @property
    def sample(self) -> ProgressSample:
        """The present progress."""
        return ProgressSample(self.distance, self.phase, self.speed_fraction)


def start_progress(
    herd: Herd,
    trajectory: BodyTrajectory,
    moods: MoodSchedule,
    dt: float,
    look_targets: Mapping[int, LookTarget],
) -> RouteProgress:
    """Return the progress of a herd that comes walking at full speed."""
    count, walking = len(herd.names), np.where(herd.walks, 1.0, 0.0)
    none = np.zeros(count)
    progress = RouteProgress(
        herd=herd,
        trajectory=trajectory,
        moods=moods,
        dt=dt,
        distance=none,
        phase=none.copy(),
        speed_fraction=walking,
        smoothed_fraction=walking.copy(),
        lagged_fraction=walking.copy(),
        requested_fraction=np.ones(count),
        slope_fraction=np.ones(count),
        halted=np.zeros(count, dtype=bool),
        closing_phase=np.full(count, np.inf),
        restart_phase=np.full(count, -np.inf),
        cycle=herd.cycle.copy(),
        stride=herd.stride.copy(),
        phase_per_step=np.where(herd.walks, dt / herd.cycle, 0.0),
        blocked_at=np.full(count, np.nan),
        transition_ends={},
        stopping_distances={},
        look_targets=look_targets,
        limits=SpeedLimits(none, none, none, none, [], None),
    )
    update_limits(progress)
    return progress


# --- changes ------------------------------------------------------------------------


def redirect(progress: RouteProgress, c: int, route: Route) -> None:
    """Give creature `c` another route, the same as before up to where it is."""
    if progress.halted[c]:
        return
    progress.trajectory.set_route(c, route)
    if route.length > progress.distance[c] + ARRIVAL_DISTANCE:
        if progress.arrived[c]:
            progress.restart_phase[c] = progress.phase[c]
        progress.closing_phase[c] = np.inf
    update_limits(progress)


def request_speed(progress: RouteProgress, c: int, fraction: float) -> None:
    """Let a creature walk at another fraction of its pace's speed."""
    progress.requested_fraction[c] = fraction
    update_limits(progress)


def change_pace(progress: RouteProgress, c: int, pace: Pace) -> None:
    """Let a creature change to another pace, at its full speed."""
    phase = float(progress.phase[c])
    progress.transition_ends[c] = progress.paces.change(c, pace, phase)
    request_speed(progress, c, 1.0)


def set_initial_speed(progress: RouteProgress, fraction: Array) -> None:
    """Start at fractions (C,) of the speed fractions that creatures would come with."""
    progress.speed_fraction = progress.speed_fraction * fraction
    progress.smoothed_fraction = progress.lagged_fraction = progress.speed_fraction.copy()


def stand_still(progress: RouteProgress, c: int) -> None:
    """Let a creature that has not set out stay where it is for good."""
    route = progress.trajectory.routes[c].upto(float(progress.distance[c]))
    progress.trajectory.set_route(c, route)
    progress.speed_fraction[c] = 0.0
    progress.smoothed_fraction[c] = progress.lagged_fraction[c] = 0.0
    update_limits(progress)


def stopping_range(progress: RouteProgress, c: int) -> tuple[float, float]:
    """Return the shortest and longest stopping distances of a creature without foothold [m]."""
    v = float(progress.speed_fraction[c] * progress.stride[c] / progress.cycle[c])
    shortest = 0.5 * MIN_STOP_TIME * v
    return shortest, max(shortest, 0.5 * v * v / SOFT_DECELERATION)


def halt(progress: RouteProgress, c: int, room: float) -> None:
    """Bring a creature without foothold to rest for good within `room` [m]."""
    fraction = max(float(progress.speed_fraction[c]), MIN_SPEED_FRACTION)
    route = progress.trajectory.routes[c]
    redirect(progress, c, route.upto(min(float(progress.distance[c]) + room, route.length)))
    progress.halted[c] = True
    progress.stopping_distances[c] = room / (fraction * fraction)
    update_limits(progress)
    progress.blocked_at[c] = progress.trajectory.routes[c].length


def is_blocked(progress: RouteProgress, c: int) -> bool:
    """Return whether a creature's route ends at a barrier."""
    return bool(progress.trajectory.routes[c].length == progress.blocked_at[c])


# --- one step -----------------------------------------------------------------------


def advance(progress: RouteProgress, airborne: NDArray[np.bool_]) -> None:
    """Advance by one step.

    Args:
        progress: of the herd.
        airborne: (C,) creatures with a foot in the air, which is brought down in any case.
    """
    sample = round(progress.steps * progress.dt * SLOPE_SAMPLES_PER_SECOND, 6)
    if sample >= progress.next_slope_sample:
        progress.slope_fraction = _slope_fraction(progress)
        progress.next_slope_sample = math.floor(sample) + 1
        update_limits(progress)
    progress.steps += 1
    if progress.transition_ends:
        _follow_transitions(progress)
    if progress.steady_step is not None:
        step, turn = progress.steady_step
        progress.distance, progress.phase = progress.distance + step, progress.phase + turn
        return
    before, limits = progress.speed_fraction, progress.limits
    target = limits.target
    if limits.route_ends is not None:
        target = np.minimum(target, _braking_fraction(progress))
    target = _ramped(progress, target, progress.phase)
    progress.speed_fraction, step, rate = _next_speed(progress, before, target)
    over = progress.phase >= progress.restart_phase + START_RAMP_CYCLES
    progress.restart_phase[over] = -np.inf
    _smooth_speed(progress)
    if limits.route_ends is not None:
        step, rate = _near_route_end(progress, limits.route_ends, step, rate, airborne)
    turn = rate * progress.phase_per_step
    progress.distance, progress.phase = progress.distance + step, progress.phase + turn
    is_steady = (before == progress.limits.target).all()
    is_steady &= (progress.smoothed_fraction == progress.speed_fraction).all()
    if progress.limits.route_ends is None and not progress.transition_ends and is_steady:
        progress.steady_step = step, turn


def predicted(progress: RouteProgress) -> Iterator[ProgressSample]:
    """Yield the progress after each step up to the next slope sample.

    Exact for creatures that get no orders and do not brake.
    """
    distance, phase, fraction = progress.sample
    target = progress.limits.target
    if progress.can_rest:
        target = np.minimum(target, 1.0)
    left = progress.next_slope_sample / (progress.dt * SLOPE_SAMPLES_PER_SECOND) - progress.steps
    for _ in range(math.ceil(left - 1e-6)):
        ramped = _ramped(progress, target, phase)
        fraction, step, rate = _next_speed(progress, fraction, ramped)
        distance, phase = distance + step, phase + rate * progress.phase_per_step
        yield ProgressSample(distance, phase, fraction)


def update_limits(progress: RouteProgress) -> None:
    """Work out the bounds on the speed again, after a change of what they depend on."""
    herd, dt, cycle = progress.herd, progress.dt, progress.cycle
    rests = progress.arrived | ~herd.walks
    wanted = np.maximum(progress.requested_fraction * progress.slope_fraction, MIN_SPEED_FRACTION)
    v = np.maximum(progress.stride / cycle, 1e-9)
    # From v² = 2 a d, braking at a = v / cycle, and no harder than the greatest deceleration.
    braking = v * v / (2.0 * np.minimum(v / cycle, MAX_DECELERATION))
    for c, distance in progress.stopping_distances.items():
        braking[c] = distance
    routes = progress.trajectory.routes
    length = np.array([route.length for route in routes])
    can_rest = (herd.walks & (np.isfinite(length) | progress.halted)).any()
    progress.steady_step = None
    progress.limits = SpeedLimits(
        target=np.where(rests, 0.0, wanted),
        rise=dt / (RISE_CYCLES * cycle),
        # A stop without foothold has a braking distance of its own.
        fall=np.where(progress.halted, 1.0, dt / (FALL_CYCLES * cycle)),
        braking_distance=braking,
        curved=[c for c, route in enumerate(routes) if not route.goes_straight],
        route_ends=length if can_rest else None,
    )


def _follow_transitions(progress: RouteProgress) -> None:
    """Set cycle and stride of creatures that change their pace."""
    for c, end in list(progress.transition_ends.items()):
        at = progress.phase[c : c + 1]
        progress.cycle[c] = progress.paces.number("cycle", c, at)[0]
        progress.stride[c] = progress.paces.number("stride", c, at)[0]
        progress.phase_per_step[c] = progress.dt / progress.cycle[c]
        if progress.phase[c] >= end:
            del progress.transition_ends[c]
    update_limits(progress)


def _ramped(progress: RouteProgress, target: Array, phase: Array) -> Array:
    """Return target speed fractions (C,), less while creatures set out from rest."""
    if not np.isfinite(progress.restart_phase).any():
        return target
    since = phase - progress.restart_phase
    ramped: Array = np.minimum(target, START_SPEED_FRACTION + since / START_RAMP_CYCLES)
    return ramped


def _next_speed(
    progress: RouteProgress, before: Array, target: Array
) -> tuple[Array, Array, Array]:
    """Return speed fraction after a step, distance of the step [m], and phase rate, (C,) each."""
    limits = progress.limits
    after = np.minimum(np.maximum(target, before - limits.fall), before + limits.rise)
    # The mean of both ends of the step: exact while the speed changes evenly.
    mean = 0.5 * (before + after)
    rate = 0.5 * (np.sqrt(before) + np.sqrt(after))
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
    fraction = np.maximum(np.sqrt(np.minimum(left / braking, 1.0)), MIN_SPEED_FRACTION)
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
    herd, trajectory = progress.herd, progress.trajectory
    creatures = np.flatnonzero(herd.walks)
    result = np.ones(len(herd.names))
    if not len(creatures):
        return result
    xz, headings, _ = trajectory.on_route(creatures, progress.distance[creatures])
    reach = herd.footprint[creatures, 0]
    ahead = reach[:, None] * heading_vector(headings)
    ends = np.stack([xz + ahead, xz - ahead], axis=1)
    # The smoothed surface: no single stone slows a body down.
    height, _ = trajectory.surface.heights(creatures, ends[..., 0], ends[..., 1])
    slope = (height[:, 0] - height[:, 1]) / (2.0 * reach)
    cost = UPHILL_COST * np.maximum(slope, 0.0) + DOWNHILL_COST * np.maximum(-slope, 0.0)
    result[creatures] = 1.0 / (1.0 + cost)
    return result


def braked_distance(distance: Array, left: float, braking: float) -> Array:
    """Return the distances (n,) of a body that brakes, from those of a steady body (n,) [m].

    The speed fraction is the root of what is left over the braking distance, and a cycle's length
    grows with the root of the speed fraction; so with w the steady distance since braking began
    and b the braking distance,

        d left / dw = -(left / b)^(1/4),  left = b (1 - 3 w / 4 b)^(4/3).

    Args:
        distance: at the present speed fraction [m].
        left: until it has to rest [m].
        braking: distance on which it comes to rest from its present speed [m].
    """
    b = min(braking, left)
    if b <= 0.0:
        return np.minimum(distance, max(left, 0.0))
    since = np.maximum(distance - (left - b), 0.0)
    rest = np.maximum(1.0 - 0.75 * since / b, 0.0)
    return np.where(since > 0.0, left - b * np.cbrt(rest) ** 4, distance)
