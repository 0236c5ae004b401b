"""Legs: knees between hips and feet, bent forward."""

from __future__ import annotations

import math

from pipeline.simulation.characters.arms import bent, within
from pipeline.simulation.characters.gait import wrapped
from pipeline.simulation.characters.record import FOOT, HIP, KNEE, SWING
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
