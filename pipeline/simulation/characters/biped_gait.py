"""Biped gait: stance feet stay in place, swing feet land where the stride will need them.

A clock at the stride rate gives the turn of each foot; the legs are half a cycle apart. It runs
while the person walks, or while a foot is too far from below its hip, so that a pushed person
steps after the push, a turning person steps round, and a stopping person closes the feet. A foot
swings along a line, arched over the ground, to the place that will be below the hip in the
middle of its stance. `stance_foot` keeps standing feet in place.

Source: Horswill 2008, "Gait Control".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.deck_motion import clear_of_edge, support_at
from pipeline.simulation.characters.gait_timing import (
    RUN_BLEND,
    RUN_FROUDE,
    foot_lag,
    froude,
    gait_pace,
    ground_speed,
    heel_offset,
    leg_length,
    leg_phase,
    run_blend,
    smoothstep,
    staggers,
    walk_share,
    wrap_angle,
)
from pipeline.simulation.characters.hurdles import (
    clear_of_hurdle,
    height_over_hurdle,
    is_stepped_over,
)
from pipeline.simulation.characters.person_record import HIP, STANCE, SWING
from pipeline.simulation.characters.stance_foot import (
    LATERAL_CLEARANCE,
    ahead_and_right,
    ankle_offset,
    other_ankle,
    slope_along,
    stand,
)
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.vectors import Vector, hypotenuse, plus, put, row, triple
from pipeline.simulation.spatial import Array

VELOCITY_GAIN = 3.5  # [1/s] with which the velocity follows the walk vector

# When feet step. Distances in leg lengths.
STEP_TOLERANCE = 0.16  # distance from below its hip at which a foot steps
CLOSED_TOLERANCE = 0.05  # distance at which the feet of a stopping person are closed
CLOSED_LIMIT = 0.6  # of the step tolerance, for feet side by side: the weight shifts over them
YAW_TOLERANCE = math.radians(28.0)  # of a foot against the pelvis
CATCHING_UP = 4.0  # factor of the clock while both feet stand and one is left behind
WALKING_FROUDE = 0.03  # speed below which a person does not walk, in √(g l)

# How a foot swings and lands.
TOE_LIFT_ANGLE = math.radians(16.0)  # toes up when the heel lands

BRISK_FROUDE = 0.45  # speed from which feet swing more evenly, in √(g l)
FASTEST_RAISE = 2.3  # of a swing under way, in leg lengths [1/s]

# How a foot gets up or down a high step: up and then ahead, or ahead and then down. On its usual
# way it would be drawn up to the hip to clear the edge.
HIGH_RISE = 0.3  # from which it does so wholly, in leg lengths
LEVEL_DELAY, RISE_LEAD = 0.08, 0.4  # of the way ahead and of the rise, in the time of a swing
# Steps are shortened, at most so far, for a place that is less high above or below the other foot.
# In leg lengths.
MOST_EASY_RISE, SHORTEST_STEP = 0.3, 0.3
LEAST_GAIN = 0.02  # of a place over one that is farther ahead
EASY_RISE_TRIALS = 12  # of places from the farthest on
LATE_RETARGET_RATE = 30.0  # [1/s] at which the height follows at the end of a swing

# How feet keep clear of the other leg. Distances are in lateral clearances.
LATERAL_RANGE = 3.0  # distance ahead and behind within which a foot keeps to its own side
DETOUR_FRACTION = 0.25  # of a swing, in which the foot moves to its own side before advancing
RETARGET_RATE = 16.0  # [1/s] at which a swinging foot follows a changed landing place
RETARGET_FROUDE = 1.6  # at which it does at most, after a push, in √(g l)
HURDLE_FROUDE = 1.25  # the same, where a hurdle or its other side comes in sight


@compiled
def place_below_hip(
    person: Record, k: int, x: float, z: float, heading: float
) -> tuple[float, float]:
    """Return x and z below hip k of a person whose pelvis is at x, z."""
    half_width = person.hips * (1.0 - 0.42 * person.walk_blend)
    offset = half_width if k == 1 else -half_width
    return x + offset * math.sin(heading), z + offset * math.cos(heading)


@compiled
def foot_offset(person: Record, k: int) -> float:
    """Return the offset of a foot from below its hip, in step tolerances."""
    x, z = place_below_hip(person, k, person.at[0], person.at[1], person.heading)
    distance = hypotenuse(person.stance_place[k, 0] - x, person.stance_place[k, 2] - z)
    yaw_error = abs(wrap_angle(person.yaw[k] - person.heading))
    return max(distance / (STEP_TOLERANCE * leg_length(person)), yaw_error / YAW_TOLERANCE)


@compiled
def advance_feet(person: Record, frame: Record, vertices: Array, dt: float) -> None:
    """Advance both feet.

    Args:
        person: `PERSON` record; changed.
        frame: of the terrain grid.
        vertices: of the terrain grid.
        dt: time [s].
    """
    if person.kick_foot >= 0:
        _kick(person, person.kick_foot, frame, vertices, dt)
        return
    leg = leg_length(person)
    speed = ground_speed(person)
    rate, stance = gait_pace(person)
    walks = speed > WALKING_FROUDE * math.sqrt(GRAVITY * leg)
    if not person.stepping:
        offsets = foot_offset(person, 0), foot_offset(person, 1)
        if walks or max(offsets[0], offsets[1]) > 1.0:
            first = 0 if offsets[0] >= offsets[1] else 1
            person.stepping = True
            # Due when the clock has gone on.
            person.phase = (1.0 - 1e-9 - 0.5 * first) % 1.0
    advance = _clock_advance(person, rate * dt)
    if person.stepping:
        person.phase = (person.phase + advance) % 1.0
    for k in range(2):
        if person.foot_state[k] == SWING:
            _swing(person, k, (rate, stance, dt), frame, vertices)
        elif person.stepping and _is_due(person, k, advance, walks):
            _lift(person, k, frame, vertices)
        if person.foot_state[k] == STANCE:
            stand(person, k, stance, frame, vertices, dt)
    is_still = person.foot_state[0] == STANCE and person.foot_state[1] == STANCE and not walks
    if person.stepping and is_still:
        person.stepping = not _is_closed(person)


@compiled
def _clock_advance(person: Record, advance: float) -> float:
    """Return how far the clock of steps goes on, which in a steady gait does by `advance` [cycles].

    A foot that a stagger leaves behind is lifted as soon as the other one has landed, and swings
    from there on at the usual rate: at once in mid-swing, it would start with a jerk.
    """
    bears_on_both = person.foot_state[0] == STANCE and person.foot_state[1] == STANCE
    if not bears_on_both or not staggers(person) or foot_lag(person) <= 0.0:
        return advance
    left = 1.0 - max(leg_phase(person, 0), leg_phase(person, 1))
    hurried = min(CATCHING_UP * advance, left)
    return hurried + advance - hurried / CATCHING_UP


@compiled
def _kick(person: Record, k: int, frame: Record, vertices: Array, dt: float) -> None:
    """Lead a kicking foot, and stand on the other one."""
    for c in range(3):
        person.kick_place[c] += person.kick_velocity[c] * dt
    person.stepping = False
    person.foot_state[k] = SWING
    person.yaw[k], person.pitch[k] = person.heading, person.kick_pitch
    put(person.ankles, k, triple(person.kick_place))
    stand(person, 1 - k, 0.5, frame, vertices, dt)


@compiled
def _is_closed(person: Record) -> bool:
    """Tell whether both feet of a stopping person stand well enough, side by side.

    Without the tolerance, people would mark time until the pelvis rests over the feet.
    """
    leg, yaw_factor = leg_length(person), CLOSED_TOLERANCE / STEP_TOLERANCE
    x = 0.5 * (person.stance_place[0, 0] + person.stance_place[1, 0])
    z = 0.5 * (person.stance_place[0, 2] + person.stance_place[1, 2])
    for k in range(2):
        to_x, to_z = place_below_hip(person, k, x, z, person.heading)
        distance = hypotenuse(person.stance_place[k, 0] - to_x, person.stance_place[k, 2] - to_z)
        yaw_error = abs(wrap_angle(person.yaw[k] - person.heading))
        if (
            distance > CLOSED_TOLERANCE * leg
            or yaw_error > yaw_factor * YAW_TOLERANCE
            or foot_offset(person, k) > CLOSED_LIMIT
        ):
            return False
    return True


@compiled
def _is_due(person: Record, k: int, advance: float, walks: bool) -> bool:
    is_turn = leg_phase(person, k) < advance + 1e-12
    return is_turn and (walks or foot_offset(person, k) > CLOSED_TOLERANCE / STEP_TOLERANCE)


@compiled
def _lift(person: Record, k: int, frame: Record, vertices: Array) -> None:
    person.foot_state[k] = SWING
    put(person.settling, k, (0.0, 0.0, 0.0))
    put(person.liftoff_place, k, row(person.ankles, k))
    person.liftoff_yaw[k] = person.yaw[k]
    person.liftoff_pitch[k] = person.pitch[k]
    person.liftoff_heading[k] = person.heading
    person.liftoff_on_deck[k] = person.stance_on_deck[k]
    other_foot = other_ankle(person, k)
    person.pivot[k, 0], person.pivot[k, 1] = other_foot[0], other_foot[2]
    person.swing_height[k] = 0.0
    person.hurdle_side[k] = 0
    _choose_landing(person, k, 1.0, math.inf, frame, vertices)


@compiled
def _choose_landing(
    person: Record, k: int, left: float, dt: float, frame: Record, vertices: Array
) -> None:
    """Choose the landing place of a foot with a remaining fraction of its swing left.

    Only a share of a change is taken over in `dt` [s], so that the foot does not dart aside; all
    of it in an infinite time.
    """
    retargeted = 1.0 - math.exp(-RETARGET_RATE * dt)
    rate, stance = gait_pace(person)
    time = left * (1.0 - stance) / rate
    # Until the other foot leaves the ground the weight is on both.
    double_support = max(stance - 0.5, 0.0) / rate
    heading = person.heading + person.yaw_rate * (time + double_support)
    gain_time = (1.0 - math.exp(-VELOCITY_GAIN * time)) / VELOCITY_GAIN
    vx = person.velocity[0] + person.acceleration[0] * gain_time
    vz = person.velocity[1] + person.acceleration[1] * gain_time
    x = person.at[0] + 0.5 * (person.velocity[0] + vx) * time
    z = person.at[1] + 0.5 * (person.velocity[1] + vz) * time
    x, z = place_below_hip(person, k, x, z, heading)
    walking = person.walk_blend
    if not person.has_goal:
        # One that has arrived will not walk on over the foot.
        walking = min(walking, walk_share(hypotenuse(vx, vz), leg_length(person)))
    behind = heel_offset(person, walking)
    half_stance = 0.5 * stance / rate
    x += vx * half_stance - behind * math.cos(heading)
    z += vz * half_stance + behind * math.sin(heading)
    other_foot = other_ankle(person, k)
    right_x, right_z = math.sin(heading), math.cos(heading)
    side = 1.0 if k == 1 else -1.0
    lateral = side * ((x - other_foot[0]) * right_x + (z - other_foot[2]) * right_z)
    shift = side * max(LATERAL_CLEARANCE * person.hips - lateral, 0.0)
    x, z = x + shift * right_x, z + shift * right_z
    x, z = _within_easy_rise(person, k, x, z, frame, vertices)
    if person.deck_share > 0.0 and not support_at(person, frame, vertices, x, z)[2]:
        # The deck carries the person on, but not the place beside it, and leaves it its velocity.
        carried = time + (1.0 - math.exp(-VELOCITY_GAIN * half_stance)) / VELOCITY_GAIN
        x += person.carry_velocity[0] * carried
        z += person.carry_velocity[1] * carried
    change_x, change_z = x - person.landing_place[k, 0], z - person.landing_place[k, 2]
    most = RETARGET_FROUDE * math.sqrt(GRAVITY * leg_length(person)) * dt
    retargeted = min(retargeted, most / max(hypotenuse(change_x, change_z), 1e-9))
    x = person.landing_place[k, 0] + retargeted * change_x
    z = person.landing_place[k, 2] + retargeted * change_z
    x, z = clear_of_edge(person, x, z)
    if is_stepped_over(person):
        x, z = clear_of_hurdle(person, k, x, z, heading, other_ankle(person, k))
        # What comes in sight, or the other side of it, moves the foot without a jump, too.
        change_x, change_z = x - person.landing_place[k, 0], z - person.landing_place[k, 2]
        most *= HURDLE_FROUDE / RETARGET_FROUDE
        share = min(most / max(hypotenuse(change_x, change_z), 1e-9), 1.0)
        x = person.landing_place[k, 0] + share * change_x
        z = person.landing_place[k, 2] + share * change_z
    y, n, is_on_deck = support_at(person, frame, vertices, x, z)
    person.landing_on_deck[k] = 1 if is_on_deck else 0
    person.landing_place[k, 0], person.landing_place[k, 1], person.landing_place[k, 2] = (
        x,
        y + person.ankle,
        z,
    )
    lifted = row(person.liftoff_place, k)
    rise = y + person.ankle - lifted[1]
    # Over rounded ground the mean slope of both ends leads up or down.
    _, m, _ = support_at(person, frame, vertices, lifted[0], lifted[2])
    slope_x = 0.5 * (n[0] / max(n[1], 1e-6) + m[0] / max(m[1], 1e-6))
    slope_z = 0.5 * (n[2] / max(n[1], 1e-6) + m[2] / max(m[1], 1e-6))
    by_slope = -slope_x * (x - lifted[0]) - slope_z * (z - lifted[2])
    unexplained = min(abs(rise), abs(rise - by_slope))
    person.step_rise[k] += retargeted * (unexplained - person.step_rise[k])
    person.landing_yaw[k] += retargeted * wrap_angle(heading - person.landing_yaw[k])
    person.swing_end[k] += retargeted * (person.landing_place[k, 1] - person.swing_end[k])
    _raise_swing_height(person, k, dt, frame, vertices)


@compiled
def _within_easy_rise(
    person: Record, k: int, x: float, z: float, frame: Record, vertices: Array
) -> tuple[float, float]:
    """Return the farthest place on the way of a foot to x, z that is easily stepped up or down to.

    Who hurries on stairs takes them one by one, not as many as fit into a stride on level ground. A
    higher ledge has no such place, but for those that get the foot hardly ahead of the other one:
    then it is the least high one.
    """
    leg, other = leg_length(person), other_ankle(person, k)
    way_x, way_z = x - other[0], z - other[2]
    size = hypotenuse(way_x, way_z)
    best_x, best_z, least = x, z, math.inf
    for n in range(EASY_RISE_TRIALS):
        left_out = n / EASY_RISE_TRIALS
        if n > 0 and (1.0 - left_out) * size < SHORTEST_STEP * leg:
            break
        to_x, to_z = x - left_out * way_x, z - left_out * way_z
        y, _, _ = support_at(person, frame, vertices, to_x, to_z)
        excess = max(abs(y + person.ankle - other[1]) / leg - MOST_EASY_RISE, 0.0)
        if excess < least - LEAST_GAIN:
            best_x, best_z, least = to_x, to_z, excess
        if excess == 0.0:
            break
    return best_x, best_z


@compiled
def _raise_swing_height(person: Record, k: int, dt: float, frame: Record, vertices: Array) -> None:
    """Raise the swing of a foot to clear what is below its way, for `dt` [s]."""
    a, b = row(person.liftoff_place, k), row(person.landing_place, k)
    run = run_blend(ground_speed(person), leg_length(person))
    clear = (0.035 + 0.02 * person.walk_blend + 0.13 * run) * leg_length(person)
    is_over = is_stepped_over(person)
    for i in range(5):
        # Its way starts and ends slowly: at a quarter of the time it has gone a tenth of it.
        u = 0.25 + 0.125 * i
        s, rise = _step_progress(person, k, u)
        x, z = a[0] + s * (b[0] - a[0]), a[2] + s * (b[2] - a[2])
        y = a[1] + rise * (person.swing_end[k] - a[1])
        ground, _, _ = support_at(person, frame, vertices, x, z)
        ankle = ground + person.ankle + 0.5 * clear
        if is_over:
            ankle = max(ankle, height_over_hurdle(person, x, z, person.landing_yaw[k]))
        need = (ankle - y) / (16.0 * (u * (1.0 - u)) ** 2)
        clear = max(clear, need)
    height = min(clear, 0.6 * leg_length(person))
    # What comes in sight in mid-swing lifts the foot without a jerk.
    height = min(height, person.swing_height[k] + FASTEST_RAISE * leg_length(person) * dt)
    person.swing_height[k] = max(person.swing_height[k], height)


@compiled
def minimum_jerk(u: float) -> float:
    """Return the fraction of a minimum-jerk motion at a fraction u of its time.

    Source: Flash and Hogan 1985.
    """
    return u * u * u * (10.0 + u * (6.0 * u - 15.0))


@compiled
def _swing_progress(person: Record, u: float) -> float:
    """Return the fraction of its way that a foot has gone at a fraction u of its swing.

    Those who walk briskly swing their feet more evenly, and runners the most: minimum jerk, a
    quarter faster at its middle, would turn their legs faster than hips do. The foot of one who
    walks slowly would slide as it lands so.
    """
    brisk = smoothstep(
        (froude(ground_speed(person), leg_length(person)) - BRISK_FROUDE)
        / (RUN_FROUDE + RUN_BLEND - BRISK_FROUDE)
    )
    return (1.0 - brisk) * minimum_jerk(u) + brisk * smoothstep(u)


@compiled
def _step_progress(person: Record, k: int, u: float) -> tuple[float, float]:
    """Return the fractions of the way ahead and of the rise of a foot at a fraction u of its swing.

    They differ on high steps; along a slope, which has no edge to clear, a foot goes straight.
    """
    rise = person.swing_end[k] - person.liftoff_place[k, 1]
    rise = min(max(rise, -person.step_rise[k]), person.step_rise[k])
    rise /= HIGH_RISE * leg_length(person)
    up, down = min(max(rise, 0.0), 1.0), min(max(-rise, 0.0), 1.0)
    late = max(u - LEVEL_DELAY * up, 0.0) / (1.0 - LEVEL_DELAY * up)
    early = min(u / (1.0 - RISE_LEAD * up), 1.0)
    late, early = (
        min(late / (1.0 - LEVEL_DELAY * down), 1.0),
        max(early - RISE_LEAD * down, 0.0) / (1.0 - RISE_LEAD * down),
    )
    return _swing_progress(person, late), _swing_progress(person, early)


@compiled
def _detoured(person: Record, k: int, end: Vector, u: float, s: float) -> tuple[float, float]:
    """Return x and z of a foot on its way round the other leg to the ankle's end place.

    At a fraction u of its time it has done a fraction s of its way. In the turning frame of the
    pelvis the way is straight; where it would cross the other leg, or pass on the wrong side, it
    bends outward.
    """
    pivot_x, pivot_z, from_heading = (
        person.pivot[k, 0],
        person.pivot[k, 1],
        person.liftoff_heading[k],
    )
    turn = wrap_angle(person.landing_yaw[k] - from_heading)
    a, b = ahead_and_right(
        person.liftoff_place[k, 0] - pivot_x, person.liftoff_place[k, 2] - pivot_z, from_heading
    )
    c, d = ahead_and_right(end[0] - pivot_x, end[2] - pivot_z, from_heading + turn)
    x, z = a + s * (c - a), b + s * (d - b)
    side = 1.0 if k == 1 else -1.0
    heading = from_heading + s * turn
    clearance = LATERAL_CLEARANCE * person.hips
    near = max(1.0 - (x / (LATERAL_RANGE * clearance)) ** 2, 0.0)
    lateral_min = clearance + max(side * _leg_lean(person, 1 - k, heading), 0.0) * smoothstep(
        (1.0 - u) / DETOUR_FRACTION
    )
    # At lift-off the foot may be anywhere, and a hurdle may let it land on the other side.
    shift = max(lateral_min * near * near - side * z, 0.0)
    shift *= smoothstep(min(u, 1.0 - u) / DETOUR_FRACTION)
    z += side * shift
    cos, sin = math.cos(heading), math.sin(heading)
    return pivot_x + x * cos + z * sin, pivot_z - x * sin + z * cos


@compiled
def _swing_turn(person: Record, k: int) -> float:
    """Return the angle by which a foot turns in its swing [rad].

    A foot that lags behind a turning pelvis may turn by more than half a circle; it turns with
    the pelvis, not the shorter way round, on which the sense would flip within a swing.
    """
    lag = wrap_angle(person.liftoff_heading[k] - person.liftoff_yaw[k])
    turned = wrap_angle(person.heading - person.liftoff_heading[k])
    return lag + turned + wrap_angle(person.landing_yaw[k] - person.heading)


@compiled
def _leg_lean(person: Record, k: int, heading: float) -> float:
    """Return the lateral offset of a hip from its foot at the height of the passing foot [m]."""
    foot, hip = row(person.ankles, k), row(person.targets, HIP + k)
    rise: float = max(person.ankles[1 - k, 1] - foot[1], 0.0) / leg_length(person)
    _, right = ahead_and_right(hip[0] - foot[0], hip[2] - foot[2], heading)
    return rise * right


@compiled
def _swing(
    person: Record, k: int, pace: tuple[float, float, float], frame: Record, vertices: Array
) -> None:
    """Advance a swinging foot, and land it at the end.

    The pace is cycles per second, stance fraction and time [s].
    """
    rate, stance, dt = pace
    u = leg_phase(person, k) / (1.0 - stance)
    if u >= 1.0:
        person.foot_state[k] = STANCE
        person.touchdowns[k] += 1
        late = (u - 1.0) * (1.0 - stance) / rate
        person.touchdown_time[k] = person.report_time + max(dt - late, 0.0)
        person.touchdown_speed[k] = 3.0 * person.swing_height[k] * rate / (1.0 - stance)
        put(person.stance_place, k, row(person.landing_place, k))
        person.stance_on_deck[k] = person.landing_on_deck[k]
        person.yaw[k] = person.landing_yaw[k]
        return
    if u < 0.75:
        _choose_landing(person, k, 1.0 - u, dt, frame, vertices)
    else:
        share = 1.0 - math.exp(-LATE_RETARGET_RATE * dt)
        person.swing_end[k] += share * (person.landing_place[k, 1] - person.swing_end[k])
    s, rise = _step_progress(person, k, u)
    toes = (
        TOE_LIFT_ANGLE
        * person.walk_blend
        * (1.0 - run_blend(ground_speed(person), leg_length(person)))
    )
    landing = row(person.landing_place, k)
    slope = slope_along(person, frame, vertices, landing, person.landing_yaw[k])
    end = plus(landing, ankle_offset(person, person.landing_yaw[k], toes, slope))
    person.ankles[k, 0], person.ankles[k, 2] = _detoured(person, k, end, u, s)
    height = end[1] + (person.swing_end[k] - landing[1])
    person.ankles[k, 1] = (1.0 - rise) * person.liftoff_place[k, 1] + rise * height
    # Level at both ends, so that the foot neither bumps down nor jerks up.
    person.ankles[k, 1] += 16.0 * person.swing_height[k] * (u * (1.0 - u)) ** 2
    person.yaw[k] = person.liftoff_yaw[k] + smoothstep(u) * _swing_turn(person, k)
    pitch_blend = smoothstep(u / 0.8)
    person.pitch[k] = (1.0 - pitch_blend) * person.liftoff_pitch[k] + pitch_blend * toes
