"""Turning: attitudes that follow a given angular velocity, or a given torque.

A velocity in pieces turns by Magnus' series: over a short time h, R' = [ω] R is solved by the
rotation about

    Ω = ∫ω dt + (√3 h² / 12) ω₂ × ω₁,

ω₁ and ω₂ at Gauss' two points. The integral is exact; the second term, of fourth order, is
zero while the axis stays, so that such a turn is exact however fast it changes.

A torque in pieces turns a rigid body by Euler's equations, with the rule of Runge and Kutta
in short steps: I ω' = (I ω) × ω + Rᵀ τ - c ω, with ω in the frame of the body.

Source: Sims 1987, 3.1.2, 3.1.3 and 7.1; Iserles and Nørsett 1999 for the series.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.pieces import Carried, Pieces
from pipeline.simulation.spatial import Array, cross, matrix, quaternion, rotation

SHORT = 1.0 / 240.0
"""Longest step of an attitude [s]."""

MOST_TURN = 0.02
"""Angle that a step of Runge and Kutta may turn by, about [rad]: errors are then near 1e-11."""

HALVES = np.array([0.0, 0.5, 1.0])
GAUSS = np.array([0.5 - math.sqrt(3.0) / 6.0, 0.5 + math.sqrt(3.0) / 6.0])


class Spun:
    """An attitude under an angular velocity in the world; asked for at ascending times.

    Attributes:
        R: (3, 3) attitude at the time last asked for.
    """

    def __init__(self, spin: Pieces, R: Array) -> None:
        self.spin = spin
        self.R = R
        self._time = 0.0
        self._angles = Carried.by_velocity(spin, np.zeros(3))

    def at(self, time: float) -> Array:
        """Return the attitude (3, 3) at a time not before the last [s]."""
        for begin, h in _steps(self._time, time, self.spin.begins, SHORT):
            ends = self._angles.at(np.array([begin, begin + h]))[0]
            first, second = self.spin.after(begin, h * GAUSS)
            about = ends[1] - ends[0] + math.sqrt(3.0) / 12.0 * h * h * cross(second, first)
            angle = math.sqrt(float(about[0] ** 2 + about[1] ** 2 + about[2] ** 2))
            if angle > 0.0:
                self.R = rotation(about / angle, angle) @ self.R
        self._time = time
        return self.R


class Torqued:
    """An attitude under a torque in the world; asked for at ascending times.

    Attributes:
        q: (4,) attitude wxyz at the time last asked for.
        w: (3,) angular velocity then, in the frame of the body [rad/s].
    """

    def __init__(
        self, torque: Pieces, mass: MassProperties, R: Array, spin: Array, drag: float
    ) -> None:
        self.torque = torque
        self.inertia = mass.inertia
        self.drag = drag
        self.q = quaternion(R)
        self.w: Array = (R.T * spin).sum(axis=-1)
        self._inverse = np.linalg.inv(mass.inertia)
        self._time = 0.0

    def at(self, time: float) -> Array:
        """Return the attitude (3, 3) at a time not before the last [s]."""
        fastest = math.sqrt(float((self.w**2).sum()))
        short = min(SHORT, MOST_TURN / max(fastest, 1e-9))
        for begin, h in _steps(self._time, time, self.torque.begins, short):
            self._step(h, self.torque.after(begin, h * HALVES))
        self._time = time
        return matrix(self.q)

    def _step(self, h: float, taus: Array) -> None:
        """Go on by h [s], under torques (3, 3) at its begin, middle and end."""
        q, w = self.q, self.w
        q1, w1 = self._rates(q, w, taus[0])
        q2, w2 = self._rates(q + 0.5 * h * q1, w + 0.5 * h * w1, taus[1])
        q3, w3 = self._rates(q + 0.5 * h * q2, w + 0.5 * h * w2, taus[1])
        q4, w4 = self._rates(q + h * q3, w + h * w3, taus[2])
        q = q + h / 6.0 * (q1 + 2.0 * q2 + 2.0 * q3 + q4)
        self.w = w + h / 6.0 * (w1 + 2.0 * w2 + 2.0 * w3 + w4)
        self.q = q / math.sqrt(float((q * q).sum()))

    def _rates(self, q: Array, w: Array, torque: Array) -> tuple[Array, Array]:
        R = matrix(q)
        own = (R.T * torque).sum(axis=-1)
        turning = (self.inertia * w).sum(axis=-1)
        change = (self._inverse * (cross(turning, w) + own - self.drag * w)).sum(axis=-1)
        a, v = q[0], q[1:]
        rate = np.empty(4)
        rate[0] = -0.5 * (v * w).sum()
        rate[1:] = 0.5 * (a * w + cross(v, w))
        return rate, change


def _steps(
    start: float, end: float, begins: Array, longest: float
) -> list[tuple[float, float]]:
    """Return begins and lengths of the steps from `start` to `end` that cross no piece [s]."""
    between = begins[(begins > start) & (begins < end)]
    edges = [start, *(float(b) for b in np.unique(between)), end]
    steps = []
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        count = max(math.ceil((b - a) / longest - 1e-9), 1)
        h = (b - a) / count
        if h > 0.0:
            steps += [(a + k * h, h) for k in range(count)]
    return steps
