"""Pelvis motion: the path along which the pelvis is led over the ground, and sitting down.

The led place has its own velocity. It follows the walk vector as quickly as legs can push, and
yields to impulses on the body: a shoved person is carried along and walks it off.

Source: Horswill 2008, "Gait Control" and "Low-level character control".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.biped_gait import VELOCITY_GAIN
from pipeline.simulation.characters.deck_motion import support_at
from pipeline.simulation.characters.gait_timing import (
    follow_duty_factor,
    ground_speed,
    leg_length,
    spring_step,
    staggers,
    walk_share,
    wrap_angle,
)
from pipeline.simulation.characters.hurdles import hurdle_ease
from pipeline.simulation.characters.person_record import FOOT, PELVIS, SITTING
from pipeline.simulation.characters.recovery import is_down
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.terrain_grid import Grid
from pipeline.simulation.dynamics.vectors import hypotenuse

MAX_ACCELERATION = 0.22  # of the legs, in g
CATCHING_ACCELERATION = 0.3  # of one that catches itself, in g
BRAKING_ACCELERATION = 0.08  # before a goal, in g
SHUFFLE_FROUDE = 0.15  # of steps aside or back without turning, in √(g l)
MAX_CRAB = math.radians(15.0)  # of the way that is walked from the heading
MOST_FACED_AWAY = math.radians(100.0)  # the same, beyond which a person steps back instead
BACKWARD_FROUDE = 0.11  # of steps back before what a person keeps facing, in √(g l)
LATE_GAIN = 0.12  # of one that others have held up, beyond its pace
ARRIVAL_DISTANCE = 0.08  # in leg lengths
MAX_YAW_RATE = 2.6  # [rad/s]
STARTLED_HASTE = 2.2  # of the turn of one that starts back, relative to others
BRACED_TURN = math.radians(60.0)  # of one that is about to be pushed, from who pushes it
BLIND_TURN = math.radians(90.0)  # of the gaze from the way, from which one feels its way
CENTRING_RATE = 1.6  # at which a standing person shifts over the middle of the feet [1/s]
STEP_EASE = 0.6  # at the edge of a deck
SLOPE_FACTOR, EASIEST_SLOPE = 3.5, 0.05  # of Tobler's hiking function

# How the led place follows a body that is pushed off. Offsets in leg lengths.
FOLLOW_RATE = 7.0  # [1/s]
FREE_OFFSET, SHOVED_OFFSET = 0.012, 0.1  # ignored; fully followed
STAGGER_FROUDE = 0.5  # fastest stagger, in √(g l); a person thrown faster falls

SITTING_TIME = 1.5  # to sit down or to stand up [s]


@compiled
def lead_pelvis(person: Record, nodes: Records, ground: Grid, h: float, dt: float) -> None:
    """Advance the led place for `dt` [s]; nodes have moved for `h` [s]."""
    wx, wz = _walk_vector(person)
    ease = _slope_slowdown(person, wx, wz, ground) * hurdle_ease(person)
    # Or the steps would be as much longer as they take longer.
    ease /= 1.0 + person.slowing
    wx, wz = ease * wx, ease * wz
    _steer_heading(person, wx, wz, dt)
    _advance_place(person, nodes, wx, wz, h, dt)
    follow_duty_factor(person, dt)
    walking = walk_share(ground_speed(person), leg_length(person))
    walk_target = walking if person.stepping else 0.0
    person.walk_blend, person.walk_blend_rate = spring_step(
        person.walk_blend, person.walk_blend_rate, walk_target, 6.0, dt
    )


@compiled
def halt(person: Record) -> None:
    """Stop the led place of a frozen person."""
    for c in range(2):
        person.velocity[c] = person.acceleration[c] = 0.0
    person.yaw_rate = 0.0


@compiled
def goal_velocity(person: Record) -> tuple[float, float]:
    """Return the velocity along x and z at which a person walks to its goal, if alone [m/s]."""
    x, z = person.goal[0] - person.at[0], person.goal[1] - person.at[1]
    distance = hypotenuse(x, z)
    if not person.has_goal or distance <= 1e-9:
        return 0.0, 0.0
    left = max(distance - person.stop_distance, 0.0)
    # Slow down so that braking gently ends at the goal.
    speed = min(
        (1.0 + LATE_GAIN * person.lateness) * person.pace,
        math.sqrt(2.0 * BRAKING_ACCELERATION * GRAVITY * left),
        0.5 * VELOCITY_GAIN * left,
    )
    return speed * x / distance, speed * z / distance


@inlined
def _way_left(person: Record) -> float:
    """Return the distance to where the goal of a person is reached [m]."""
    distance = hypotenuse(person.goal[0] - person.at[0], person.goal[1] - person.at[1])
    return max(distance - person.stop_distance, 0.0)


@compiled
def _walk_vector(person: Record) -> tuple[float, float]:
    """Return the wanted velocity along x and z [m/s]."""
    wx, wz = goal_velocity(person)
    if person.has_goal and _way_left(person) < ARRIVAL_DISTANCE * leg_length(person):
        person.has_goal = False
    wx, wz = wx + person.sidestep[0], wz + person.sidestep[1]
    if person.evasion[0] != 0.0 or person.evasion[1] != 0.0:
        wx, wz = wx + person.evasion[0], wz + person.evasion[1]
    if person.posture == SITTING or person.sit_blend > 0.03 or person.frozen or is_down(person):
        wx, wz = 0.0, 0.0
    speed = hypotenuse(wx, wz)
    if speed > 1e-6 and not person.has_facing:
        # A far turn comes before the walk.
        turn_angle = abs(wrap_angle(math.atan2(-wz, wx) - person.heading))
        share = min(max((math.radians(115.0) - turn_angle) / math.radians(60.0), 0.0), 1.0)
        share = max(share, min(_shuffle(person) / speed, 1.0))
        wx, wz = wx * share, wz * share
        speed = hypotenuse(wx, wz)
    if speed > 1e-6 and _feels_its_way(person, wx, wz):
        share = min(BACKWARD_FROUDE * math.sqrt(GRAVITY * leg_length(person)) / speed, 1.0)
        wx, wz = wx * share, wz * share
    return wx, wz


@compiled
def _feels_its_way(person: Record, wx: float, wz: float) -> bool:
    """Tell whether a person does not see where it steps along x and z.

    One that starts back turns its head to the way first.
    """
    if not person.startled:
        return faces_away(person, (wx, wz))
    return abs(wrap_angle(math.atan2(-wz, wx) - person.gaze[0])) > BLIND_TURN


@compiled
def faces_away(person: Record, velocity: tuple[float, float]) -> bool:
    """Tell whether a person with a velocity steps back before what it keeps facing."""
    if not person.has_facing or hypotenuse(velocity[0], velocity[1]) < 1e-6:
        return False
    way: float = math.atan2(-velocity[1], velocity[0])
    return abs(wrap_angle(way - person.facing)) > MOST_FACED_AWAY


@inlined
def _shuffle(person: Record) -> float:
    """Return the speed at which a person steps aside or back without turning [m/s].

    One who turns to its goal does so first.
    """
    if person.sidestep[0] == 0.0 and person.sidestep[1] == 0.0:
        return 0.0
    speed = SHUFFLE_FROUDE * math.sqrt(GRAVITY * leg_length(person))
    if not person.has_goal:
        return speed
    x, z = person.goal[0] - person.at[0], person.goal[1] - person.at[1]
    turn = abs(wrap_angle(math.atan2(-z, x) - person.heading))
    return speed * min(max((math.radians(115.0) - turn) / math.radians(60.0), 0.0), 1.0)


@compiled
def _slope_slowdown(person: Record, wx: float, wz: float, ground: Grid) -> float:
    """Return the factor by which a slope slows walking.

    Source: Tobler 1993; half as much, for his hikers have a long way to go.
    """
    speed = hypotenuse(wx, wz)
    if speed < 1e-6:
        return 1.0
    ahead = 0.4 * leg_length(person) / speed
    x, z = person.at[0], person.at[1]
    frame, vertices = ground.frame, ground.vertices
    height_behind, _, from_deck = support_at(
        person, frame, vertices, x - ahead * wx, z - ahead * wz
    )
    height_ahead, _, to_deck = support_at(person, frame, vertices, x + ahead * wx, z + ahead * wz)
    if from_deck != to_deck:
        return STEP_EASE
    slope = (height_ahead - height_behind) / (2.0 * ahead * speed)
    return math.exp(-0.5 * SLOPE_FACTOR * max(abs(slope + EASIEST_SLOPE) - EASIEST_SLOPE, 0.0))


@compiled
def _steer_heading(person: Record, wx: float, wz: float, dt: float) -> None:
    """Turn towards the walking direction or the facing asked for."""
    target = person.heading
    x, z = person.goal[0] - person.at[0], person.goal[1] - person.at[1]
    left = hypotenuse(x, z)
    if person.has_facing:
        target = person.facing
    elif person.has_goal and left > max(person.stop_distance, 0.12 * leg_length(person)):
        # Near the goal a step aside would turn the person away from it.
        scale = max(person.pace / left, 1.0)
        target = math.atan2(-scale * z - person.sidestep[1], scale * x + person.sidestep[0])
        target += _turn_to_way(person, target)
    elif hypotenuse(wx, wz) > 0.12 * math.sqrt(GRAVITY * leg_length(person)):
        target = math.atan2(-wz, wx)
    if person.frozen or person.posture == SITTING:
        target = person.heading
    haste = STARTLED_HASTE if person.startled else 1.0
    if person.braces:
        # It takes the push with a shoulder, the nearer one.
        source = math.atan2(person.push_way[1], -person.push_way[0])
        turned = wrap_angle(person.heading - source)
        target, haste = source + math.copysign(BRACED_TURN, turned), STARTLED_HASTE
    most = haste * MAX_YAW_RATE
    rate = min(max(3.2 * haste * wrap_angle(target - person.heading), -most), most)
    gain, limit = 9.0 * haste, 14.0 * haste * haste
    person.yaw_rate += min(max(gain * (rate - person.yaw_rate), -limit), limit) * dt
    person.heading = wrap_angle(person.heading + person.yaw_rate * dt)


@inlined
def _turn_to_way(person: Record, heading: float) -> float:
    """Return the turn by which a heading comes near enough to the way that is walked [rad].

    A person that keeps walking sideways would spread its legs as wide as its steps.
    """
    goal_x, goal_z = goal_velocity(person)
    x, z = goal_x + person.sidestep[0], goal_z + person.sidestep[1]
    speed = hypotenuse(x, z)
    if speed < SHUFFLE_FROUDE * math.sqrt(GRAVITY * leg_length(person)):
        return 0.0
    turn = wrap_angle(math.atan2(-z, x) - heading)
    if abs(turn) > MOST_FACED_AWAY:
        return 0.0
    return turn - min(max(turn, -MAX_CRAB), MAX_CRAB)


@compiled
def _advance_place(
    person: Record, nodes: Records, wx: float, wz: float, h: float, dt: float
) -> None:
    """Move the led place with its velocity, and along with the body."""
    leg, limit = leg_length(person), MAX_ACCELERATION * GRAVITY
    if staggers(person):
        limit = CATCHING_ACCELERATION * GRAVITY
    gain_x, gain_z = (
        VELOCITY_GAIN * (wx - person.velocity[0]),
        VELOCITY_GAIN * (wz - person.velocity[1]),
    )
    size = hypotenuse(gain_x, gain_z)
    if size > limit:
        gain_x, gain_z = gain_x * limit / size, gain_z * limit / size
    person.acceleration[0], person.acceleration[1] = gain_x, gain_z
    slowed = ground_speed(person) - limit * dt
    node = nodes[person.node + PELVIS]
    is_sitting = person.posture == SITTING or person.sit_blend > 0.03
    for c in range(2):
        axis = 2 * c
        offset = node.p[axis] - person.targets[PELVIS, axis]
        free = FREE_OFFSET * leg
        excess = 0.0 if is_sitting else offset - min(max(offset, -free), free)
        # A shoved person moves as fast as the body, not faster.
        shoved = min(abs(excess) / (SHOVED_OFFSET * leg), 1.0)
        v = (node.p[axis] - node.previous[axis]) / h - person.carry_velocity[c]
        acceleration = gain_x if c == 0 else gain_z
        person.velocity[c] += (acceleration + FOLLOW_RATE * shoved * (v - person.velocity[c])) * dt
        shift = FOLLOW_RATE * excess * dt
        person.at[c] += person.velocity[c] * dt + shift
        # The targets move over to the body, which is no motion of their own.
        for k in range(FOOT):
            person.previous_targets[k, axis] += shift
    # A runner whose pace changes brakes with its legs; a shove adds no more than a stagger.
    limit = max(1.1 * person.pace, STAGGER_FROUDE * math.sqrt(GRAVITY * leg), slowed)
    share = min(limit / max(ground_speed(person), 1e-9), 1.0)
    person.velocity[0], person.velocity[1] = share * person.velocity[0], share * person.velocity[1]
    if not person.stepping and person.posture != SITTING and person.sit_blend < 0.03:
        for c in range(2):
            middle = 0.5 * (person.stance_place[0, 2 * c] + person.stance_place[1, 2 * c])
            person.at[c] += CENTRING_RATE * (middle - person.at[c]) * dt


@compiled
def advance_sitting(person: Record, dt: float) -> None:
    """Advance sitting down or standing up; sitting starts only from standing still."""
    is_sitting = person.posture == SITTING
    is_standing = not person.stepping and ground_speed(person) < 0.04 * leg_length(person)
    if person.frozen or (is_sitting and person.sit_blend == 0.0 and not is_standing):
        return
    step = dt / SITTING_TIME if is_sitting else -dt / SITTING_TIME
    person.sit_blend = min(max(person.sit_blend + step, 0.0), 1.0)
