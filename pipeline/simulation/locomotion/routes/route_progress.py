"""Route progress: how far creatures have gone along their routes, and how their speed changes.

The speed fraction is a creature's speed relative to its pace. Slower, it takes shorter steps and
takes them less often: stride and cadence share the change, each by its root, as animals do. It
slows down uphill and downhill, and before the end of its route, so that it comes to rest there;
then its feet close up.

Source: Sims 1987, 3.2.3 and 10.1; Alexander 1989 for how stride and cadence grow with speed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.locomotion.body_motion.gaze import LookTargets
from pipeline.simulation.locomotion.gaits.moods import MoodSchedule
from pipeline.simulation.locomotion.gaits.pace import is_same_pace
from pipeline.simulation.locomotion.gaits.pace_schedule import PaceSchedule
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.curve_limits import CurveLimits
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.spatial import Array

# Time from rest to full speed and back, in cycles.
RISE_CYCLES, FALL_CYCLES = 1.0, 0.6

# Factor on the rate at which speed grows beyond the pace's own: feet are placed for a body that
# goes on as fast as it does.
HURRY_RISE = 0.3

# Shortest time [s], and usual deceleration [m/s²], of a stop without foothold.
MIN_STOP_TIME, SOFT_DECELERATION = 0.3, 3.0

# Greatest deceleration of a planned stop [m/s²].
MAX_DECELERATION = 4.0

# Least speed fraction, at which the last bit of a route is gone.
MIN_SPEED_FRACTION = 0.02

# Parts of a pace's speed that an order may ask for where a mood gives another speed.
LEAST_PART, MOST_PART = 0.7, 1.2

# Distance within which a creature is at the end of its route [m].
ARRIVAL_DISTANCE = 1e-9

# Speed fraction at the start from rest, and cycles until full speed: the feet start from their
# rest positions, not from those of a walk.
START_SPEED_FRACTION, START_RAMP_CYCLES = 0.1, 2.0


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
        curves: limits on narrow curves, by creature.
    """

    target: Array
    rise: Array
    fall: Array
    braking_distance: Array
    curved: list[int]
    route_ends: Array | None
    curves: Mapping[int, CurveLimits]


@dataclass(slots=True, eq=False)
class RouteProgress:
    """The progress of a herd.

    Arrays that may be read later, as part of a moment, are replaced and never written to.

    Attributes:
        herd, trajectory, moods, dt: of the creatures; step [s].
        distance: (C,) gone [m].
        phase: (C,) of the gait, whole cycles counted.
        speed_fraction: (C,) speed relative to the pace.
        stride_part: (C,) distance of a cycle at the present speed, in strides.
        smoothed_fraction, lagged_fraction: (C,) speed fraction that bodies show, without corners,
            and the first of the two lags that lead to it.
        hurrying: creatures that go as fast as animals do that hurry.
        requested_fraction: (C,) for level ground, of the pace that they have or change to.
        slope_fraction: (C,) that suits the slope.
        halted: (C,) whether it found no foothold.
        closing_phase: (C,) at which its feet have closed up; infinite while it walks.
        restart_phase: (C,) at which it set out from rest; minus infinity long after.
        resume_phase: (C,) at which it set out, or went on while it braked; likewise.
        cycle, stride: (C,) duration [s] and length [m] of a cycle at full speed.
        phase_per_step: (C,) at full speed.
        blocked_at: (C,) distance at which a barrier ends its route, NaN without one [m].
        transition_ends: phases at which changes of pace end, by creature.
        stopping_distances: from full speed, of creatures that brake harder than usual [m].
        look_targets: of the creatures.
        steps: done since the start.
        next_slope_sample: number of the sample.
        limits: bounds on the speed.
        steady_step: distance and phase of a step while nothing changes.
        known_curves: what limits on curves depend on, and they, by creature.
    """

    herd: Herd
    trajectory: BodyTrajectory
    moods: MoodSchedule
    dt: float
    distance: Array
    phase: Array
    speed_fraction: Array
    stride_part: Array
    smoothed_fraction: Array
    lagged_fraction: Array
    hurrying: set[int]
    requested_fraction: Array
    slope_fraction: Array
    halted: NDArray[np.bool_]
    closing_phase: Array
    restart_phase: Array
    resume_phase: Array
    cycle: Array
    stride: Array
    phase_per_step: Array
    blocked_at: Array
    transition_ends: dict[int, float]
    stopping_distances: dict[int, float]
    look_targets: LookTargets
    limits: SpeedLimits
    steps: int = 0
    next_slope_sample: int = 0
    steady_step: tuple[Array, Array] | None = None
    known_curves: dict[int, tuple[tuple[float, ...], Route, CurveLimits | None]] = field(
        default_factory=dict
    )

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

    def braking_room(self, c: int) -> float:
        """Return the distance to rest from full speed, or a higher one that is asked for [m]."""
        fraction = max(1.0, float(self.requested_fraction[c]), float(self.speed_fraction[c]))
        return float(self.braking_distance[c]) * fraction * fraction

    @property
    def can_rest(self) -> bool:
        """Whether any creature rests, or may come to rest at the end of its route."""
        return self.limits.route_ends is not None

    @property
    def arrived(self) -> NDArray[np.bool_]:
        """(C,) whether it has come to the end of its route."""
        return np.isfinite(self.closing_phase)

    def ramped(self, target: float, phase: float, restart: float) -> float:
        """Return a target speed fraction at a phase, less while a creature sets out from rest."""
        return min(target, START_SPEED_FRACTION + (phase - restart) / START_RAMP_CYCLES)

    @property
    def sample(self) -> ProgressSample:
        """The present progress."""
        return ProgressSample(self.distance, self.phase, self.speed_fraction)


def start_progress(
    herd: Herd,
    trajectory: BodyTrajectory,
    moods: MoodSchedule,
    dt: float,
    look_targets: LookTargets,
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
        stride_part=np.sqrt(walking),
        smoothed_fraction=walking.copy(),
        lagged_fraction=walking.copy(),
        hurrying=set(),
        requested_fraction=np.ones(count),
        slope_fraction=np.ones(count),
        halted=np.zeros(count, dtype=bool),
        closing_phase=np.full(count, np.inf),
        restart_phase=np.full(count, -np.inf),
        resume_phase=np.full(count, -np.inf),
        cycle=herd.cycle.copy(),
        stride=herd.stride.copy(),
        phase_per_step=np.where(herd.walks, dt / herd.cycle, 0.0),
        blocked_at=np.full(count, np.nan),
        transition_ends={},
        stopping_distances={},
        look_targets=look_targets,
        limits=SpeedLimits(none, none, none, none, [], None, {}),
    )
    update_limits(progress)
    return progress


# --- changes ------------------------------------------------------------------------


def redirect(progress: RouteProgress, c: int, route: Route) -> None:
    """Give creature `c` another route, the same as before up to where it is."""
    if progress.halted[c]:
        return
    before = progress.trajectory.routes[c]
    progress.trajectory.set_route(c, route)
    if route.length > before.length:
        progress.stopping_distances.pop(c, None)
    if route.length > progress.distance[c] + ARRIVAL_DISTANCE:
        is_braking = before.length - progress.distance[c] < progress.braking_room(c)
        if is_braking and route.length > before.length:
            progress.resume_phase[c] = progress.phase[c]
        if progress.arrived[c]:
            progress.restart_phase[c] = progress.phase[c]
        progress.closing_phase[c] = np.inf
    update_limits(progress)


def choose_speed(progress: RouteProgress, c: int, speed: float) -> float:
    """Let a creature go at a speed from now on, and return what becomes of it [m/s]."""
    moods, now = progress.moods, progress.moods.pace(c)
    # A mood changes the speed by about the same part at all speeds.
    moods.keep_speed(c, speed * moods.neutral[c].speed / now.speed)
    progress.hurrying.discard(c)
    update_pace(progress, c, speed)
    last = progress.paces.last(c)
    return float(progress.requested_fraction[c]) * last.speed


def update_pace(progress: RouteProgress, c: int, speed: float | None = None) -> None:
    """Let a creature go in its gait and mood at the speed that was chosen, or hurry.

    Gait, stride, cadence and duty factor change with the speed as those of animals do. From one
    gait to another that is not the next faster or slower one it goes through those between.

    Args:
        progress: of the herd.
        c: number of the creature.
        speed: that its mood has to give; what becomes of the chosen one if None [m/s].
    """
    moods = progress.moods
    neutral = moods.neutral[c]
    if c in progress.hurrying and neutral.hurried_speed > neutral.speed:
        neutral = moods.neutral_at(c, neutral.hurried_speed)
    pace, last = moods.in_mood(c, neutral), progress.paces.last(c)
    asked = 1.0 if speed is None else speed / pace.speed
    progress.requested_fraction[c] = min(max(asked, LEAST_PART), MOST_PART)
    if not is_same_pace(pace, last):
        for between in moods.between(c, last, neutral):
            progress.paces.change(c, moods.in_mood(c, between), float(progress.phase[c]))
        end = progress.paces.change(c, pace, float(progress.phase[c]))
        progress.transition_ends[c] = end
    update_limits(progress)


def set_initial_speed(progress: RouteProgress, fraction: Array) -> None:
    """Start at fractions (C,) of the speed fractions that creatures would come with."""
    progress.speed_fraction = progress.speed_fraction * fraction
    progress.stride_part = np.sqrt(progress.speed_fraction)
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
    stop_within(progress, c, room)
    progress.halted[c] = True
    update_limits(progress)


def stop_within(progress: RouteProgress, c: int, room: float) -> None:
    """Bring a creature to rest within `room`, however hard it has to brake [m]."""
    fraction = max(float(progress.speed_fraction[c]), MIN_SPEED_FRACTION)
    route = progress.trajectory.routes[c]
    redirect(progress, c, route.upto(min(float(progress.distance[c]) + room, route.length)))
    progress.stopping_distances[c] = room / (fraction * fraction)
    update_limits(progress)
    progress.blocked_at[c] = progress.trajectory.routes[c].length


def is_blocked(progress: RouteProgress, c: int) -> bool:
    """Return whether a creature's route ends at a barrier."""
    return bool(progress.trajectory.routes[c].length == progress.blocked_at[c])


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
        # A stop without foothold has its own braking distance.
        fall=np.where(progress.halted, 1.0, dt / (FALL_CYCLES * cycle)),
        braking_distance=braking,
        curved=[c for c, route in enumerate(routes) if not route.goes_straight],
        route_ends=length if can_rest else None,
        curves=_curves(progress, braking),
    )


def _curves(progress: RouteProgress, braking: Array) -> dict[int, CurveLimits]:
    """Return the limits on curves, by creature; `braking` (C,) distances from full speed [m]."""
    herd, found = progress.herd, dict[int, CurveLimits]()
    for c, route in enumerate(progress.trajectory.routes):
        if route.goes_straight or not herd.walks[c]:
            continue
        pace, stride = progress.paces.last(c), max(float(progress.stride[c]), 1e-9)
        speed = stride / float(progress.cycle[c])
        key = id(route), pace.longest, stride, speed, float(braking[c])
        known = progress.known_curves.get(c)
        if known is None or known[0] != key:
            feet = herd.rest[herd.owner == c] + [0.0, pace.lateral_offset]
            stance = float(pace.gait.duty.max()) * stride
            limits = CurveLimits.of(route, feet, pace.longest / stride, stance, key[-1], speed)
            known = progress.known_curves[c] = key, route, limits
        if known[2] is not None:
            found[c] = known[2]
    return found
