"""Integrated motion: tracks as piecewise polynomials in time, and their exact integrals.

Every ease is a polynomial between two keys. A velocity along one is therefore integrated exactly,
and so is a force with or without drag: with x'' = f(τ) - k x',

    x'(τ) = x'(0) φ₀(-kτ) + Σ fⱼ j! τ^(j+1) φ_(j+1)(-kτ),
    x(τ) = x(0) + x'(0) τ φ₁(-kτ) + Σ fⱼ j! τ^(j+2) φ_(j+2)(-kτ),

where fⱼ are the coefficients of f and φₙ(z) = Σ z^m / (m + n)! are the functions of exponential
integrators; k = 0 is no special case.

Source: Sims 1987, 3.1.2 and 3.1.3; Hochbruck and Ostermann 2010 for φ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.keyframe_track import SAME_TIME, Track
from pipeline.simulation.spatial import Array

MAX_DEGREE = 5
"""Highest power of time in any ease."""

SERIES_LIMIT = 2.0
"""Argument up to which φ is summed as a series: beyond it the recurrence is as exact."""

SERIES_TERMS = 28
"""Terms of that series; the last is below 1e-16 of the first."""

EASE_COEFFICIENTS = {
    "linear": (0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
    "in": (0.0, 0.0, 1.5, -0.5, 0.0, 0.0),
    "out": (0.0, 1.5, 0.0, -0.5, 0.0, 0.0),
    "in-out": (0.0, 0.0, 0.0, 10.0, -15.0, 6.0),
    "hold": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
}
"""Eased value as coefficients of s from 0 to 1; see `Track`."""


@dataclass(frozen=True, eq=False)
class PiecewisePolynomial:
    """A track as polynomials, from time 0 on.

    Attributes:
        begins: (n,) start of each piece, the first at 0 [s].
        powers: (n, MAX_DEGREE + 1, d) coefficients of the time since.
    """

    begins: Array
    powers: Array

    @staticmethod
    def of(track: Track) -> PiecewisePolynomial:
        """Returns the pieces of a track; it is constant before its first key and after its last."""
        begins, powers = [0.0], [_constant_piece(track.values[0])]
        for i in range(1, len(track.times)):
            begins.append(float(track.times[i - 1]))
            powers.append(_piece_between(track, i))
        begins.append(float(track.times[-1]))
        powers.append(_constant_piece(track.values[-1]))
        return PiecewisePolynomial(np.array(begins), np.array(powers))

    def at(self, times: Array) -> Array:
        """Returns the values (m, d) at `times` (m,) [s]."""
        piece, tau = self.pieces_at(times)
        return _evaluate(self.powers[piece], tau)

    def after(self, times: Array, more: Array) -> Array:
        """Returns the values (m, d) `more` (m,) [s] after `times` (m,), in their pieces."""
        piece, tau = self.pieces_at(times)
        return _evaluate(self.powers[piece], tau + more)

    def pieces_at(self, times: Array) -> tuple[NDArray[np.int64], Array]:
        """Returns the pieces (m,) of `times` (m,), and the time since their starts."""
        piece = np.searchsorted(self.begins, times, side="right") - 1
        piece = np.maximum(piece, 0)
        return piece, times - self.begins[piece]


@dataclass(frozen=True, eq=False)
class IntegratedMotion:
    """Motion from rest by a piecewise acceleration or velocity.

    Attributes:
        pieces: of the acceleration; of the velocity if `order` is 1.
        drag: k, relative to the mass [1/s].
        order: number of integrations.
        p: (n, d) positions at the starts of the pieces.
        v: (n, d) velocities there.
    """

    pieces: PiecewisePolynomial
    drag: float
    order: int
    p: Array
    v: Array

    @staticmethod
    def by_velocity(pieces: PiecewisePolynomial, start: Array) -> IntegratedMotion:
        """Returns the motion from `start` (d,) with a piecewise velocity."""
        return _integrate_pieces(pieces, 0.0, 1, start, np.zeros_like(start))

    @staticmethod
    def by_acceleration(
        pieces: PiecewisePolynomial, start: Array, velocity: Array, drag: float
    ) -> IntegratedMotion:
        """Returns the motion from `start` (d,) with `velocity` (d,) and drag k [1/s]."""
        return _integrate_pieces(pieces, drag, 2, start, velocity)

    def at(self, times: Array) -> tuple[Array, Array]:
        """Returns positions and velocities (m, d) at `times` (m,)."""
        piece, tau = self.pieces.pieces_at(times)
        powers = self.pieces.powers[piece]
        return _motion_within_piece(
            powers, self.p[piece], self.v[piece], tau, self.drag, self.order
        )


def _integrate_pieces(
    pieces: PiecewisePolynomial, drag: float, order: int, p: Array, v: Array
) -> IntegratedMotion:
    ps, vs = [p], [v]
    for i, span in enumerate(np.diff(pieces.begins)):
        tau = np.array([span])
        p, v = _motion_within_piece(pieces.powers[[i]], ps[i][None], vs[i][None], tau, drag, order)
        ps.append(p[0])
        vs.append(v[0])
    return IntegratedMotion(pieces, drag, order, np.array(ps), np.array(vs))


def _motion_within_piece(
    powers: Array, p: Array, v: Array, tau: Array, drag: float, order: int
) -> tuple[Array, Array]:
    """Returns positions and velocities (m, d) at `tau` (m,) after the starts of pieces.

    Args:
        powers: (m, MAX_DEGREE + 1, d) of the acceleration, or the velocity.
        p: (m, d) at the starts.
        v: (m, d) at the starts.
        tau: [s].
        drag: k [1/s].
        order: 2 for an acceleration, 1 for a velocity.
    """
    phi = phi_functions(-drag * tau)
    place, speed = p.copy(), np.zeros_like(v)
    if order == 2:
        place += v * (tau * phi[1])[:, None]
        speed += v * phi[0][:, None]
    for j in range(MAX_DEGREE + 1):
        part = math.factorial(j) * powers[:, j]
        place += part * (tau ** (j + order) * phi[j + order])[:, None]
        speed += part * (tau ** (j + order - 1) * phi[j + order - 1])[:, None]
    return place, speed


def phi_functions(z: Array) -> Array:
    """Returns φ₀(z) to φ_(MAX_DEGREE + 2)(z), (MAX_DEGREE + 3, m), for z (m,) not above 0."""
    count = MAX_DEGREE + 3
    result = np.empty((count, len(z)))
    if not z.any():
        result[:] = 1.0 / np.array([[math.factorial(n)] for n in range(count)])
        return result
    small = z >= -SERIES_LIMIT
    near = np.where(small, z, 0.0)
    for n in range(count):
        # Horner's rule from the last term on.
        total = np.zeros_like(z)
        for m in range(SERIES_TERMS, -1, -1):
            total = total * near + 1.0 / math.factorial(m + n)
        result[n] = total
    far = np.where(small, -SERIES_LIMIT, z)
    value = np.exp(far)
    for n in range(count):
        result[n] = np.where(small, result[n], value)
        value = (value - 1.0 / math.factorial(n)) / far
    return result


def _evaluate(powers: Array, tau: Array) -> Array:
    value = np.zeros((len(tau), powers.shape[2]))
    for j in range(MAX_DEGREE, -1, -1):
        value = value * tau[:, None] + powers[:, j]
    return value


def _constant_piece(value: Array) -> Array:
    powers = np.zeros((MAX_DEGREE + 1, len(value)))
    powers[0] = value
    return powers


def _piece_between(track: Track, right: int) -> Array:
    """Returns the coefficients of time from the key before `right` on."""
    a, b, kind = track.values[right - 1], track.values[right], track.eases[right]
    span = float(track.times[right] - track.times[right - 1])
    if span <= SAME_TIME:
        return _constant_piece(b)
    powers = _constant_piece(a)
    if kind == "spline":
        first, last = span * track.speeds[right - 1], span * track.speeds[right]
        powers[1] = first
        powers[2] = 3.0 * (b - a) - 2.0 * first - last
        powers[3] = -2.0 * (b - a) + first + last
    else:
        powers += np.array(EASE_COEFFICIENTS[kind])[:, None] * (b - a)
    return powers / span ** np.arange(MAX_DEGREE + 1.0)[:, None]
