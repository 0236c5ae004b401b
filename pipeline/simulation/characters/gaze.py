"""Gaze: the head turns to what is looked at, else to where somebody goes, smoothly.

Source: Horswill 2008, "Limb control", where it turns at once and should not.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.ballistic import sprung
from pipeline.simulation.characters.gait import wrapped
from pipeline.simulation.characters.record import HEAD
from pipeline.simulation.dynamics.compiled import Record, compiled

QUICK = 8.0
"""[rad/s]"""

ASIDE, UP, DOWN = math.radians(72.0), math.radians(45.0), math.radians(50.0)
"""How far a head turns against the shoulders, and up and down."""


@compiled
def look(person: Record, dt: float) -> None:
    """Turn the head by one sub-step."""
    yaw, pitch = person.heading + 0.25 * person.turning, 0.0
    if person.looks:
        x = person.look_at[0] - person.wanted[HEAD, 0]
        y = person.look_at[1] - person.wanted[HEAD, 1]
        z = person.look_at[2] - person.wanted[HEAD, 2]
        if math.hypot(x, z) > 1e-6:
            yaw = math.atan2(-z, x)
        pitch = math.atan2(y, math.hypot(x, z))
    chest = person.heading + person.twist
    off = wrapped(yaw - person.heading)
    # Beyond what neck and shoulders turn together: straight over the shoulder.
    off = min(max(off, -2.2), 2.2)
    most = ASIDE + abs(person.twist)
    off = min(max(off, -most), most)
    yaw = person.heading + off
    pitch = min(max(pitch, -DOWN), UP)
    now, rate = wrapped(person.gaze[0] - person.heading), person.gaze_rate[0]
    now, person.gaze_rate[0] = sprung(now, rate, wrapped(yaw - person.heading), QUICK, dt)
    middle = wrapped(chest - person.heading)
    person.gaze[0] = person.heading + min(max(now, middle - ASIDE), middle + ASIDE)
    person.gaze[1], person.gaze_rate[1] = sprung(
        person.gaze[1], person.gaze_rate[1], pitch, QUICK, dt
    )
