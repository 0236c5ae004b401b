"""Aiming: with which velocity to leave the ground, and how feet are held out for the landing.

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
    level_height,
    yaw_quaternion,
)
from pipeline.simulation.locomotion.pronking.hopper import (
    LIFT_OFF_STRETCH,
    TOUCH_DOWN_STRETCH,
    Hopper,
)
from pipeline.simulation.scalar_rotation import (
    Quaternion,
    from_rotation_vector,
    matrix_rows,
    quaternion_product,
)
from pipeline.simulation.spatial import Array, heading
from pipeline.simulation.terrain import Ground

MAX_FOOT_ADVANCE = 0.5
"""How far ahead feet are held for a landing at most, in leg lengths."""

FALL_SAMPLES = 48
"""Moments of a fall at which the ground is looked at."""

AIM_ITERATIONS = 14
"""In which a jump comes to where it is aimed."""

LEAN_FRACTION, MAX_LEAN = 0.6, 0.35
"""Part of a slope that bodies lean with, and how far at most [rad]."""

LANDING_MARGIN, LANDING_OFFSETS = (
    0.09,
    np.array([[0.0, 1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, -1.0]]),
)
"""How far around the place of a foot the ground is to be good as well, in leg lengths, and where:
a foot that comes down askew touches a little beside."""

MIN_PUSH = 0.04
"""Way of a push at least, in leg lengths."""

SPEED_SCALES = (1.0, 0.85, 1.15, 0.65, 0.4, 0.2)
TURN_ANGLES = tuple(math.radians(a) for a in (0, 12, -12, 30, -30, 55, -55))
"""Jumps that are tried where landings are chosen, by the one that is asked for."""


@dataclass(frozen=True, eq=False)
class JumpPlan:
    """A jump that is about to be made.

    Attributes:
        velocity: (3,) at lift-off [m/s].
        rise: of the centre of mass until then [m].
        flight: how long it will be in the air [s].
        ends: (n, 3) where feet are held for the landing, in the frame of the body [m].
        attitude: of the body when it lands.
        spot: (x, z) middle of the feet then [m].
    """

    velocity: Array
    rise: float
    flight: float
    ends: Array
    attitude: Quaternion
    spot: Array


def plan_jump(of: Hopper, state: HopState, ground: Ground) -> tuple[JumpPlan, bool]:
    """Return the next jump, and whether its landing is where it may be."""
    words, course = of.words, state.course
    if course.leap is not None:
        return plan_requested_jump(of, state, ground, course.leap), True
    if words.land_at:
        k = min(course.made, len(words.land_at) - 1)
        spot = np.array(words.land_at[k], dtype=float)
        up = _upward_speed(of, state, ground, spot)
        return _jump_to_spot(of, state, ground, spot, up, _landing_heading(of, state, spot)), True
    way = course.jump.forward
    first = _jump_straight(of, state, ground, way, state.going)
    if not words.avoid or _is_steppable(of, ground, first):
        return first, True
    for scale, turn in _alternatives():
        other = _jump_straight(of, state, ground, scale * way, state.going + turn)
        if _is_steppable(of, ground, other):
            return other, True
    return _jump_straight(of, state, ground, 0.0, state.going), False


def plan_requested_jump(
    of: Hopper, state: HopState, ground: Ground, leap: PlannedJump, rounds: int = AIM_ITERATIONS
) -> JumpPlan:
    """Return how to make a jump that was asked for, in fewer rounds only about."""
    if leap.spot is not None:
        spot = np.array(leap.spot)
        return _jump_to_spot(of, state, ground, spot, leap.up, leap.facing, rounds)
    x, z = leap.forward * np.array([math.cos(state.going), -math.sin(state.going)])
    return _jump_with_velocity(of, state, ground, np.array([x, leap.up, z]), leap.facing)


def has_next_jump(of: Hopper, state: HopState) -> bool:
    """Tell whether it is to jump again."""
    return bool(state.course.errands) or _has_own_jump(of, state, state.course.made)


def _has_own_jump(of: Hopper, state: HopState, made: int) -> bool:
    """Tell whether it jumps by its words when it has made so many such jumps."""
    words = of.words
    if not state.course.onward:
        return False
    if words.land_at:
        return made < len(words.land_at)
    return words.jumps is None or made < words.jumps


def _alternatives() -> Iterator[tuple[float, float]]:
    pairs = [(s, t) for s in SPEED_SCALES for t in TURN_ANGLES]
    yield from sorted(pairs, key=lambda one: 2.0 * abs(one[0] - 1.0) + abs(one[1]))[1:]


def _is_steppable(of: Hopper, ground: Ground, one: JumpPlan) -> bool:
    """Tell whether all feet land where they may be put."""
    R = np.array(matrix_rows(one.attitude))
    feet = (one.ends - one.ends.mean(axis=0)) @ R.T
    x, z = one.spot[0] + feet[:, 0], one.spot[1] + feet[:, 2]
    around = LANDING_MARGIN * of.leg * LANDING_OFFSETS
    return bool(ground.steppable(x[:, None] + around[0], z[:, None] + around[1]).all())


def _jump_straight(
    of: Hopper, state: HopState, ground: Ground, way: float, going: float
) -> JumpPlan:
    up = state.course.jump.up
    v = np.array([way * math.cos(going), up, -way * math.sin(going)])
    return _jump_with_velocity(of, state, ground, v, state.facing)


def _upward_speed(of: Hopper, state: HopState, ground: Ground, spot: Array) -> float:
    """Return with which upward speed to jump to a spot (x, z) [m/s]."""
    height = float(ground.height(spot[0], spot[1]))
    stands = state.p[1] - of.mass.centre[1] - of.crouch
    # The top of the way is to be above the spot by half the height of a jump at least.
    return math.sqrt(2.0 * GRAVITY * (state.course.jump.height + max(height - stands, 0.0)))


def _jump_to_spot(
    of: Hopper,
    state: HopState,
    ground: Ground,
    spot: Array,
    up: float,
    facing: float,
    rounds: int = AIM_ITERATIONS,
) -> JumpPlan:
    """Return the jump that lands at a spot (x, z)."""
    height = float(ground.height(spot[0], spot[1]))
    v = np.array([0.0, up, 0.0])
    lean = leaning_attitude(of, ground, spot[0], spot[1], facing)
    R = np.array(matrix_rows(lean))
    for _ in range(rounds):
        rise, _, p1 = lift_off_point(of, state, v)
        ends = landing_feet(
            of, R, v, up, _is_last_jump(of, state), _lift_off_height(of, state, rise)
        )
        middle = R @ (ends - [0.0, 1.0, 0.0] * of.soles[:, None]).mean(axis=0) - (
            R @ of.mass.centre
        )
        fall = up * up - 2.0 * GRAVITY * (height - middle[1] - p1[1])
        time = (up + math.sqrt(max(fall, 0.0))) / GRAVITY
        # A faster jump leaves later and lands farther ahead, which asks for a slower one: the
        # middle between both is nearer than either.
        x, z = (spot[0] - middle[0] - p1[0]) / time, (spot[1] - middle[2] - p1[2]) / time
        v = 0.5 * (v + np.array([x, up, z]))
    return JumpPlan(v, rise, time, ends, lean, spot)


def _landing_heading(of: Hopper, state: HopState, spot: Array) -> float:
    """Return where to look when it has landed: to the next spot, or as it came."""
    spots, k = of.words.land_at, state.course.made
    here = spot if k + 1 < len(spots) else np.array([state.p[0], state.p[2]])
    there = np.array(spots[k + 1], dtype=float) if k + 1 < len(spots) else spot
    way = there - here
    return math.atan2(-way[1], way[0]) if math.hypot(*way) > 0.1 * of.leg else state.facing


def _is_last_jump(of: Hopper, state: HopState) -> bool:
    """Tell whether the jump that is about to be made is the last one."""
    course = state.course
    if course.leap is None:
        return not course.errands and not _has_own_jump(of, state, course.made + 1)
    more = len(course.errands) > 1 or not course.leap.last
    return not more and not _has_own_jump(of, state, course.made)


def _jump_with_velocity(
    of: Hopper, state: HopState, ground: Ground, v: Array, facing: float
) -> JumpPlan:
    """Return how a jump will land that leaves the ground with a velocity (3,)."""
    rise, _, p1 = lift_off_point(of, state, v)
    time = 2.0 * v[1] / GRAVITY
    attitude = yaw_quaternion(facing)
    for last in (False, False, True):
        R = np.array(matrix_rows(attitude))
        falls, above = max(GRAVITY * time - v[1], 0.3 * v[1]), _lift_off_height(of, state, rise)
        ends = landing_feet(of, R, v, falls, _is_last_jump(of, state), above)
        time, spot = _find_landing(of, ground, p1, v, R, ends)
        # Feet land where they do with the attitude that they are held out for.
        attitude = attitude if last else leaning_attitude(of, ground, spot[0], spot[1], facing)
    return JumpPlan(v, rise, time, ends, attitude, spot)


def _find_landing(
    of: Hopper, ground: Ground, p1: Array, v: Array, R: Array, ends: Array
) -> tuple[float, Array]:
    """Return when feet (n, 3) that are held so are on the ground, and (x, z) of their middle."""
    feet = (ends - of.mass.centre) @ R.T + p1
    low = float(ground.field.heights.min()) - 1.0
    top = v[1] / GRAVITY
    last = top + math.sqrt(2.0 * max(float(feet[:, 1].max()) + 0.5 * v[1] * top - low, 0.1) / 9.0)

    def gaps(times: Array) -> Array:
        t = times[:, None]
        x, z = feet[:, 0] + v[0] * t, feet[:, 2] + v[2] * t
        y = feet[:, 1] + v[1] * t - 0.5 * GRAVITY * t * t
        result: Array = (y - of.soles - ground.height(x, z)).mean(axis=-1)
        return result

    times = np.linspace(top, last, FALL_SAMPLES)
    below = gaps(times) <= 0.0
    k = int(below.argmax()) if below.any() else FALL_SAMPLES - 1
    time = float(times[k])
    if 0 < k and below[k]:
        time = find_crossing(lambda t: float(gaps(np.array([t]))[0]), float(times[k - 1]), time)
    middle = feet.mean(axis=0) + time * v
    return time, middle[[0, 2]]


def landing_feet(
    of: Hopper, R: Array, v: Array, falls: float, stops: bool, highest: float = math.inf
) -> Array:
    """Return where feet (n, 3) are held for a landing, in the frame of the body [m].

    They are so far ahead that the body is above them when the landing ends.

    Args:
        of: whose.
        R: (3, 3) attitude with which it lands.
        v: (3,) velocity, of which the horizontal counts [m/s].
        falls: speed of the fall [m/s].
        stops: whether it stops there.
        highest: height of the body above the ground at most, that of its lift-off [m].
    """
    x, _, z = (R.T @ np.array([v[0], 0.0, v[2]])).tolist()
    least, share = of.crouch + 0.05 * of.leg, 0.5 if stops else 1.0

    def height(time: float) -> float:
        return max(min(of.tallest(TOUCH_DOWN_STRETCH, time * x, time * z), highest), least)

    def takes(tall: float) -> float:
        return 2.0 * share * (tall - of.crouch) / falls

    # The farther ahead feet are, the lower the body, and the sooner the landing ends.
    time = takes(height(0.0))
    if takes(height(time)) < time:
        time = find_crossing(lambda t: takes(height(t)) - t, 0.0, time)
    size = math.hypot(x, z)
    far = MAX_FOOT_ADVANCE * of.leg
    if time * size > far:
        time = far / size
    tall = max(min(height(time), of.crouch + 0.5 * time * falls / share), least)
    ahead, aside = time * x, time * z
    ends: Array = of.rest + np.array([ahead, -tall, aside])
    ends[:, 1] += of.soles
    return ends


def lift_off_point(of: Hopper, state: HopState, v: Array) -> tuple[float, float, Array]:
    """Return how far to push before lift-off, how long that takes, and where (3,) that is.

    It is the longest way at whose end all feet that are down still reach the ground.

    Args:
        of: who pushes.
        state: at the begin of the push.
        v: (3,) velocity at lift-off [m/s].
    """
    R = np.array(matrix_rows(state.turning[0]))
    own = state.down
    arms = (of.hips[own] - of.mass.centre) @ R.T - state.tips[own]
    reach = (LIFT_OFF_STRETCH * of.lengths[own]) ** 2
    mean = 0.5 * (state.v + v)

    def there(rise: float) -> Array:
        place: Array = state.p + (rise / mean[1]) * mean
        return place

    def spare(rise: float) -> float:
        way = arms + there(rise)
        return float((reach - (way * way).sum(axis=-1)).min())

    least, most = MIN_PUSH * of.leg, 2.0 * of.leg
    rise = least
    if spare(least) > 0.0:
        rise = find_crossing(spare, least, most) - 1e-12
    return rise, rise / float(mean[1]), there(rise)


def _lift_off_height(of: Hopper, state: HopState, rise: float) -> float:
    """Return the height of the body above its footholds at lift-off [m]."""
    return level_height(of, state.p) + rise - state.floor


def leaning_attitude(of: Hopper, ground: Ground, x: float, z: float, facing: float) -> Quaternion:
    """Return the attitude of a body that looks along a heading and leans with its ground."""
    (c, _, s), (_, _, _), (_, _, _) = heading(facing).tolist()
    a, b = (float(w) for w in of.wide)
    # Forward is (c, -s) and to the right (s, c) in x and z.
    around = ground.height(
        x + np.array([a * c, -a * c, b * s, -b * s]), z + np.array([-a * s, a * s, b * c, -b * c])
    )
    ahead, back, right, left = (float(h) for h in around)
    pitch, roll = (
        LEAN_FRACTION * (ahead - back) / (2.0 * a),
        LEAN_FRACTION * (right - left) / (2.0 * b),
    )
    size = math.hypot(pitch, roll)
    k = math.tanh(size / MAX_LEAN) * MAX_LEAN / size if size > 1e-12 else 0.0
    q = quaternion_product(
        from_rotation_vector((0.0, facing, 0.0)),
        from_rotation_vector((-k * roll, 0.0, k * pitch)),
    )
    return q


TIME_TOLERANCE = 1e-13
"""Time within which an event is located [s]."""

MAX_ITERATIONS = 60


def find_crossing(gap: Callable[[float], float], left: float, right: float) -> float:
    """Return the time at which `gap` has just come to 0 or less, by regula falsi and halving.

    Args:
        gap: of the time; positive at `left`, 0 or less at `right`.
        left: [s].
        right: [s].
    """
    at_left, at_right = gap(left), gap(right)
    for k in range(MAX_ITERATIONS):
        if right - left <= TIME_TOLERANCE or at_right == 0.0:
            break
        middle = 0.5 * (left + right)
        # Every third time in the middle: a jump of the gap would hold one end for ever.
        if k % 3 != 2 and at_left < math.inf and at_right > -math.inf:
            between = left + (right - left) * at_left / (at_left - at_right)
            middle = between if left < between < right else middle
        value = gap(middle)
        if value > 0.0:
            left, at_left = middle, value
        else:
            right, at_right = middle, value
    return right
