"""Stance foot: a foot that stands stays in place, and rolls off about its ball.

Source: Horswill 2008, "Gait Control".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.deck_motion import support_at
from pipeline.simulation.characters.gait_timing import leg_phase, smoothstep, spring_step
from pipeline.simulation.characters.person_record import STANCE
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.vectors import Vector, hypotenuse, plus, put, row
from pipeline.simulation.spatial import Array

HEEL_RISE_START = 0.55  # fraction of the stance at which the heel rises at the earliest
HEEL_RISE_ANGLE = math.radians(48.0)  # about the ball until lift-off
PITCH_SETTLING_RATE = 83.0  # at which a foot comes to lie flat [1/s]
SETTLING_RATE = 30.0  # at which a caught foot comes to stand [1/s]

# How feet keep clear of the other leg. Lateral clearance is in half hip widths: as near as shins
# can pass, and as walkers place their feet. The other distance is in lateral clearances.
LATERAL_CLEARANCE = 1.16
HEEL_CLEARANCE = 2.5  # distance of the other foot within which the heel does not rise towards it


@compiled
def stand(person: Record, k: int, stance: float, frame: Record, vertices: Array, dt: float) -> None:
    """Keep a stance foot in place, and turn it about its heel or its ball."""
    stance_fraction = (leg_phase(person, k) - (1.0 - stance)) / stance if person.stepping else 0.3
    stance_fraction = min(max(stance_fraction, 0.0), 1.0)
    rise = (
        HEEL_RISE_ANGLE
        * min(person.walk_blend, 1.0)
        * smoothstep((stance_fraction - HEEL_RISE_START) / (1.0 - HEEL_RISE_START) * 0.5)
        * 2.0
    )
    rise *= 1.0 - _heel_obstruction(person, k)
    pitch = -rise if person.stepping else 0.0
    if stance_fraction < HEEL_RISE_START:
        pitch = 0.0
        settle_fraction = 0.06 if person.stepping else 1.0
        settled = smoothstep(min(stance_fraction / settle_fraction, 1.0))
        person.pitch[k] *= math.exp(-PITCH_SETTLING_RATE * settled * dt)
    else:
        person.pitch[k] = pitch
    if person.sit_blend > 0.0:
        person.pitch[k] = -person.seat_heel_rise * smoothstep(person.sit_blend)
    stood = row(person.stance_place, k)
    slope = slope_along(person, frame, vertices, stood, person.yaw[k])
    offset = ankle_offset(person, person.yaw[k], person.pitch[k], slope)
    for i in range(3):
        person.settling[k, i], person.settling_rate[k, i] = spring_step(
            person.settling[k, i], person.settling_rate[k, i], 0.0, SETTLING_RATE, dt
        )
    put(person.ankles, k, plus(plus(stood, offset), row(person.settling, k)))


@compiled
def _heel_obstruction(person: Record, k: int) -> float:
    """Return how much the other leg is in the way of a rising heel, 0 to 1.

    The ankle moves ahead as the heel rises, which is towards the other leg once the pelvis has
    turned away over the foot.
    """
    other_foot = other_ankle(person, k)
    x, z = other_foot[0] - person.stance_place[k, 0], other_foot[2] - person.stance_place[k, 2]
    distance = max(hypotenuse(x, z), 1e-9)
    ahead, _ = ahead_and_right(x, z, person.yaw[k])
    closeness = (HEEL_CLEARANCE - distance / (LATERAL_CLEARANCE * person.hips)) / (
        HEEL_CLEARANCE - 1.0
    )
    return max(ahead / distance, 0.0) * smoothstep(closeness)


@compiled
def slope_along(person: Record, frame: Record, vertices: Array, place: Vector, yaw: float) -> float:
    """Return the slope of the ground or the deck along a foot, upward [rad]."""
    _, n, _ = support_at(person, frame, vertices, place[0], place[2])
    return math.atan2(n[2] * math.sin(yaw) - n[0] * math.cos(yaw), n[1])


@compiled
def ankle_offset(person: Record, yaw: float, pitch: float, slope: float) -> Vector:
    """Return the ankle offset of a foot turned about its ball or its heel [m].

    Args:
        person: `PERSON` record.
        yaw: of the foot [rad].
        pitch: from lying flat, toes up [rad].
        slope: of the ground along the foot [rad].
    """
    c, s = math.cos(pitch), math.sin(pitch)
    ahead = person.ball if pitch < 0.0 else person.ball - 0.72 * person.foot
    # The ankle from the pivot is (-ahead, ankle); toes up is positive.
    x = -ahead * c - person.ankle * s + ahead
    y = -ahead * s + person.ankle * c - person.ankle
    c, s = math.cos(slope), math.sin(slope)
    x, y = c * x - s * y, s * x + c * y
    return (x * math.cos(yaw), y, -x * math.sin(yaw))


@compiled
def other_ankle(person: Record, k: int) -> Vector:
    """Return the place where the ankle of the other foot stands or will stand."""
    return (
        row(person.stance_place, 1 - k)
        if person.foot_state[1 - k] == STANCE
        else row(person.landing_place, 1 - k)
    )


@compiled
def ahead_and_right(x: float, z: float, heading: float) -> tuple[float, float]:
    """Return the components of a ground vector ahead of and to the right of a heading."""
    cos, sin = math.cos(heading), math.sin(heading)
    return x * cos - z * sin, x * sin + z * cos
