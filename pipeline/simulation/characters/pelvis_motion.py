"""Pelvis motion."""

from __future__ import annotations

import math

from pipeline.simulation.characters.biped_gait import GAIN
from pipeline.simulation.characters.gait_timing import (
    eased,
    leg_of,
    relative,
    speed_of,
    sprung,
    wrapped,
)
from pipeline.simulation.characters.person_record import FOOT, PELVIS, SITTING
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.grid import Grid, surface

MOST = 0.22
"""How much legs speed up or brake, in g."""

GIVES = 7.0
"""How quickly the carriage comes along with a pelvis that is pushed off [1/s]."""

LOOSE, SHOVED = 0.012, 0.1
"""How far a pelvis is off that nobody minds, and that makes somebody go along, in legs."""

STAGGER = 0.5
"""How fast legs come after who is shoved, as a part of √(g l); who is thrown is thrown."""

RESTS = 1.6
"""How quickly one who stands shifts over the middle of the feet [1/s]."""

BRAKE = 0.08
"""How gently somebody stops who has come to a place, in g."""

THERE = 0.08
"""How near a place is there, in legs."""

HIKE, FALL = 3.5, 0.05
"""How much steepness slows walkers down, and which slope downhill is easiest."""

TURN = 2.6
"""How fast somebody turns [rad/s]."""


@compiled
def lead(person: Record, nodes: Records, ground: Grid, dt: float) -> None:
    """Go on with the carriage by one sub-step."""
    wx, wz = _walk_vector(person)
    ease = _ease(person, wx, wz, ground)
    wx, wz = ease * wx, ease * wz
    _steer_heading(person, wx, wz, dt)
    _go(person, nodes, wx, wz, dt)
    relative_speed = relative(speed_of(person), leg_of(person))
    walking = eased(relative_speed / 0.3) if person.stepping else 0.0
    person.walking, person.walking_rate = sprung(
        person.walking, person.walking_rate, walking, 6.0, dt
    )


@compiled
def halt(person: Record) -> None:
    """Let one who is frozen have no motion of its own: it sets out from rest again."""
    for c in range(2):
        person.going[c] = person.gaining[c] = 0.0
    person.turning = 0.0


@compiled
def _walk_vector(person: Record) -> tuple[float, float]:
    """Return the velocity that is walked with [m/s]."""
    wx, wz = 0.0, 0.0
    if person.goes:
        x, z = person.goal[0] - person.at[0], person.goal[1] - person.at[1]
        away = math.hypot(x, z)
        left = max(away - person.near, 0.0)
        # Slow down so that braking gently ends at the goal.
        speed = min(person.pace, math.sqrt(2.0 * BRAKE * GRAVITY * left), 0.5 * GAIN * left)
        if left < THERE * leg_of(person):
            person.goes, person.arrived = False, True
        if away > 1e-9:
            wx, wz = speed * x / away, speed * z / away
    wx, wz = wx + person.aside[0], wz + person.aside[1]
    if person.posture == SITTING or person.seated > 0.03 or person.frozen:
        wx, wz = 0.0, 0.0
    speed = math.hypot(wx, wz)
    if speed > 1e-6 and not person.faces:
        # Who has to turn far first turns, and then walks.
        turn = abs(wrapped(math.atan2(-wz, wx) - person.heading))
        share = min(max((math.radians(115.0) - turn) / math.radians(60.0), 0.0), 1.0)
        wx, wz = wx * share, wz * share
    return wx, wz


@compiled
def _ease(person: Record, wx: float, wz: float, ground: Grid) -> float:
    """Return by how much somebody slows down on a slope.

    Source: Tobler 1993; half as much, for his hikers have a long way to go.
    """
    speed = math.hypot(wx, wz)
    if speed < 1e-6:
        return 1.0
    ahead = 0.4 * leg_of(person) / speed
    x, z = person.at[0], person.at[1]
    here, _ = surface(ground.frame, ground.vertices, x - ahead * wx, z - ahead * wz)
    there, _ = surface(ground.frame, ground.vertices, x + ahead * wx, z + ahead * wz)
    slope = (there - here) / (2.0 * ahead * speed)
    return math.exp(-0.5 * HIKE * max(abs(slope + FALL) - FALL, 0.0))


@compiled
def _steer_heading(person: Record, wx: float, wz: float, dt: float) -> None:
    """Turn towards where somebody walks, or is to face."""
    wanted = person.heading
    x, z = person.goal[0] - person.at[0], person.goal[1] - person.at[1]
    if person.faces:
        wanted = person.facing
    elif person.goes and math.hypot(x, z) > max(person.near, 0.12 * leg_of(person)):
        wanted = math.atan2(-z - person.aside[1], x + person.aside[0])
    elif math.hypot(wx, wz) > 0.12 * math.sqrt(GRAVITY * leg_of(person)):
        wanted = math.atan2(-wz, wx)
    if person.frozen or person.posture == SITTING:
        wanted = person.heading
    off = wrapped(wanted - person.heading)
    rate = min(max(3.2 * off, -TURN), TURN)
    gain = min(max(9.0 * (rate - person.turning), -14.0), 14.0)
    person.turning += gain * dt
    person.heading = wrapped(person.heading + person.turning * dt)


@compiled
def _go(person: Record, nodes: Records, wx: float, wz: float, dt: float) -> None:
    """Move the carriage with its velocity, and along with the body."""
    leg, most = leg_of(person), MOST * GRAVITY
    gain_x, gain_z = GAIN * (wx - person.going[0]), GAIN * (wz - person.going[1])
    size = math.hypot(gain_x, gain_z)
    if size > most:
        gain_x, gain_z = gain_x * most / size, gain_z * most / size
    person.gaining[0], person.gaining[1] = gain_x, gain_z
    node = nodes[person.node + PELVIS]
    sits = person.posture == SITTING or person.seated > 0.03
    for c in range(2):
        axis = 2 * c
        off = node.p[axis] - person.wanted[PELVIS, axis]
        loose = LOOSE * leg
        beyond = 0.0 if sits else off - min(max(off, -loose), loose)
        # Who is shoved goes with the shove: as fast as the body, not faster.
        shoved = min(abs(beyond) / (SHOVED * leg), 1.0)
        v = (node.p[axis] - node.before[axis]) / dt
        gain = gain_x if c == 0 else gain_z
        person.going[c] += (gain + GIVES * shoved * (v - person.going[c])) * dt
        shift = GIVES * beyond * dt
        person.at[c] += person.going[c] * dt + shift
        # Where it should be moves over to where it is; that is no motion of its own.
        for k in range(FOOT):
            person.before[k, axis] += shift
    most = max(1.1 * person.pace, STAGGER * math.sqrt(GRAVITY * leg))
    share = min(most / max(speed_of(person), 1e-9), 1.0)
    person.going[0], person.going[1] = share * person.going[0], share * person.going[1]
    if not person.stepping and person.posture != SITTING and person.seated < 0.03:
        for c in range(2):
            middle = 0.5 * (person.stood[0, 2 * c] + person.stood[1, 2 * c])
            person.at[c] += RESTS * (middle - person.at[c]) * dt


TIME = 1.5
"""That it takes to sit down or to stand up [s]."""


@compiled
def sit(person: Record, dt: float) -> None:
    """Go on with sitting down or standing up; nobody begins it before standing still."""
    down = person.posture == SITTING
    stands = not person.stepping and speed_of(person) < 0.04 * leg_of(person)
    if person.frozen or (down and person.seated == 0.0 and not stands):
        return
    step = dt / TIME if down else -dt / TIME
    person.seated = min(max(person.seated + step, 0.0), 1.0)
