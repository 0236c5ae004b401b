"""Planning of jumps: lift-off velocity, push, flight, and the feet for the landing.

Source: Sims 1987, 11.1 and 11.3; (11.3) is -2 v_y0 / g, (11.13) to (11.15) are with |g|.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.hop_state import (
    HopState,
    PlannedJump,
    leaning_attitude,
    level_height,
    yaw_quaternion,
)
from pipeline.simulation.locomotion.pronking.hopper import (
    LIFT_OFF_STRETCH,
    TOUCH_DOWN_STRETCH,
    Hopper,
)
from pipeline.simulation.scalar_rotation import Quaternion, rotation_matrix
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground

MAX_FOOT_ADVANCE = 0.5
"""Greatest distance that feet are held ahead for a landing, in leg lengths."""

FALL_SAMPLES = 48
"""Samples of a fall at which the ground height is read."""

AIM_ITERATIONS = 14
"""Iterations that bring a jump to its target."""

LANDING_MARGIN, LANDING_OFFSETS = (
    0.09,
    np.array([[0.0, 1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, -1.0]]),
)
"""Half size of the patch around a foothold that must be steppable, in leg lengths, and its sample
offsets: a foot that comes down askew lands a little beside its foothold."""

MIN_PUSH = 0.04
"""Shortest push, in leg lengths."""

SPEED_SCALES = (1.0, 0.85, 1.15, 0.65, 0.4, 0.2)
"""Speed scales and turns [rad] of the alternative jumps tried to avoid forbidden zones."""
TURN_ANGLES = tuple(math.radians(a) for a in (0, 12, -12, 30, -30, 55, -55))
"""Jumps that are tried where landings are chosen, by the one that is asked for."""


TIME_TOLERANCE = 1e-13
"""Precision of event times [s]."""

TIME_ROUNDING = 1e-9
"""By which the end of a phase may miss its time [s]."""

MAX_ITERATIONS = 60


@dataclass(frozen=True, eq=False)
class JumpPlan:
    """A planned jump.

    Attributes:
        velocity: (3,) at lift-off [m/s].
        rise: of the centre of mass until lift-off [m].
        flight_time: [s].
        landing_feet: (n, 3) feet as held for the landing, in the frame of the body [m].
        attitude: of the body at the landing.
        landing: (x, z) mean of the feet at the landing [m].
    """

    velocity: Array
    rise: float
    flight_time: float
    landing_feet: Array
    attitude: Quaternion
    landing: Array


def plan_jump(hopper: Hopper, state: HopState, ground: Ground) -> tuple[JumpPlan, bool]:
    """Return the next jump, and whether its landing is on allowed ground."""
    config, queue = hopper.config, state.queue
    if queue.planned is not None:
        return plan_requested_jump(hopper, state, ground, queue.planned), True
    if config.land_at:
        k = min(queue.jumps_made, len(config.land_at) - 1)
        target = np.array(config.land_at[k], dtype=float)
        up = _upward_speed(hopper, state, ground, target)
        return _jump_to_target(
            hopper, state, ground, target, up, _landing_heading(hopper, state, target)
        ), True
    speed = queue.jump.forward
    plan = _jump_straight(hopper, state, ground, speed, state.travel_heading)
    if not config.avoid or _is_steppable(hopper, ground, plan):
        return plan, True
    for scale, turn in _alternatives():
        alternative = _jump_straight(
            hopper, state, ground, scale * speed, state.travel_heading + turn
        )
        if _is_steppable(hopper, ground, alternative):
            return alternative, True
    return _jump_straight(hopper, state, ground, 0.0, state.travel_heading), False


def plan_requested_jump(
    hopper: Hopper,
    state: HopState,
    ground: Ground,
    planned: PlannedJump,
    iterations: int = AIM_ITERATIONS,
) -> JumpPlan:
    """Return the plan of a scripted jump; few iterations give it approximately."""
    if planned.target is not None:
        target = np.array(planned.target)
        return _jump_to_target(
            hopper, state, ground, target, planned.up, planned.heading, iterations
        )
    x, z = planned.forward * np.array(
        [math.cos(state.travel_heading), -math.sin(state.travel_heading)]
    )
    return _jump_with_velocity(hopper, state, ground, np.array([x, planned.up, z]), planned.heading)


def has_next_jump(hopper: Hopper, state: HopState) -> bool:
    """Return whether the hopper is to jump again."""
    return bool(state.queue.orders) or _has_own_jump(hopper, state, state.queue.jumps_made)


def _has_own_jump(hopper: Hopper, state: HopState, jumps_made: int) -> bool:
    """Return whether the configuration asks by now for a jump after `jumps_made` of its own."""
    config = hopper.config
    if not state.queue.keep_hopping or state.time < state.queue.hops_from - TIME_ROUNDING:
        return False
    if config.land_at:
        return jumps_made < len(config.land_at)
    return config.jumps is None or jumps_made < config.jumps


def _alternatives() -> Iterator[tuple[float, float]]:
    pairs = [(s, t) for s in SPEED_SCALES for t in TURN_ANGLES]
    yield from sorted(pairs, key=lambda pair: 2.0 * abs(pair[0] - 1.0) + abs(pair[1]))[1:]


def _is_steppable(hopper: Hopper, ground: Ground, plan: JumpPlan) -> bool:
    """Return whether all feet land on steppable ground."""
    R = rotation_matrix(plan.attitude)
    feet = (plan.landing_feet - plan.landing_feet.mean(axis=0)) @ R.T
    x, z = plan.landing[0] + feet[:, 0], plan.landing[1] + feet[:, 2]
    around = LANDING_MARGIN * hopper.leg_length * LANDING_OFFSETS
    return bool(ground.steppable(x[:, None] + around[0], z[:, None] + around[1]).all())


def _jump_straight(
    hopper: Hopper, state: HopState, ground: Ground, speed: float, heading: float
) -> JumpPlan:
    up = state.queue.jump.up
    v = np.array([speed * math.cos(heading), up, -speed * math.sin(heading)])
    return _jump_with_velocity(hopper, state, ground, v, state.next_heading)


def _upward_speed(hopper: Hopper, state: HopState, ground: Ground, target: Array) -> float:
    """Return the upward speed of a jump to a target (x, z) [m/s]."""
    height = float(ground.height(target[0], target[1]))
    stands = state.p[1] - hopper.mass.centre[1] - hopper.crouch_height
    # The apex is to be above the target by the height of a jump.
    return math.sqrt(2.0 * GRAVITY * (state.queue.jump.height + max(height - stands, 0.0)))


def _jump_to_target(
    hopper: Hopper,
    state: HopState,
    ground: Ground,
    target: Array,
    up: float,
    heading: float,
    iterations: int = AIM_ITERATIONS,
) -> JumpPlan:
    """Return the jump that lands at a target (x, z)."""
    height = float(ground.height(target[0], target[1]))
    v = np.array([0.0, up, 0.0])
    lean = leaning_attitude(hopper, ground, target[0], target[1], heading)
    R = rotation_matrix(lean)
    for _ in range(iterations):
        rise, _, p1 = lift_off_point(hopper, state, v)
        feet = landing_feet(
            hopper, R, v, up, _is_last_jump(hopper, state), _lift_off_height(hopper, state, rise)
        )
        middle = R @ (feet - [0.0, 1.0, 0.0] * hopper.foot_radii[:, None]).mean(axis=0) - (
            R @ hopper.mass.centre
        )
        discriminant = up * up - 2.0 * GRAVITY * (height - middle[1] - p1[1])
        time = (up + math.sqrt(max(discriminant, 0.0))) / GRAVITY
        # A faster jump leaves later and lands farther ahead, which asks for a slower one: their
        # mean is closer than either.
        x, z = (target[0] - middle[0] - p1[0]) / time, (target[1] - middle[2] - p1[2]) / time
        v = 0.5 * (v + np.array([x, up, z]))
    return JumpPlan(v, rise, time, feet, lean, target)


def _landing_heading(hopper: Hopper, state: HopState, target: Array) -> float:
    """Return the heading after a landing: towards the next target, or along the jump."""
    targets, k = hopper.config.land_at, state.queue.jumps_made
    here = target if k + 1 < len(targets) else np.array([state.p[0], state.p[2]])
    there = np.array(targets[k + 1], dtype=float) if k + 1 < len(targets) else target
    step = there - here
    return (
        math.atan2(-step[1], step[0])
        if math.hypot(*step) > 0.1 * hopper.leg_length
        else state.next_heading
    )


def _is_last_jump(hopper: Hopper, state: HopState) -> bool:
    """Return whether the hopper stops after the jump that is being planned."""
    queue = state.queue
    if queue.planned is None:
        return not queue.orders and not _has_own_jump(hopper, state, queue.jumps_made + 1)
    has_more = len(queue.orders) > 1 or not queue.planned.is_last
    return not has_more and not _has_own_jump(hopper, state, queue.jumps_made)


def _jump_with_velocity(
    hopper: Hopper, state: HopState, ground: Ground, v: Array, heading: float
) -> JumpPlan:
    """Return the jump that leaves the ground with a velocity (3,)."""
    rise, _, p1 = lift_off_point(hopper, state, v)
    time = 2.0 * v[1] / GRAVITY
    attitude = yaw_quaternion(heading)
    for last in (False, False, True):
        R = rotation_matrix(attitude)
        fall_speed, lift_height = (
            max(GRAVITY * time - v[1], 0.3 * v[1]),
            _lift_off_height(hopper, state, rise),
        )
        feet = landing_feet(hopper, R, v, fall_speed, _is_last_jump(hopper, state), lift_height)
        time, landing = _find_landing(hopper, ground, p1, v, R, feet)
        # The last landing is computed with the attitude that its feet are held out for.
        if not last:
            attitude = leaning_attitude(hopper, ground, landing[0], landing[1], heading)
    return JumpPlan(v, rise, time, feet, attitude, landing)


def _find_landing(
    hopper: Hopper, ground: Ground, p1: Array, v: Array, R: Array, feet: Array
) -> tuple[float, Array]:
    """Return the time at which feet (n, 3) are on the ground, and their mean (x, z) [s, m]."""
    tips = (feet - hopper.mass.centre) @ R.T + p1
    low = float(ground.field.heights.min()) - 1.0
    top = v[1] / GRAVITY
    last = top + math.sqrt(2.0 * max(float(tips[:, 1].max()) + 0.5 * v[1] * top - low, 0.1) / 9.0)

    def gaps(times: Array) -> Array:
        t = times[:, None]
        x, z = tips[:, 0] + v[0] * t, tips[:, 2] + v[2] * t
        y = tips[:, 1] + v[1] * t - 0.5 * GRAVITY * t * t
        return (y - hopper.foot_radii - ground.height(x, z)).mean(axis=-1)

    times = np.linspace(top, last, FALL_SAMPLES)
    below = gaps(times) <= 0.0
    k = int(below.argmax()) if below.any() else FALL_SAMPLES - 1
    time = float(times[k])
    if 0 < k and below[k]:
        time = find_crossing(lambda t: float(gaps(np.array([t]))[0]), float(times[k - 1]), time)
    middle = tips.mean(axis=0) + time * v
    return time, middle[[0, 2]]


def landing_feet(
    hopper: Hopper, R: Array, v: Array, fall_speed: float, stops: bool, max_height: float = math.inf
) -> Array:
    """Return the feet (n, 3) as held for a landing, in the frame of the body [m].

    They are so far ahead that the body is above them when the landing ends.

    Args:
        hopper: the creature.
        R: (3, 3) attitude at the landing.
        v: (3,) velocity; its horizontal part counts [m/s].
        fall_speed: at the landing [m/s].
        stops: whether the body stops there.
        max_height: bound on the body height above the ground: that of its lift-off [m].
    """
    x, _, z = (R.T @ np.array([v[0], 0.0, v[2]])).tolist()
    min_height, share = hopper.crouch_height + 0.05 * hopper.leg_length, 0.5 if stops else 1.0

    def height_at(time: float) -> float:
        return max(
            min(hopper.greatest_height(TOUCH_DOWN_STRETCH, time * x, time * z), max_height),
            min_height,
        )

    def duration_at(height: float) -> float:
        return 2.0 * share * (height - hopper.crouch_height) / fall_speed

    # Feet farther ahead lower the body, which shortens the landing.
    time = duration_at(height_at(0.0))
    if duration_at(height_at(time)) < time:
        time = find_crossing(lambda t: duration_at(height_at(t)) - t, 0.0, time)
    size = math.hypot(x, z)
    max_advance = MAX_FOOT_ADVANCE * hopper.leg_length
    if time * size > max_advance:
        time = max_advance / size
    height = max(
        min(height_at(time), hopper.crouch_height + 0.5 * time * fall_speed / share), min_height
    )
    ahead, aside = time * x, time * z
    ends: Array = hopper.rest_feet + np.array([ahead, -height, aside])
    ends[:, 1] += hopper.foot_radii
    return ends


def lift_off_point(hopper: Hopper, state: HopState, v: Array) -> tuple[float, float, Array]:
    """Return rise and duration of a push, and the centre of mass (3,) at lift-off [m, s, m].

    The push is the longest at whose end all feet that are down still reach the ground.

    Args:
        hopper: the creature.
        state: at the start of the push.
        v: (3,) velocity at lift-off [m/s].
    """
    R = rotation_matrix(state.attitude[0])
    down = state.down
    levers = (hopper.hips[down] - hopper.mass.centre) @ R.T - state.tips[down]
    reach = (LIFT_OFF_STRETCH * hopper.leg_lengths[down]) ** 2
    mean = 0.5 * (state.v + v)

    def place_at(rise: float) -> Array:
        return state.p + (rise / mean[1]) * mean

    def spare_reach(rise: float) -> float:
        span = levers + place_at(rise)
        return float((reach - (span * span).sum(axis=-1)).min())

    min_rise, max_rise = MIN_PUSH * hopper.leg_length, 2.0 * hopper.leg_length
    rise = min_rise
    if spare_reach(min_rise) > 0.0:
        rise = find_crossing(spare_reach, min_rise, max_rise) - 1e-12
    return rise, rise / float(mean[1]), place_at(rise)


def _lift_off_height(hopper: Hopper, state: HopState, rise: float) -> float:
    """Return the body height above the footholds at lift-off [m]."""
    return level_height(hopper, state.p) + rise - state.floor_height


def find_crossing(gap: Callable[[float], float], left: float, right: float) -> float:
    """Return the time at which `gap` first becomes 0 or less, by regula falsi and bisection.

    Args:
        gap: function of time; positive at `left`, 0 or less at `right`.
        left: [s].
        right: [s].
    """
    at_left, at_right = gap(left), gap(right)
    for k in range(MAX_ITERATIONS):
        if right - left <= TIME_TOLERANCE or at_right == 0.0:
            break
        middle = 0.5 * (left + right)
        # Every third step bisects: at a jump of the gap, regula falsi would keep one end forever.
        if k % 3 != 2 and at_left < math.inf and at_right > -math.inf:
            between = left + (right - left) * at_left / (at_left - at_right)
            middle = between if left < between < right else middle
        value = gap(middle)
        if value > 0.0:
            left, at_left = middle, value
        else:
            right, at_right = middle, value
    return right
