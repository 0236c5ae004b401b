"""Leg forces of landing and pushing, and the attitude that they control.

Forces are constant within a phase. A change of velocity and a change of height give the time,
Δt = 2 Δy / (v_y0 + v_y1), the acceleration, A = ΔV / Δt, and the force of all legs together,
F = m (A - G).

Equal forces at the hips turn the body wherever its centre of mass is not at their centroid, so
the legs add a moment. It is to turn the body by e within a time τ, ending at the rate w₁. Of all
motions that do so, the one of least squared angular acceleration starts with

    α = 6 e / τ² - (4 w + 2 w₁) / τ,

which is evaluated anew at every instant. The moments about horizontal axes and about the vertical
are bounded; beyond the bounds the body turns as it must.

Source: Sims 1987, 11.2 and 11.3, (11.5) being y_c - y_0; 7.1, (7.6) being L × F and (7.7) holding
for isotropic inertia only. Raibert 1986 for controlling attitude in stance alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.scalar_rotation import (
    Quaternion,
    Rows,
    Vector,
    cross_product,
    from_rotation_vector,
    matrix_rows,
    normalize_quaternion,
    quaternion_conjugate,
    quaternion_product,
    rotate,
    rotate_inverse,
    to_rotation_vector,
)
from pipeline.simulation.spatial import Array

MAX_CONTROL_STEP, MAX_FREE_STEP = 1.0 / 90.0, 1.0 / 60.0
"""Longest step of the integration, while legs control attitude and in flight [s]."""

MIN_CORRECTION_TIME = 0.08
"""Shortest time in which legs correct an attitude [s]."""

TIME_TOLERANCE = 1e-12
"""Times shorter than this count as zero [s]."""

RATE_ITERATIONS = 5
"""Iterations that find the lift-off rate."""

AttitudeState = tuple[Quaternion, Vector]
"""Attitude, and angular velocity in the world [rad/s]."""

ZERO_VECTOR: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class PhaseForce:
    """A constant force and its effect.

    Attributes:
        force: of all legs together [N].
        acceleration: of the centre of mass [m/s²].
        time: until the vertical speed has changed as requested; infinite if it cannot [s].
        saturated: whether the request exceeds the legs' force.
    """

    force: Vector
    acceleration: Vector
    time: float
    saturated: bool


def phase_force(mass: float, max_force: float, v0: Vector, v1: Vector, rise: float) -> PhaseForce:
    """Return the force that changes the velocity within a change of height.

    Args:
        mass: of the body [kg].
        max_force: of all legs on the ground together [N].
        v0: current velocity [m/s].
        v1: final velocity; v0_y + v1_y has the sign of `rise` [m/s].
        rise: change of height [m].
    """
    time = 2.0 * rise / (v0[1] + v1[1])
    x, y, z = ((b - a) / time for a, b in zip(v0, v1, strict=True))
    force = mass * x, mass * (y + GRAVITY), mass * z
    size = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    if size <= max_force:
        return PhaseForce(force, (x, y, z), time, False)
    k = max_force / size
    force = k * force[0], k * force[1], k * force[2]
    x, y, z = force[0] / mass, force[1] / mass - GRAVITY, force[2] / mass
    change = v1[1] - v0[1]
    return PhaseForce(force, (x, y, z), change / y if change * y > 0.0 else math.inf, True)


def distribute_force(force: Array, moment: Array, levers: Array, max_force: float) -> Array:
    """Return the forces (n, 3) of legs: equal shares, and as much of a moment as their hips allow.

    The rest of the moment, all of it for a single leg, is a torque at the hips, in equal shares. No
    leg pulls, and none exceeds `max_force`.

    Args:
        force: (3,) of all legs together [N].
        moment: (3,) of all legs together, beside that of equal shares [N m].
        levers: (n, 3) from the centre of mass to the hips of the loaded legs, in the world [m].
        max_force: of one leg [N].
    """
    count = len(levers)
    equal = np.tile(force / count, (count, 1))
    arms = levers - levers.mean(axis=0)
    spread = np.stack([np.ones(count), -arms[:, 2], arms[:, 0]])
    # L × (0, f, 0) = (-L_z f, 0, L_x f): the least-squares f whose sum is zero.
    wanted = np.array([0.0, moment[0], moment[2]])
    couple = np.linalg.pinv(spread, rcond=1e-9) @ wanted
    couple -= couple.mean()
    size = float(np.sqrt((equal[0] ** 2).sum()))
    room = min(max(max_force - size, 0.0), float(equal[0, 1]))
    greatest = float(np.abs(couple).max(initial=0.0))
    part = min(1.0, room / greatest) if greatest > 0.0 else 0.0
    equal[:, 1] += part * couple
    return equal


@dataclass(frozen=True, slots=True)
class BodyInertia:
    """Moments of inertia along the axes of the body [kg m²], and their inverse."""

    tensor: Rows
    inverse: Rows


@dataclass(frozen=True, slots=True)
class AttitudeControl:
    """What turns a body during a phase.

    Attributes:
        force: of all legs together, in the world [N].
        lever: from the centre of mass to the mean of the carrying hips, in the body [m].
        goal: attitude at the end; None while no foot is down.
        rate: angular velocity at the end, in the world [rad/s].
        end: time of the goal [s].
        balance, twist: bounds of the moments about horizontal and vertical axes [N m].
    """

    force: Vector = ZERO_VECTOR
    lever: Vector = ZERO_VECTOR
    goal: Quaternion | None = None
    rate: Vector = ZERO_VECTOR
    end: float = 0.0
    balance: float = 0.0
    twist: float = 0.0


NO_CONTROL = AttitudeControl()
"""Control of a free body."""


def integrate_attitude(
    now: AttitudeState, inertia: BodyInertia, control: AttitudeControl, time: float, h: float
) -> AttitudeState:
    """Return attitude and angular velocity a time `h` after `time` [s], by a Runge-Kutta method."""
    if now[1] == ZERO_VECTOR and not any(_acceleration(now, inertia, control, time)):
        return now
    # The requested acceleration has a kink where the remaining time reaches its lower bound.
    kink = control.end - MIN_CORRECTION_TIME - time
    if control.goal is not None and TIME_TOLERANCE < kink < h - TIME_TOLERANCE:
        now = integrate_attitude(now, inertia, control, time, kink)
        time, h = time + kink, h - kink
    longest = MAX_FREE_STEP if control.goal is None else MAX_CONTROL_STEP
    count = max(1, math.ceil(h / longest - 1e-9))
    for k in range(count):
        now = _step(now, inertia, control, time + k * h / count, h / count)
    return now


def lift_off_rate(
    q: Quaternion, goal: Quaternion, inertia: BodyInertia, push: float, flight: float
) -> tuple[Quaternion, Vector]:
    """Return attitude and rate at lift-off from which a free body turns to a goal.

    The rate grows during the push, so half of the push counts. The axes are coupled: the free
    motion is integrated, and the remaining error added.

    Args:
        q: attitude at the start of the push.
        goal: attitude at the end of the flight.
        inertia: of the body.
        push: duration of the push [s].
        flight: duration of the flight [s].
    """
    turn = to_rotation_vector(quaternion_product(goal, quaternion_conjugate(q)))
    time = 0.5 * push + flight
    rate: Vector = turn[0] / time, turn[1] / time, turn[2] / time
    for k in range(RATE_ITERATIONS):
        half = 0.5 * push
        part = from_rotation_vector((half * rate[0], half * rate[1], half * rate[2]))
        start = quaternion_product(part, q)
        if rate == ZERO_VECTOR or k == RATE_ITERATIONS - 1:
            break
        there, _ = integrate_attitude((start, rate), inertia, NO_CONTROL, 0.0, flight)
        error = to_rotation_vector(quaternion_product(goal, quaternion_conjugate(there)))
        rate = rate[0] + error[0] / time, rate[1] + error[1] / time, rate[2] + error[2] / time
    return start, rate


def moment(
    now: AttitudeState, inertia: BodyInertia, control: AttitudeControl, time: float
) -> Vector:
    """Return the control moment of the legs about the centre of mass, in the world [N m]."""
    R = matrix_rows(now[0])
    return _control_moment(
        R,
        now,
        inertia,
        control,
        time,
        _gyroscopic_moment(R, now[1], inertia),
        _force_moment(R, control),
    )


def _acceleration(
    now: AttitudeState, inertia: BodyInertia, control: AttitudeControl, time: float
) -> Vector:
    R = matrix_rows(now[0])
    gyroscopic = _gyroscopic_moment(R, now[1], inertia)
    if control.goal is None:
        # No moment acts in half of the calls; this is quicker.
        return _apply_tensor(
            R, inertia.inverse, (0.0 - gyroscopic[0], 0.0 - gyroscopic[1], 0.0 - gyroscopic[2])
        )
    given = _force_moment(R, control)
    legs = _control_moment(R, now, inertia, control, time, gyroscopic, given)
    x = given[0] + legs[0] - gyroscopic[0]
    y = given[1] + legs[1] - gyroscopic[1]
    z = given[2] + legs[2] - gyroscopic[2]
    # Within the bounds the moments cancel but for rounding, which must not turn the body.
    tiny = 1e-12 * (abs(given[0]) + abs(given[1]) + abs(given[2]))
    x = 0.0 if abs(x) < tiny else x
    y = 0.0 if abs(y) < tiny else y
    z = 0.0 if abs(z) < tiny else z
    return _apply_tensor(R, inertia.inverse, (x, y, z))


def _gyroscopic_moment(R: Rows, w: Vector, inertia: BodyInertia) -> Vector:
    """Return ω × I ω [N m]."""
    return cross_product(w, _apply_tensor(R, inertia.tensor, w))


def _force_moment(R: Rows, control: AttitudeControl) -> Vector:
    """Return the moment of equal forces at the hips [N m]."""
    return cross_product(rotate(R, control.lever), control.force)


def _control_moment(
    R: Rows,
    now: AttitudeState,
    inertia: BodyInertia,
    control: AttitudeControl,
    time: float,
    gyroscopic: Vector,
    given: Vector,
) -> Vector:
    """Return the moment that the legs add, within its bounds [N m]."""
    if control.goal is None:
        return ZERO_VECTOR
    need = _apply_tensor(R, inertia.tensor, _wanted_acceleration(now, control, time))
    x = need[0] + gyroscopic[0] - given[0]
    y = need[1] + gyroscopic[1] - given[1]
    z = need[2] + gyroscopic[2] - given[2]
    level = math.hypot(x, z)
    k = min(1.0, control.balance / level) if level > 0.0 else 1.0
    return k * x, min(max(y, -control.twist), control.twist), k * z


def _wanted_acceleration(now: AttitudeState, control: AttitudeControl, time: float) -> Vector:
    """Return the requested angular acceleration [rad/s²]."""
    q, w = now
    assert control.goal is not None
    remaining = control.end - time
    tau = max(remaining, MIN_CORRECTION_TIME)
    e = to_rotation_vector(quaternion_product(control.goal, quaternion_conjugate(q)))
    delay = tau - remaining
    x, y, z = (
        6.0 * (e[i] + delay * control.rate[i]) / tau**2 - (4.0 * w[i] + 2.0 * control.rate[i]) / tau
        for i in range(3)
    )
    return x, y, z


def _step(
    now: AttitudeState, inertia: BodyInertia, control: AttitudeControl, t: float, h: float
) -> AttitudeState:
    half = 0.5 * h
    a, a_w = _derivative(now, inertia, control, t)
    b, b_w = _derivative(_advanced(now, a, a_w, half), inertia, control, t + half)
    c, c_w = _derivative(_advanced(now, b, b_w, half), inertia, control, t + half)
    d, d_w = _derivative(_advanced(now, c, c_w, h), inertia, control, t + h)
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
    return _advanced(now, mean, mean_w, h)


def _derivative(
    now: AttitudeState, inertia: BodyInertia, control: AttitudeControl, time: float
) -> tuple[Quaternion, Vector]:
    q, (x, y, z) = now
    a, b, c, d = quaternion_product((0.0, x, y, z), q)
    return (0.5 * a, 0.5 * b, 0.5 * c, 0.5 * d), _acceleration(now, inertia, control, time)


def _advanced(now: AttitudeState, rate: Quaternion, change: Vector, part: float) -> AttitudeState:
    (a, b, c, d), (x, y, z) = now
    k_a, k_b, k_c, k_d = rate
    k_x, k_y, k_z = change
    q = normalize_quaternion((a + part * k_a, b + part * k_b, c + part * k_c, d + part * k_d))
    return q, (x + part * k_x, y + part * k_y, z + part * k_z)


def _apply_tensor(R: Rows, tensor: Rows, v: Vector) -> Vector:
    """Return R I Rᵀ v."""
    return rotate(R, rotate(tensor, rotate_inverse(R, v)))
