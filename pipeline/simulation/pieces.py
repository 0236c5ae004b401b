"""Pieces: a track as polynomials in time, and what it comes to when it is integrated.

Every ease is a polynomial between two keys. A velocity that goes along one is therefore
integrated exactly, and so is a force with or without drag: with x'' = f(τ) - k x',

    x'(τ) = x'(0) φ₀(-kτ) + Σ fⱼ j! τ^(j+1) φ_(j+1)(-kτ),
    x(τ) = x(0) + x'(0) τ φ₁(-kτ) + Σ fⱼ j! τ^(j+2) φ_(j+2)(-kτ),

where fⱼ are the coefficients of f and φₙ(z) = Σ z^m / (m + n)! are the functions of
exponential integrators; k = 0 is no special case.

Source: Sims 1987, 3.1.2 and 3.1.3; Hochbruck and Ostermann 2010 for φ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.tracks import AT_ONCE, Track

DEGREE = 5
"""Highest power of time in any ease."""

SMALL = 2.0
"""Up to here φ is summed as a series: beyond it the recurrence is as exact."""

TERMS = 28
"""Of that series; the last is below 1e-16 of the first."""

EASED = {
    "linear": (0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
    "in": (0.0, 0.0, 1.5, -0.5, 0.0, 0.0),
    "out": (0.0, 1.5, 0.0, -0.5, 0.0, 0.0),
    "in-out": (0.0, 0.0, 0.0, 10.0, -15.0, 6.0),
    "hold": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
}
"""How far a value has come, as coefficients of s from 0 to 1; see `Track`."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """A track as polynomials, from time 0 on.

    Attributes:
        begins: (n,) time at which each piece begins, the first at 0 [s].
        powers: (n, DEGREE + 1, d) coefficients of the time since.
    """

    begins: Array
    powers: Array

    @staticmethod
    def of(track: Track) -> Pieces:
        """Return the pieces of a track; before its first key and after its last it is constant."""
        begins, powers = [0.0], [_constant(track.values[0])]
        for i in range(1, len(track.times)):
            begins.append(float(track.times[i - 1]))
            powers.append(_between(track, i))
        begins.append(float(track.times[-1]))
        powers.append(_constant(track.values[-1]))
        return Pieces(np.array(begins), np.array(powers))

    def at(self, times: Array) -> Array:
        """Return the values (m, d) at `times` (m,) [s]."""
        piece, tau = self.places(times)
        return _sum(self.powers[piece], tau)

    def after(self, times: Array, more: Array) -> Array:
        """Return the values (m, d) `more` (m,) [s] after `times` (m,), in the pieces of those."""
        piece, tau = self.places(times)
        return _sum(self.powers[piece], tau + more)

    def places(self, times: Array) -> tuple[NDArray[np.int64], Array]:
        """Return the pieces (m,) that `times` (m,) lie in, and the time since their begins."""
        piece = np.searchsorted(self.begins, times, side="right") - 1
        piece = np.maximum(piece, 0)
        return piece, times - self.begins[piece]


@dataclass(frozen=True, eq=False)
class Carried:
    """What is carried along from rest by an acceleration in pieces, or by a velocity.

    Attributes:
        pieces: of the acceleration; of the velocity if `order` is 1.
        drag: k, as a part of the mass [1/s].
        order: how often it is integrated.
        p: (n, d) places at the begins of the pieces.
        v: (n, d) velocities there.
    """

    pieces: Pieces
    drag: float
    order: int
    p: Array
    v: Array

    @staticmethod
    def by_velocity(pieces: Pieces, start: Array) -> Carried:
        """Return what goes from `start` (d,) with a velocity in pieces."""
        return _carried(pieces, 0.0, 1, start, np.zeros_like(start))

    @staticmethod
    def by_acceleration(pieces: Pieces, start: Array, velocity: Array, drag: float) -> Carried:
        """Return what begins at `start` (d,) with `velocity` (d,), drag k [1/s] holding it back."""
        return _carried(pieces, drag, 2, start, velocity)

    def at(self, times: Array) -> tuple[Array, Array]:
        """Return places and velocities (m, d) at `times` (m,)."""
        piece, tau = self.pieces.places(times)
        powers = self.pieces.powers[piece]
        return _moved(powers, self.p[piece], self.v[piece], tau, self.drag, self.order)


def _carried(pieces: Pieces, drag: float, order: int, p: Array, v: Array) -> Carried:
    ps, vs = [p], [v]
    for i, span in enumerate(np.diff(pieces.begins)):
        tau = np.array([span])
        p, v = _moved(pieces.powers[[i]], ps[i][None], vs[i][None], tau, drag, order)
        ps.append(p[0])
        vs.append(v[0])
    return Carried(pieces, drag, order, np.array(ps), np.array(vs))


def _moved(
    powers: Array, p: Array, v: Array, tau: Array, drag: float, order: int
) -> tuple[Array, Array]:
    """Return places and velocities (m, d) at `tau` (m,) after the begins of pieces.

    Args:
        powers: (m, DEGREE + 1, d) of the acceleration, or the velocity.
        p: (m, d) at the begins.
        v: (m, d) at the begins.
        tau: [s].
        drag: k [1/s].
        order: 2 for an acceleration, 1 for a velocity.
    """
    phi = phis(-drag * tau)
    place, speed = p.copy(), np.zeros_like(v)
    if order == 2:
        place += v * (tau * phi[1])[:, None]
        speed += v * phi[0][:, None]
    for j in range(DEGREE + 1):
        part = math.factorial(j) * powers[:, j]
        place += part * (tau ** (j + order) * phi[j + order])[:, None]
        speed += part * (tau ** (j + order - 1) * phi[j + order - 1])[:, None]
    return place, speed


def phis(z: Array) -> Array:
    """Return φ₀(z) to φ_(DEGREE + 2)(z), (DEGREE + 3, m), for z (m,) not above 0."""
    count = DEGREE + 3
    result = np.empty((count, len(z)))
    if not z.any():
        result[:] = 1.0 / np.array([[math.factorial(n)] for n in range(count)])
        return result
    small = z >= -SMALL
    near = np.where(small, z, 0.0)
    for n in range(count):
        # Horner's rule from the last term on.
        total = np.zeros_like(z)
        for m in range(TERMS, -1, -1):
            total = total * near + 1.0 / math.factorial(m + n)
        result[n] = total
    far = np.where(small, -SMALL, z)
    value = np.exp(far)
    for n in range(count):
        result[n] = np.where(small, result[n], value)
        value = (value - 1.0 / math.factorial(n)) / far
    return result


def _sum(powers: Array, tau: Array) -> Array:
    value = np.zeros((len(tau), powers.shape[2]))
    for j in range(DEGREE, -1, -1):
        value = value * tau[:, None] + powers[:, j]
    return value


def _constant(value: Array) -> Array:
    powers = np.zeros((DEGREE + 1, len(value)))
    powers[0] = value
    return powers


def _between(track: Track, right: int) -> Array:
    """Return the coefficients of time from the key before `right` on."""
    a, b, kind = track.values[right - 1], track.values[right], track.eases[right]
    span = float(track.times[right] - track.times[right - 1])
    if span <= AT_ONCE:
        return _constant(b)
    powers = _constant(a)
    if kind == "spline":
        first, last = span * track.speeds[right - 1], span * track.speeds[right]
        powers[1] = first
        powers[2] = 3.0 * (b - a) - 2.0 * first - last
        powers[3] = -2.0 * (b - a) + first + last
    else:
        powers += np.array(EASED[kind])[:, None] * (b - a)
    result: Array = powers / span ** np.arange(DEGREE + 1.0)[:, None]
    return result
