"""Arms: they swing along, are held out, close around somebody, or go where they are told.

The place of a hand is kept in the frame of the chest and goes to where it should be as a
ballistic motion, so that whatever follows whatever, hands go smoothly. Elbows hang below and
behind the line from shoulder to hand, as far as the lengths of both links say.

Source: Horswill 2008, "Limb control" and "Hugging".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.ballistic import sprung
from pipeline.simulation.characters.gait import leg_of, pace_of, speed_of
from pipeline.simulation.characters.record import (
    AT_EASE,
    ELBOW,
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
    SWINGING,
)
from pipeline.simulation.characters.strides import relative, running
from pipeline.simulation.characters.trunk import Frame, chest_frame, from_frame, turn_of
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

QUICK = 7.0
"""How quickly hands go where they are told; they are there after about 5/ω [rad/s]."""

LONGEST = 0.97
"""Of an arm that is held out, as a part of its length."""

BOWS, DEEPEST_BOW, DEEPEST_CROUCH = 0.45, 1.5, 0.66
"""How far shoulders have to come down, in their height, for the deepest bow; the tangent of
that; and how far hips come down, in their height."""

HANGS = 0.35
"""How far elbows hang that are aside, as a tangent."""

SWING = math.radians(23.0)
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
            person.told[k], person.told_rate[k], wants, QUICK, dt
        )
        person.wraps[k], person.wraps_rate[k] = sprung(
            person.wraps[k],
            person.wraps_rate[k],
            1.0 if person.arm[k] == HUGGING else 0.0,
            QUICK,
            dt,
        )
        for c in range(3):
            person.hand[k, c], person.hand_rate[k, c] = sprung(
                person.hand[k, c], person.hand_rate[k, c], place[c], 1.6 * QUICK, dt
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
    angle = SWING * some * swing * (0.9 + 0.5 * run) + AT_EASE[0]
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
        ahead = LONGEST * (person.upper_arm + person.forearm)
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
