"""Limb posture."""

from __future__ import annotations

import math

from pipeline.simulation.characters.gait_timing import (
    leg_of,
    pace_of,
    relative,
    running,
    speed_of,
    sprung,
    wrapped,
)
from pipeline.simulation.characters.person_record import (
    AT_EASE,
    ELBOW,
    FOOT,
    HAND,
    HIP,
    HUGGING,
    KNEE,
    LONGEST_ARM,
    OUT,
    PLACED,
    REACHING,
    SHOULDER,
    SITTING,
    SWING,
    SWINGING,
)
from pipeline.simulation.characters.trunk_posture import Frame, chest_frame, from_frame, turn_of
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

HAND_RATE = 7.0
"""How quickly hands go where they are told; they are there after about 5/ω [rad/s]."""

OUTSTRETCHED_FRACTION = 0.97
"""Of an arm that is held out, as a part of its length."""

BOWS, DEEPEST_BOW, DEEPEST_CROUCH = 0.45, 1.5, 0.66
"""How far shoulders have to come down, in their height, for the deepest bow; the tangent of
that; and how far hips come down, in their height."""

HANGS = 0.35
"""How far elbows hang that are aside, as a tangent."""

ARM_SWING_ANGLE = math.radians(23.0)
"""How far arms swing to both sides at the speed that people like best."""


@compiled
def stoop(person: Record, dt: float) -> None:
    """Bow, and then crouch, as far as hands have to go down; bow alone to somebody small."""
    low = 0.0
    leans = 1.0 if person.down > 0.0 else 0.0
    person.leans, person.leans_rate = sprung(person.leans, person.leans_rate, leans, 4.0, dt)
    arm = person.upper_arm + person.forearm
    height = person.hip_height + person.belly + person.chest
    for k in range(2):
        if person.arm[k] >= PLACED and person.seated == 0.0:
            low = max(low, person.floor + height - 0.8 * arm - person.arm_at[k, 1])
    bow = min(max(low, person.down) / (BOWS * height), 1.0) * DEEPEST_BOW
    person.bow, person.bow_rate = sprung(person.bow, person.bow_rate, bow, 4.0, dt)
    lowered = (person.belly + person.chest) * (1.0 - 1.0 / math.sqrt(1.0 + person.bow**2))
    crouch = min(max(low - lowered, 0.0) / person.hip_height, DEEPEST_CROUCH)
    person.crouch, person.crouch_rate = sprung(person.crouch, person.crouch_rate, crouch, 4.0, dt)


@compiled
def hold_arms(person: Record, dt: float) -> None:
    """Say where elbows and hands should be."""
    chest, frame = chest_frame(person)
    for k in range(2):
        shoulder = row(person.wanted, SHOULDER + k)
        swung = _swung(person, k)
        place = swung
        if person.arm[k] != SWINGING:
            place = _asked(person, k, chest, frame)
        elif person.posture == SITTING:
            place = _in_lap(person, k, chest, frame)
        wants = 0.0 if person.arm[k] == SWINGING and person.posture != SITTING else 1.0
        person.told[k], person.told_rate[k] = sprung(
            person.told[k], person.told_rate[k], wants, HAND_RATE, dt
        )
        person.wraps[k], person.wraps_rate[k] = sprung(
            person.wraps[k],
            person.wraps_rate[k],
            1.0 if person.arm[k] == HUGGING else 0.0,
            HAND_RATE,
            dt,
        )
        for c in range(3):
            person.hand[k, c], person.hand_rate[k, c] = sprung(
                person.hand[k, c], person.hand_rate[k, c], place[c], 1.6 * HAND_RATE, dt
            )
        share = person.told[k]
        own = row(person.hand, k)
        local = plus(times(1.0 - share, swung), times(share, own))
        hand = from_frame(chest, frame, local[0], local[1], local[2])
        _bend(person, k, shoulder, hand, frame)


@compiled
def _swung(person: Record, k: int) -> Vector:
    """Return where a hand is that swings against the legs, in the frame of the chest [m]."""
    leg, speed = leg_of(person), speed_of(person)
    run = running(speed, leg)
    _, stance = pace_of(person)
    # A hand is ahead when the foot of the other side comes down.
    swing = turn_of(person, 1.0 - stance + (0.5 if k == 0 else 0.0))
    some = person.walking * min(relative(speed, leg) / 0.47, 1.0)
    angle = ARM_SWING_ANGLE * some * swing * (0.9 + 0.5 * run) + AT_EASE[0]
    bend = AT_EASE[1] + some * math.radians(9.0) * (1.0 + 0.8 * swing)
    bend += run * math.radians(62.0)
    # It hangs down, however the trunk leans.
    c, s = math.cos(person.heading), math.sin(person.heading)
    angle += 0.9 * math.atan(person.lean[0] * c - person.lean[1] * s) - 0.3 * run
    out = OUT - 0.04 * run
    side = 1.0 if k == 1 else -1.0
    upper, fore = person.upper_arm, person.forearm
    x = upper * math.sin(angle) + fore * math.sin(angle + bend)
    y = -upper * math.cos(angle) - fore * math.cos(angle + bend)
    z = side * (person.shoulders - y * math.sin(out) - run * 0.25 * fore)
    return (x, y * math.cos(out), z)


@compiled
def _local(place: Vector, chest: Vector, frame: Frame) -> Vector:
    """Return a place in the world as one in the frame of the chest."""
    away = minus(place, chest)
    return (dot(away, frame[0]), dot(away, frame[1]), dot(away, frame[2]))


@compiled
def _asked(person: Record, k: int, chest: Vector, frame: Frame) -> Vector:
    """Return where a hand is to be that does not swing, in the frame of the chest [m]."""
    side = 1.0 if k == 1 else -1.0
    if person.arm[k] == REACHING:
        ahead = OUTSTRETCHED_FRACTION * (person.upper_arm + person.forearm)
        return (ahead, -0.1 * ahead, side * 0.8 * person.shoulders)
    return _local(row(person.arm_at, k), chest, frame)


@compiled
def _in_lap(person: Record, k: int, chest: Vector, frame: Frame) -> Vector:
    """Return the place of a hand on the thigh of one who sits."""
    hip, knee = row(person.wanted, HIP + k), row(person.wanted, KNEE + k)
    place = plus(times(0.35, hip), times(0.65, knee))
    place = (place[0], place[1] + 0.075 * person.height * 0.9, place[2])
    return _local(place, chest, frame)


@compiled
def _bend(person: Record, k: int, shoulder: Vector, hand: Vector, frame: Frame) -> None:
    """Put hand and elbow where the lengths of the arm let them be."""
    upper, fore = person.upper_arm, person.forearm
    hand = within(shoulder, hand, 0.25 * (upper + fore), LONGEST_ARM * (upper + fore))
    along = minus(hand, shoulder)
    side = 1.0 if k == 1 else -1.0
    # Down where the hand is ahead, back where it hangs; outward where it is aside or inside.
    pole = times(-1.0, cross(frame[2], times(1.0 / length(along), along)))
    pole = plus(pole, plus(times(0.28 * side, frame[2]), times(-0.12, frame[1])))
    pole = plus(pole, times(-0.06, frame[0]))
    # Round somebody elbows go aside, so that forearms close behind.
    aside = plus(times(side, frame[2]), times(-HANGS, frame[1]))
    pole = plus(times(1.0 - person.wraps[k], pole), times(person.wraps[k], aside))
    put(person.wanted, ELBOW + k, bent(shoulder, hand, upper, fore, pole))
    put(person.wanted, HAND + k, hand)


@compiled
def within(root: Vector, tip: Vector, least: float, most: float) -> Vector:
    """Return the place nearest to `tip` at such distances from `root`."""
    away = minus(tip, root)
    size = length(away)
    if size < 1e-9:
        return plus(root, (0.0, -least, 0.0))
    return plus(root, times(min(max(size, least), most) / size, away))


@compiled
def bent(root: Vector, tip: Vector, upper: float, lower: float, pole: Vector) -> Vector:
    """Return the joint between two links of such lengths, on the side of `pole`."""
    along = minus(tip, root)
    size = max(length(along), 1e-9)
    along = times(1.0 / size, along)
    a = (upper * upper - lower * lower + size * size) / (2.0 * size)
    a = min(max(a, -upper), upper)
    out = minus(pole, times(dot(pole, along), along))
    n = length(out)
    if n < 1e-9:
        return plus(root, times(a, along))
    h = math.sqrt(max(upper * upper - a * a, 0.0))
    return plus(root, plus(times(a, along), times(h / n, out)))


STRETCHED = 0.995
"""How long a leg is at most that swings, in the sum of its links."""

OUTWARD = 0.06
"""How far knees go outward as they bend, as a tangent; more for one who sits."""

SQUATS = 0.8
"""How much more when somebody crouches, for arms that reach down between the knees: those that
come down on them are led outside, and hooked there."""

KNOCKED = 0.1
"""How far inward knees point at most [rad], however the foot is turned: they would strike one
another."""

KNEES = 0.094
"""How far apart knees are kept that pass one another, in heights: two thighs beside one another.
"""

NEAR = 3.0
"""How far ahead of one another knees begin to part, in what they are kept apart."""

SLANT = 0.6
"""Sine of the lean of a thigh beyond which no more room is made."""


@compiled
def hold_legs(person: Record) -> None:
    """Say where knees and feet should be."""
    for k in range(2):
        hip, ankle = row(person.wanted, HIP + k), row(person.ankles, k)
        if person.doing[k] == SWING:
            longest = STRETCHED * (person.thigh + person.shin)
            ankle = within(hip, ankle, 0.0, longest)
            put(person.ankles, k, ankle)
        side = 1.0 if k == 1 else -1.0
        inward = side * 0.6 * wrapped(person.yaw[k] - person.heading)
        toes = person.heading + side * min(inward, KNOCKED)
        right = (math.sin(toes), 0.0, math.cos(toes))
        # Ahead of a leg that hangs, above one that lies ahead: nowhere do the two fall together.
        pole = cross(right, minus(ankle, hip))
        side = 1.0 if k == 1 else -1.0
        size = person.thigh + person.shin
        out = side * (OUTWARD + 0.25 * person.seated + SQUATS * person.crouch) * size
        knee = bent(hip, ankle, person.thigh, person.shin, plus(pole, times(out, right)))
        put(person.wanted, KNEE + k, knee)
        put(person.wanted, FOOT + k, ankle)
    _part_knees(person)


@compiled
def _part_knees(person: Record) -> None:
    """Turn knees outward that would strike one another, that of the leg that swings first."""
    ahead = (math.cos(person.heading), 0.0, -math.sin(person.heading))
    right = (math.sin(person.heading), 0.0, math.cos(person.heading))
    room = KNEES * person.height
    first = 0 if person.doing[0] == SWING else 1
    for n in range(2):
        k = first if n == 0 else 1 - first
        side = 1.0 if k == 1 else -1.0
        apart = minus(row(person.wanted, KNEE + k), row(person.wanted, KNEE + 1 - k))
        near = max(1.0 - (dot(apart, ahead) / (NEAR * room)) ** 2, 0.0)
        # Two thighs that lean to a side are nearer than their knees are.
        thigh = minus(row(person.wanted, KNEE + k), row(person.wanted, HIP + k))
        leans = min(abs(dot(thigh, right)) / person.thigh, SLANT)
        lacks = room / math.sqrt(1.0 - leans * leans) * near * near - side * dot(apart, right)
        if lacks > 0.0:
            hip, ankle = row(person.wanted, HIP + k), row(person.wanted, FOOT + k)
            put(person.wanted, KNEE + k, _turned_out(person, k, hip, ankle, lacks, right))


@compiled
def _turned_out(
    person: Record, k: int, hip: Vector, ankle: Vector, much: float, right: Vector
) -> Vector:
    """Return where a knee is that goes so far outward about the line from hip to ankle [m]."""
    knee, along = row(person.wanted, KNEE + k), minus(ankle, hip)
    line = times(1.0 / length(along), along)
    off = minus(knee, hip)
    off = minus(off, times(dot(off, line), line))
    side = 1.0 if k == 1 else -1.0
    far = length(off)
    out = times(side, minus(right, times(dot(right, line), line)))
    out = times(1.0 / length(out), out)
    across = min(dot(off, out) + much, 0.95 * far)
    pole = minus(off, times(dot(off, out), out))
    ahead = length(pole)
    if ahead < 1e-6 or far < 1e-6:
        return knee
    pole = plus(times(math.sqrt(far * far - across * across) / ahead, pole), times(across, out))
    return bent(hip, ankle, person.thigh, person.shin, pole)
