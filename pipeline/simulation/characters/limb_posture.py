"""Limb posture: targets of elbows, hands, knees and feet.

Arms swing with the gait, are held out, embrace a partner, or reach for a place. The position of a
hand is stored in the frame of the chest and follows its target as a critically damped spring.
Elbows hang below and behind the line from shoulder to hand; knees bend forward between hip and
foot.

Source: Horswill 2008, "Limb control" and "Hugging".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.gait_timing import (
    decayed_step,
    froude,
    ground_speed,
    leg_length,
    leg_phase,
    run_blend,
    smoothstep,
    spring_step,
    wrap_angle,
)
from pipeline.simulation.characters.person_record import (
    ELBOW,
    FOOT,
    HAND,
    HANG_BEND,
    HANG_OUTWARD,
    HANG_SWING,
    HIP,
    HUGGING,
    KNEE,
    MAX_ARM_STRETCH,
    PLACED,
    REACHING,
    SHOULDER,
    SITTING,
    SWING,
    SWINGING,
)
from pipeline.simulation.characters.recovery import RISING_BOW, RISING_CROUCH, is_down
from pipeline.simulation.characters.trunk_posture import (
    Frame,
    chest_frame,
    phase_cosine,
    place_in_world,
)
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.vectors import (
    Vector,
    cross,
    dot,
    length,
    minus,
    plus,
    put,
    row,
    times,
)

# Arms.
HAND_RATE = 7.0  # of hands that reach for a place; settled after about 5/ω [rad/s]
OUTSTRETCHED_FRACTION = 0.97  # of the arm's length
ELBOW_HANG = 0.7  # of elbows held aside, as a tangent
ARM_SWING_ANGLE = math.radians(23.0)  # to both sides at the preferred walking speed
LEAST_ARM_SWING = 0.25  # share of it that is left of arms that are kept to the body
BOW_RANGE, MAX_BOW = 0.45, 1.5  # descent of the shoulders for the deepest bow, in their height;
# its tangent
MAX_CROUCH = 0.66  # descent of the hips, in their height


@compiled
def advance_stoop(person: Record, dt: float) -> None:
    """Bow and then crouch as far as the hands have to go down; only bow to a small person."""
    descent = 0.0
    lean_target = 1.0 if person.stoop_depth > 0.0 else 0.0
    person.embrace_lean, person.embrace_lean_rate = spring_step(
        person.embrace_lean, person.embrace_lean_rate, lean_target, 4.0, dt
    )
    arm = person.upper_arm + person.forearm
    height = person.hip_height + person.belly + person.chest
    for k in range(2):
        # Knees of a person that crouches before its partner would push it away.
        if person.arm_mode[k] == PLACED and person.sit_blend == 0.0:
            descent = max(descent, person.floor + height - 0.8 * arm - person.arm_target[k, 1])
    bow = min(max(descent, person.stoop_depth) / (BOW_RANGE * height), 1.0) * MAX_BOW
    if is_down(person):
        bow = max(bow, RISING_BOW)
    person.bow, person.bow_rate = spring_step(person.bow, person.bow_rate, bow, 4.0, dt)
    lowered = (person.belly + person.chest) * (1.0 - 1.0 / math.sqrt(1.0 + person.bow**2))
    crouch = min(max(descent - lowered, 0.0) / person.hip_height, MAX_CROUCH)
    if is_down(person):
        crouch = max(crouch, RISING_CROUCH)
    person.crouch, person.crouch_rate = spring_step(
        person.crouch, person.crouch_rate, crouch, 4.0, dt
    )


@compiled
def hold_arms(person: Record, dt: float) -> None:
    """Set the targets of elbows and hands."""
    chest, frame = chest_frame(person)
    decay = math.exp(-HAND_RATE * dt)
    quick_rate = 1.6 * HAND_RATE
    quick_decay = math.exp(-quick_rate * dt)
    for k in range(2):
        shoulder = row(person.targets, SHOULDER + k)
        swing_place = _swing_place(person, k)
        place = swing_place
        if person.arm_mode[k] != SWINGING:
            place = _hand_target(person, k, chest, frame)
        elif person.posture == SITTING:
            place = _in_lap(person, k, chest, frame)
        blend_target = 0.0 if person.arm_mode[k] == SWINGING and person.posture != SITTING else 1.0
        person.hand_blend[k], person.hand_blend_rate[k] = decayed_step(
            person.hand_blend[k], person.hand_blend_rate[k], blend_target, HAND_RATE, dt, decay
        )
        person.embrace_blend[k], person.embrace_blend_rate[k] = decayed_step(
            person.embrace_blend[k],
            person.embrace_blend_rate[k],
            1.0 if person.arm_mode[k] == HUGGING else 0.0,
            HAND_RATE,
            dt,
            decay,
        )
        for c in range(3):
            person.hand_place[k, c], person.hand_velocity[k, c] = decayed_step(
                *(person.hand_place[k, c], person.hand_velocity[k, c], place[c]),
                *(quick_rate, dt, quick_decay),
            )
        blend = person.hand_blend[k]
        held = row(person.hand_place, k)
        place_in_chest = plus(times(1.0 - blend, swing_place), times(blend, held))
        hand = place_in_world(chest, frame, place_in_chest[0], place_in_chest[1], place_in_chest[2])
        _bend_arm(person, k, shoulder, hand, frame)


@compiled
def _swing_place(person: Record, k: int) -> Vector:
    """Return the place of a hand that swings against the legs, in the frame of the chest [m]."""
    leg, speed = leg_length(person), ground_speed(person)
    running = run_blend(speed, leg)
    stance = person.duty
    # A hand is ahead when the foot of the other side comes down.
    swing = phase_cosine(person, 1.0 - stance + (0.5 if k == 0 else 0.0))
    amount = person.walk_blend * min(froude(speed, leg) / 0.47, 1.0)
    amount *= 1.0 - (1.0 - LEAST_ARM_SWING) * person.arms_in
    angle = ARM_SWING_ANGLE * amount * swing * (0.9 + 0.5 * running) + HANG_SWING
    bend = HANG_BEND + amount * math.radians(9.0) * (1.0 + 0.8 * swing)
    bend += running * math.radians(62.0)
    # The arm hangs down however the trunk leans.
    c, s = math.cos(person.heading), math.sin(person.heading)
    angle += 0.9 * math.atan(person.lean[0] * c - person.lean[1] * s) - 0.3 * running
    outward = HANG_OUTWARD * (1.0 - 0.5 * person.arms_in) - 0.04 * running
    side = 1.0 if k == 1 else -1.0
    upper, forearm = person.upper_arm, person.forearm
    x = upper * math.sin(angle) + forearm * math.sin(angle + bend)
    y = -upper * math.cos(angle) - forearm * math.cos(angle + bend)
    z = side * (person.shoulders - y * math.sin(outward) - running * 0.25 * forearm)
    return (x, y * math.cos(outward), z)


@compiled
def _in_chest_frame(place: Vector, chest: Vector, frame: Frame) -> Vector:
    offset = minus(place, chest)
    return (dot(offset, frame[0]), dot(offset, frame[1]), dot(offset, frame[2]))


@compiled
def _hand_target(person: Record, k: int, chest: Vector, frame: Frame) -> Vector:
    """Return the target of a hand that does not swing, in the frame of the chest [m]."""
    side = 1.0 if k == 1 else -1.0
    if person.arm_mode[k] == REACHING:
        ahead = OUTSTRETCHED_FRACTION * (person.upper_arm + person.forearm)
        return (ahead, -0.1 * ahead, side * 0.8 * person.shoulders)
    return _in_chest_frame(row(person.arm_target, k), chest, frame)


@compiled
def _in_lap(person: Record, k: int, chest: Vector, frame: Frame) -> Vector:
    hip, knee = row(person.targets, HIP + k), row(person.targets, KNEE + k)
    place = plus(times(0.35, hip), times(0.65, knee))
    place = (place[0], place[1] + 0.075 * person.height * 0.9, place[2])
    return _in_chest_frame(place, chest, frame)


@compiled
def _bend_arm(person: Record, k: int, shoulder: Vector, hand: Vector, frame: Frame) -> None:
    """Set the targets of a hand and its elbow within the arm's reach."""
    upper, forearm = person.upper_arm, person.forearm
    hand = clamp_distance(
        shoulder, hand, 0.25 * (upper + forearm), MAX_ARM_STRETCH * (upper + forearm)
    )
    along = minus(hand, shoulder)
    side = 1.0 if k == 1 else -1.0
    # Down where the hand is ahead, back where it hangs; outward where it is aside or inside.
    pole = times(-1.0, cross(frame[2], times(1.0 / length(along), along)))
    pole = plus(pole, plus(times(0.28 * side, frame[2]), times(-0.12, frame[1])))
    pole = plus(pole, times(-0.06, frame[0]))
    # In an embrace elbows go aside, so that forearms close behind.
    aside = plus(times(side, frame[2]), times(-ELBOW_HANG, frame[1]))
    pole = plus(times(1.0 - person.embrace_blend[k], pole), times(person.embrace_blend[k], aside))
    put(person.targets, ELBOW + k, two_link_joint(shoulder, hand, upper, forearm, pole))
    put(person.targets, HAND + k, hand)


@compiled
def clamp_distance(root: Vector, tip: Vector, least: float, most: float) -> Vector:
    """Return the place nearest to `tip` at a distance from `root` within limits."""
    offset = minus(tip, root)
    distance = length(offset)
    if distance < 1e-9:
        return plus(root, (0.0, -least, 0.0))
    return plus(root, times(min(max(distance, least), most) / distance, offset))


@compiled
def two_link_joint(root: Vector, tip: Vector, upper: float, lower: float, pole: Vector) -> Vector:
    """Return the joint between two links of given lengths, on the side of `pole`."""
    along = minus(tip, root)
    distance = max(length(along), 1e-9)
    along = times(1.0 / distance, along)
    a = (upper * upper - lower * lower + distance * distance) / (2.0 * distance)
    a = min(max(a, -upper), upper)
    aside = minus(pole, times(dot(pole, along), along))
    size = length(aside)
    if size < 1e-9:
        return plus(root, times(a, along))
    height = math.sqrt(max(upper * upper - a * a, 0.0))
    return plus(root, plus(times(a, along), times(height / size, aside)))


# Legs.
MAX_LEG_STRETCH = 0.995  # of a swinging leg, in the sum of its links
RUNNING_FOLD = 0.2  # less of it in the middle of a runner's swing
KNEE_OUTWARD = 0.06  # of bent knees, as a tangent; more in sitting
SQUAT_OUTWARD = 0.8  # in a crouch, so that arms reach down between the knees
TOES_SHARE = 0.6  # of the turn of a foot against the pelvis that its knee takes part in
MAX_KNEE_OUTWARD = math.radians(45.0)  # as far as hips turn
MAX_KNEE_INWARD = 0.1  # [rad], so that knees do not strike one another
KNEE_CLEARANCE = 0.094  # of knees that pass one another, in heights: two thighs side by side
KNEE_RANGE = 4.0  # distance ahead within which knees part, in knee clearances
MAX_THIGH_LEAN = 0.6  # sine of the lean beyond which no more clearance is made
PARTING_BLEND = 0.3  # of a swing, in which it comes to yield to the other knee alone
CLOSING_KNEE = 1.8  # turn at most at which a knee comes back that has parted [rad/s]


@compiled
def hold_legs(person: Record, dt: float) -> None:
    """Set the targets of knees and feet, `dt` after the last ones [s]."""
    for k in range(2):
        hip, ankle = row(person.targets, HIP + k), row(person.ankles, k)
        if person.foot_state[k] == SWING:
            longest = _longest_swing(person, k)
            ankle = clamp_distance(hip, ankle, 0.0, longest)
            put(person.ankles, k, ankle)
        side = 1.0 if k == 1 else -1.0
        inward = side * TOES_SHARE * wrap_angle(person.yaw[k] - person.heading)
        # A foot that a turning pelvis leaves behind turns in its own joints, too.
        if inward < 0.0:
            inward = MAX_KNEE_OUTWARD * math.tanh(inward / MAX_KNEE_OUTWARD)
        toes = person.heading + side * min(inward, MAX_KNEE_INWARD)
        right = (math.sin(toes), 0.0, math.cos(toes))
        # Ahead of a hanging leg, above one that lies ahead: never parallel to the leg.
        pole = cross(right, minus(ankle, hip))
        side = 1.0 if k == 1 else -1.0
        leg = person.thigh + person.shin
        outward = (
            side * (KNEE_OUTWARD + 0.25 * person.sit_blend + SQUAT_OUTWARD * person.crouch) * leg
        )
        knee = two_link_joint(
            hip, ankle, person.thigh, person.shin, plus(pole, times(outward, right))
        )
        put(person.targets, KNEE + k, knee)
        put(person.targets, FOOT + k, ankle)
    right = (math.sin(person.heading), 0.0, math.cos(person.heading))
    unparted = (_knee_turn(person, 0, right), _knee_turn(person, 1, right))
    _part_knees(person, right)
    for k in range(2):
        _close_slowly(person, k, unparted[k], right, dt)


@compiled
def _swing_fraction(person: Record, k: int) -> float:
    """Return the fraction of the time of its swing at which a foot is, beyond 1 in stance."""
    stance = person.duty
    fraction: float = leg_phase(person, k) / (1.0 - stance)
    return fraction


@compiled
def _longest_swing(person: Record, k: int) -> float:
    """Return the greatest distance of a swinging foot from its hip [m].

    A runner's foot, left behind at lift-off, does not hang on a stretched leg until it catches up:
    such a leg would fold in a snap.
    """
    u = min(_swing_fraction(person, k), 1.0)
    fold = RUNNING_FOLD * run_blend(ground_speed(person), leg_length(person))
    fraction: float = MAX_LEG_STRETCH - fold * 16.0 * (u * (1.0 - u)) ** 2
    return fraction * (person.thigh + person.shin)


@compiled
def _part_knees(person: Record, right: Vector) -> None:
    """Turn knees outward that would collide, that of the swinging leg more.

    A knee that is as far outward as it goes leaves the rest to the other one.
    """
    share = 0.5 + 0.5 * (_middle_of_swing(person, 1) - _middle_of_swing(person, 0))
    deficits = (_knee_deficit(person, 0, right), _knee_deficit(person, 1, right))
    _move_outward(person, 0, (1.0 - share) * deficits[0], right)
    _move_outward(person, 1, share * deficits[1], right)
    for k in range(2):
        _move_outward(person, k, _knee_deficit(person, k, right), right)


@compiled
def _move_outward(person: Record, k: int, distance: float, right: Vector) -> None:
    """Move a knee outward by a distance, if it is more than 0, as far as it goes [m]."""
    if distance > 0.0:
        hip, ankle = row(person.targets, HIP + k), row(person.targets, FOOT + k)
        knee = _turned_outward(person, k, hip, ankle, distance, right)
        put(person.targets, KNEE + k, knee)


@compiled
def _knee_turn(person: Record, k: int, right: Vector) -> float:
    """Return the turn of a knee outward about the line from hip to ankle [rad]."""
    hip, ankle = row(person.targets, HIP + k), row(person.targets, FOOT + k)
    radial, outward = _knee_axes(person, k, hip, ankle, right)
    return math.asin(min(max(dot(radial, outward) / max(length(radial), 1e-9), -1.0), 1.0))


@compiled
def _close_slowly(person: Record, k: int, unparted: float, right: Vector, dt: float) -> None:
    """Let a knee come back slowly from where it has made room for the other one.

    Once they have passed, the clearance that it needs ends at once.

    Args:
        person: `PERSON` record.
        k: number of the leg.
        unparted: its turn without the other one [rad].
        right: of the person.
        dt: since the last step [s].
    """
    now = _knee_turn(person, k, right)
    parted = max(now - unparted, person.knee_parted[k] - CLOSING_KNEE * dt, 0.0)
    person.knee_parted[k] = parted
    turn = unparted + parted
    if turn > now:
        hip, ankle = row(person.targets, HIP + k), row(person.targets, FOOT + k)
        radial, _ = _knee_axes(person, k, hip, ankle, right)
        distance = length(radial) * (math.sin(min(turn, 0.5 * math.pi)) - math.sin(now))
        _move_outward(person, k, distance, right)


@compiled
def _middle_of_swing(person: Record, k: int) -> float:
    """Return 1 in most of a foot's swing, 0 where it stands, gradual in between."""
    if person.foot_state[k] != SWING or not person.stepping:
        return 0.0
    u = _swing_fraction(person, k)
    return smoothstep(min(u, 1.0 - u) / PARTING_BLEND)


@compiled
def _knee_deficit(person: Record, k: int, right: Vector) -> float:
    """Return the clearance that a knee lacks to the other one, less than 0 if none [m]."""
    ahead = (right[2], 0.0, -right[0])
    clearance = KNEE_CLEARANCE * person.height
    side = 1.0 if k == 1 else -1.0
    offset = minus(row(person.targets, KNEE + k), row(person.targets, KNEE + 1 - k))
    closeness = max(1.0 - (dot(offset, ahead) / (KNEE_RANGE * clearance)) ** 2, 0.0)
    # Thighs that lean to a side are nearer to one another than their knees.
    thigh = minus(row(person.targets, KNEE + k), row(person.targets, HIP + k))
    lean = min(abs(dot(thigh, right)) / person.thigh, MAX_THIGH_LEAN)
    needed = clearance / math.sqrt(1.0 - lean * lean) * closeness * closeness
    return needed - side * dot(offset, right)


@compiled
def _knee_axes(
    person: Record, k: int, hip: Vector, ankle: Vector, right: Vector
) -> tuple[Vector, Vector]:
    """Return the offset of a knee from the line from hip to ankle, and its unit vector outward."""
    knee, along = row(person.targets, KNEE + k), minus(ankle, hip)
    line = times(1.0 / length(along), along)
    radial = minus(knee, hip)
    radial = minus(radial, times(dot(radial, line), line))
    side = 1.0 if k == 1 else -1.0
    outward = times(side, minus(right, times(dot(right, line), line)))
    return radial, times(1.0 / length(outward), outward)


@compiled
def _turned_outward(
    person: Record, k: int, hip: Vector, ankle: Vector, distance: float, right: Vector
) -> Vector:
    """Return the knee turned outward about the line from hip to ankle by a distance [m]."""
    knee = row(person.targets, KNEE + k)
    radial, outward = _knee_axes(person, k, hip, ankle, right)
    radius = length(radial)
    across = min(dot(radial, outward) + distance, 0.95 * radius)
    pole = minus(radial, times(dot(radial, outward), outward))
    ahead = length(pole)
    if ahead < 1e-6 or radius < 1e-6:
        return knee
    pole = plus(
        times(math.sqrt(radius * radius - across * across) / ahead, pole), times(across, outward)
    )
    return two_link_joint(hip, ankle, person.thigh, person.shin, pole)
