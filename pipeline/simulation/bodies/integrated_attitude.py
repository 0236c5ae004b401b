"""Integrated attitude: rotation under a given angular velocity, or a given torque.

A piecewise angular velocity is integrated by Magnus' series: over a short time h, R' = [ω] R is
solved by the rotation about

    Ω = ∫ω dt + (√3 h² / 12) ω₂ × ω₁,

ω₁ and ω₂ at Gauss' two points. The integral is exact; the second term, of fourth order, is zero
while the axis is constant, so that such a rotation is exact however fast it changes.

A piecewise torque turns a rigid body by Euler's equations, with the Runge-Kutta rule in short
steps: I ω' = (I ω) × ω + Rᵀ τ - c ω, with ω in the frame of the body.

Source: Sims 1987, 3.1.2, 3.1.3 and 7.1; Iserles and Nørsett 1999 for the series.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.bodies.integrated_motion import (
    IntegratedMotion,
    PiecewisePolynomial,
)
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.spatial import Array, cross, matrix, quaternion, rotation

MAX_STEP = 1.0 / 240.0
"""Longest step of an attitude [s]."""

MAX_STEP_ANGLE = 0.02
"""Rotation in a Runge-Kutta step, about [rad]: errors are then near 1e-11."""

State = tuple[float, float, float, float, float, float, float]
"""Attitude wxyz of the principal axes, and angular velocity along them."""

TIME_ROUNDING = 1e-12
"""Rounding of times [s]."""

RUNGE_KUTTA_NODES = np.array([0.0, 0.5, 1.0])
GAUSS_NODES = np.array([0.5 - math.sqrt(3.0) / 6.0, 0.5 + math.sqrt(3.0) / 6.0])


class SpunAttitude:
    """Attitude under an angular velocity in the world; queried at ascending times.

    Attributes:
        R: (3, 3) attitude at the last query.
    """

    def __init__(self, spin: PiecewisePolynomial, R: Array) -> None:
        self.spin = spin
        self.R = R
        self._time = 0.0
        self._angles = IntegratedMotion.by_velocity(spin, np.zeros(3))

    def at(self, times: Array) -> Array:
        """Returns the attitudes (m, 3, 3) at `times` (m,), none before the last query [s]."""
        begins, ends = _short_steps(self._time, times, self.spin.begins)
        h = (ends - begins)[:, None]
        first, second = (self.spin.after(begins, GAUSS_NODES[k] * h[:, 0]) for k in range(2))
        about = self._angles.at(ends)[0] - self._angles.at(begins)[0]
        about += math.sqrt(3.0) / 12.0 * h * h * cross(second, first)
        angle = np.sqrt((about * about).sum(axis=-1))
        turns = rotation(about / np.where(angle > 0.0, angle, 1.0)[:, None], angle)
        count = np.searchsorted(ends, times, side="right")
        result, done = np.empty((len(times), 3, 3)), 0
        for i, until in enumerate(count):
            for turn in turns[done:until]:
                self.R = turn @ self.R
            done = max(done, int(until))
            result[i] = self.R
        self._time = max(self._time, float(times[-1]))
        return result


class TorquedAttitude:
    """Attitude under a torque in the world; queried at ascending times.

    Computed along the principal axes, in plain numbers: for one body a tenth of the time of
    arrays.
    """

    def __init__(
        self, torque: PiecewisePolynomial, mass: MassProperties, R: Array, spin: Array, drag: float
    ) -> None:
        moments, axes = np.linalg.eigh(mass.inertia)
        # Right-handed axes.
        self._axes = axes * np.array([1.0, 1.0, np.linalg.det(axes)])
        self.torque = torque
        self.moments: tuple[float, ...] = tuple(moments.tolist())
        self.drag = drag
        R_WP = R @ self._axes
        self._state: State = (*quaternion(R_WP).tolist(), *(R_WP.T @ spin).tolist())
        self._time = 0.0
        self._rests = not (spin.any() or torque.powers.any())

    @property
    def momentum(self) -> Array:
        """(3,) angular momentum in the world [kg m²/s]."""
        turning = np.array(self._state[4:]) * self.moments
        return matrix(np.array(self._state[:4])) @ turning

    @property
    def energy(self) -> float:
        """Kinetic energy of rotation [J]."""
        return 0.5 * sum(i * w * w for i, w in zip(self.moments, self._state[4:], strict=True))

    def at(self, times: Array) -> Array:
        """Returns the attitudes (m, 3, 3) at `times` (m,), none before the last query [s]."""
        if self._rests:
            q = np.tile(self._state[:4], (len(times), 1))
        else:
            q = np.array([self._go_to(float(time)) for time in times])
        return matrix(q) @ self._axes.T

    def _go_to(self, time: float) -> tuple[float, ...]:
        """Return the attitude of the principal axes at a time not before the last [s]."""
        begins, ends = _short_steps(self._time, np.array([time]), self.torque.begins)
        for begin, span in zip(begins, (ends - begins).tolist(), strict=True):
            spin = math.sqrt(sum(w * w for w in self._state[4:]))
            count = max(math.ceil(spin * span / MAX_STEP_ANGLE), 1)
            h = span / count
            for k in range(count):
                taus = self.torque.after(np.full(3, begin), h * (k + RUNGE_KUTTA_NODES)).tolist()
                self._state = _runge_kutta_step(self._state, h, taus, self.moments, self.drag)
        self._time = max(self._time, time)
        return self._state[:4]


def _runge_kutta_step(
    state: State, h: float, taus: list[list[float]], moments: tuple[float, ...], drag: float
) -> State:
    """Returns the state `h` [s] later, from torques at the start, the middle and the end."""
    k1 = _state_rates(state, taus[0], moments, drag)
    k2 = _state_rates(_moved_state(state, k1, 0.5 * h), taus[1], moments, drag)
    k3 = _state_rates(_moved_state(state, k2, 0.5 * h), taus[1], moments, drag)
    k4 = _state_rates(_moved_state(state, k3, h), taus[2], moments, drag)
    together = zip(k1, k2, k3, k4, strict=True)
    rates = tuple((a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in together)
    a, b, c, d, x, y, z = _moved_state(state, rates, h)
    n = math.sqrt(a * a + b * b + c * c + d * d)
    return a / n, b / n, c / n, d / n, x, y, z


def _moved_state(state: State, rates: tuple[float, ...], h: float) -> State:
    a, b, c, d, x, y, z = (s + h * r for s, r in zip(state, rates, strict=True))
    return a, b, c, d, x, y, z


def _state_rates(
    state: State, torque: list[float], moments: tuple[float, ...], drag: float
) -> tuple[float, ...]:
    """Returns the derivative of a state under a torque in the world."""
    a, b, c, d, x, y, z = state
    i, j, k = moments
    u, v, w = _to_body_frame(a, b, c, d, *torque)
    return (
        -0.5 * (b * x + c * y + d * z),
        0.5 * (a * x + c * z - d * y),
        0.5 * (a * y + d * x - b * z),
        0.5 * (a * z + b * y - c * x),
        ((j - k) * y * z + u - drag * x) / i,
        ((k - i) * z * x + v - drag * y) / j,
        ((i - j) * x * y + w - drag * z) / k,
    )


def _to_body_frame(
    a: float, b: float, c: float, d: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Returns a vector of the world in the frame of the attitude (a, b, c, d)."""
    # v + a t + u × t with u the vector of the inverse and t = 2 u × v.
    s = 2.0 * (y * d - z * c)
    t = 2.0 * (z * b - x * d)
    r = 2.0 * (x * c - y * b)
    return x + a * s + d * t - c * r, y + a * t + b * r - d * s, z + a * r + c * s - b * t


def _short_steps(start: float, times: Array, begins: Array) -> tuple[Array, Array]:
    """Returns starts and ends (n,) of short steps from `start` through `times`.

    None crosses the start of a piece, and one ends at each of the times.
    """
    between = begins[(begins > start) & (begins < float(times[-1]))]
    edges = np.unique(np.concatenate([[start], between, times[times > start]]))
    spans = np.diff(edges)
    counts = np.maximum(np.ceil(spans / MAX_STEP - TIME_ROUNDING), 1).astype(int)
    which = np.repeat(np.arange(len(spans)), counts)
    k = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    h = spans[which] / counts[which]
    ends = np.where(k + 1 == counts[which], edges[which + 1], edges[which] + (k + 1) * h)
    return edges[which] + k * h, ends
