"""Attitude: how the body of a pronker turns, and the moment with which its legs steer that.

Equal forces at the hips turn the body wherever its centre of mass is not at their centroid,
and nothing brings it back. So legs give a moment besides. What is wanted is to have turned by
e, and to turn at a rate w₁, when the phase ends in a time τ; of all ways there the one of
least squared angular acceleration begins with

    α = 6 e / τ² - (4 w + 2 w₁) / τ,

asked for anew at every moment. The moment about horizontal axes is bounded, and so is that
about the vertical. Past the bound the body turns as it must.

Source: Raibert 1986 for attitude served in stance alone; Sims 1987, 7.1, where (7.6) is L × F
and (7.7) holds for isotropic inertia only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeline.simulation.locomotion.pronking import spin
from pipeline.simulation.locomotion.pronking.spin import Quaternion, Rows, Vector

LONGEST, FREE_LONGEST = 1.0 / 90.0, 1.0 / 60.0
"""Longest step of the integration, while legs steer and in flight [s]."""

SOONEST = 0.08
"""Time in which legs correct an attitude at the soonest [s]."""

TINY = 1e-12
"""Time that is none [s]."""

ROUNDS = 5
"""In which the rate is found with which a body turns to where it is to be."""

Turning = tuple[Quaternion, Vector]
"""Attitude, and angular velocity in the world [rad/s]."""

NONE: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Inertia:
    """Moments of inertia along the axes of the body [kg m²], and their inverse."""

    tensor: Rows
    inverse: Rows


@dataclass(frozen=True, slots=True)
class Steering:
    """What turns a body during a phase.

    Attributes:
        force: of all legs together, in the world [N].
        lever: from the centre of mass to the middle of the hips that carry, in the body [m].
        goal: attitude wanted at the end; None while no foot is down.
        rate: angular velocity wanted then, in the world [rad/s].
        end: when that is [s].
        balance, twist: bounds of the moments about horizontal and vertical axes [N m].
    """

    force: Vector = NONE
    lever: Vector = NONE
    goal: Quaternion | None = None
    rate: Vector = NONE
    end: float = 0.0
    balance: float = 0.0
    twist: float = 0.0


FREE = Steering()
"""Of a body that nothing turns."""


def turned(now: Turning, inertia: Inertia, by: Steering, time: float, h: float) -> Turning:
    """Return attitude and angular velocity a time `h` after `time` [s], by Runge and Kutta."""
    if now[1] == NONE and not any(_acceleration(now, inertia, by, time)):
        return now
    # What is wanted has a kink where the time that is left comes to the soonest.
    kink = by.end - SOONEST - time
    if by.goal is not None and TINY < kink < h - TINY:
        now = turned(now, inertia, by, time, kink)
        time, h = time + kink, h - kink
    longest = FREE_LONGEST if by.goal is None else LONGEST
    count = max(1, math.ceil(h / longest - 1e-9))
    for k in range(count):
        now = _step(now, inertia, by, time + k * h / count, h / count)
    return now


def rate_for(
    q: Quaternion, goal: Quaternion, inertia: Inertia, push: float, flight: float
) -> tuple[Quaternion, Vector]:
    """Return attitude and rate at lift-off from which a body turns by itself to a goal.

    The rate grows during the push, of which half of the time counts. No axis is free of the
    others, so where a body gets to is worked out and the rest of the way added.

    Args:
        q: attitude at the begin of the push.
        goal: attitude at the end of the flight.
        inertia: of the body.
        push: how long the push takes [s].
        flight: how long the flight takes [s].
    """
    way = spin.to_vector(spin.times(goal, spin.inverse(q)))
    time = 0.5 * push + flight
    rate: Vector = way[0] / time, way[1] / time, way[2] / time
    for k in range(ROUNDS):
        half = 0.5 * push
        part = spin.of_vector((half * rate[0], half * rate[1], half * rate[2]))
        start = spin.times(part, q)
        if rate == NONE or k == ROUNDS - 1:
            break
        there, _ = turned((start, rate), inertia, FREE, 0.0, flight)
        off = spin.to_vector(spin.times(goal, spin.inverse(there)))
        rate = rate[0] + off[0] / time, rate[1] + off[1] / time, rate[2] + off[2] / time
    return start, rate


def moment(now: Turning, inertia: Inertia, by: Steering, time: float) -> Vector:
    """Return the moment of the legs about the centre of mass, in the world [N m]."""
    R = spin.rows(now[0])
    return _legs(R, now, inertia, by, time, _own(R, now[1], inertia), _given(R, by))


def _acceleration(now: Turning, inertia: Inertia, by: Steering, time: float) -> Vector:
    R = spin.rows(now[0])
    own = _own(R, now[1], inertia)
    if by.goal is None:
        # Nothing gives a moment: this is half of the calls, and quicker so.
        return _with_inertia(R, inertia.inverse, (0.0 - own[0], 0.0 - own[1], 0.0 - own[2]))
    given = _given(R, by)
    legs = _legs(R, now, inertia, by, time, own, given)
    x = given[0] + legs[0] - own[0]
    y = given[1] + legs[1] - own[1]
    z = given[2] + legs[2] - own[2]
    # Where no bound is met the moments cancel but for rounding, which is not to turn it.
    tiny = 1e-12 * (abs(given[0]) + abs(given[1]) + abs(given[2]))
    x = 0.0 if abs(x) < tiny else x
    y = 0.0 if abs(y) < tiny else y
    z = 0.0 if abs(z) < tiny else z
    return _with_inertia(R, inertia.inverse, (x, y, z))


def _own(R: Rows, w: Vector, inertia: Inertia) -> Vector:
    """Return ω × I ω [N m]."""
    return spin.cross(w, _with_inertia(R, inertia.tensor, w))


def _given(R: Rows, by: Steering) -> Vector:
    """Return the moment that equal forces at the hips give [N m]."""
    return spin.cross(spin.applied(R, by.lever), by.force)


def _legs(
    R: Rows, now: Turning, inertia: Inertia, by: Steering, time: float, own: Vector, given: Vector
) -> Vector:
    """Return the moment of the legs beside that, within its bounds [N m]."""
    if by.goal is None:
        return NONE
    need = _with_inertia(R, inertia.tensor, _wanted(now, by, time))
    x = need[0] + own[0] - given[0]
    y = need[1] + own[1] - given[1]
    z = need[2] + own[2] - given[2]
    level = math.hypot(x, z)
    k = min(1.0, by.balance / level) if level > 0.0 else 1.0
    return k * x, min(max(y, -by.twist), by.twist), k * z


def _wanted(now: Turning, by: Steering, time: float) -> Vector:
    """Return the angular acceleration that is wanted [rad/s²]."""
    q, w = now
    assert by.goal is not None
    left = by.end - time
    tau = max(left, SOONEST)
    e = spin.to_vector(spin.times(by.goal, spin.inverse(q)))
    on = tau - left
    x, y, z = (
        6.0 * (e[i] + on * by.rate[i]) / tau**2 - (4.0 * w[i] + 2.0 * by.rate[i]) / tau
        for i in range(3)
    )
    return x, y, z


def _step(now: Turning, inertia: Inertia, by: Steering, t: float, h: float) -> Turning:
    half = 0.5 * h
    a, a_w = _slope(now, inertia, by, t)
    b, b_w = _slope(_along(now, a, a_w, half), inertia, by, t + half)
    c, c_w = _slope(_along(now, b, b_w, half), inertia, by, t + half)
    d, d_w = _slope(_along(now, c, c_w, h), inertia, by, t + h)
    mean = (
        (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0]) / 6.0,
        (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1]) / 6.0,
        (a[2] + 2.0 * b[2] + 2.0 * c[2] + d[2]) / 6.0,
        (a[3] + 2.0 * b[3] + 2.0 * c[3] + d[3]) / 6.0,
    )
    mean_w = (
        (a_w[0] + 2.0 * b_w[0] + 2.0 * c_w[0] + d_w[0]) / 6.0,
        (a_w[1] + 2.0 * b_w[1] + 2.0 * c_w[1] + d_w[1]) / 6.0,
        (a_w[2] + 2.0 * b_w[2] + 2.0 * c_w[2] + d_w[2]) / 6.0,
    )
    return _along(now, mean, mean_w, h)


def _slope(at: Turning, inertia: Inertia, by: Steering, time: float) -> tuple[Quaternion, Vector]:
    q, (x, y, z) = at
    a, b, c, d = spin.times((0.0, x, y, z), q)
    return (0.5 * a, 0.5 * b, 0.5 * c, 0.5 * d), _acceleration(at, inertia, by, time)


def _along(now: Turning, rate: Quaternion, change: Vector, part: float) -> Turning:
    (a, b, c, d), (x, y, z) = now
    k_a, k_b, k_c, k_d = rate
    k_x, k_y, k_z = change
    q = spin.normal((a + part * k_a, b + part * k_b, c + part * k_c, d + part * k_d))
    return q, (x + part * k_x, y + part * k_y, z + part * k_z)


def _with_inertia(R: Rows, tensor: Rows, v: Vector) -> Vector:
    """Return R I Rᵀ v."""
    return spin.applied(R, spin.applied(tensor, spin.unapplied(R, v)))
