"""Jerk: how smoothly a hand moves, by the integral of the square of its third derivative.

    C = ∫ |d³x/dt³|² dt            [m²/s⁵]

Positions are resampled to 60 Hz and low-passed at 10 Hz, forward and backward, before they are
differentiated: jerk is sensitive to the least error of position. The paper names m²/s⁶ as the
unit of an integral, which is that of the mean over time; both are told. C scales with T⁻⁵, so
that slow movements have little of it whatever their form: C T⁵/D² has no unit and is 720 for the
smoothest straight reach, of D in T between rest and rest, and more for every other.

Source: Matarić, Zordan and Mason 1998, section 7.3; Flash and Hogan 1985.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array

RATE, CUTOFF, ORDER = 60.0, 10.0, 4
"""Samples a second, cut-off of the filter [Hz], and its order in each direction."""

LEAST = 720.0
"""C T⁵/D² of the smoothest straight reach."""


@dataclass(frozen=True, slots=True)
class Jerk:
    """Smoothness of one movement.

    Attributes:
        integral: C [m²/s⁵].
        time: T [s].
        distance: D, straight from its begin to its end [m].
    """

    integral: float
    time: float
    distance: float

    @property
    def mean(self) -> float:
        """C over T [m²/s⁶]."""
        return self.integral / self.time

    @property
    def dimensionless(self) -> float:
        """C T⁵/D²; endless where the movement ends where it began."""
        if self.distance <= 0.0:
            return float("inf")
        return float(self.integral * self.time**5 / self.distance**2)


def resampled(times: Array, p: Array) -> tuple[Array, Array]:
    """Return times (n,) at 60 Hz and positions (n, 3) there, by cubics through four samples.

    Args:
        times: (K,) at equal distances [s].
        p: (K, 3) [m].
    """
    h = float(times[1] - times[0])
    count = int((times[-1] - times[0]) * RATE + 1e-9) + 1
    wanted = times[0] + np.arange(count) / RATE
    place = (wanted - times[0]) / h
    i = np.clip(np.floor(place).astype(int), 1, len(p) - 3)
    u = (place - i)[:, None]
    a, b, c, d = (p[i + k] for k in (-1, 0, 1, 2))
    result: Array = (
        -u * (u - 1.0) * (u - 2.0) / 6.0 * a
        + (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0 * b
        - (u + 1.0) * u * (u - 2.0) / 2.0 * c
        + (u + 1.0) * u * (u - 1.0) / 6.0 * d
    )
    return wanted, result


def low_passed(p: Array, rate: float = RATE) -> Array:
    """Return positions (n, 3) through a Butterworth filter, forward and backward: without a lag.

    Both passes together have the gain 1 / (1 + (tan(π f / r) / tan(π f_c / r))^(2 n)), the
    bilinear transform of the filter. The ends are continued by odd reflection.
    """
    pad = min(len(p) - 1, int(rate))
    before = 2.0 * p[0] - p[pad:0:-1]
    after = 2.0 * p[-1] - p[-2 : -pad - 2 : -1]
    whole = np.concatenate([before, p, after])
    # A straight line is taken out: its two ends do not meet.
    n = len(whole)
    line = whole[0] + (whole[-1] - whole[0]) * (np.arange(n) / (n - 1))[:, None]
    f = np.fft.rfftfreq(n, 1.0 / rate)
    warped = np.tan(np.pi * np.minimum(f, 0.4999 * rate) / rate) / np.tan(np.pi * CUTOFF / rate)
    gain = 1.0 / (1.0 + warped ** (2 * ORDER))
    smooth = np.fft.irfft(np.fft.rfft(whole - line, axis=0) * gain[:, None], n, axis=0)
    return (smooth + line)[pad : pad + len(p)]


def third_derivative(p: Array, rate: float = RATE) -> Array:
    """Returns the third derivatives (n, 3) by central differences; the two at each end repeat."""
    inner = (p[4:] - 2.0 * p[3:-1] + 2.0 * p[1:-3] - p[:-4]) * (0.5 * rate**3)
    return np.concatenate([inner[:1], inner[:1], inner, inner[-1:], inner[-1:]])


def measure_jerk(times: Array, p: Array, begin: float, end: float) -> Jerk:
    """Returns the smoothness of a movement from `begin` to `end` within a longer record.

    Args:
        times: (K,) at equal distances [s].
        p: (K, 3) of the hand [m].
        begin: [s].
        end: [s].
    """
    t, x = resampled(times, p)
    x = low_passed(x)
    rows = np.flatnonzero((t >= begin - 1e-9) & (t <= end + 1e-9))
    integral = total_square_jerk(x, rows)
    ways = [np.array([np.interp(when, t, axis) for axis in x.T]) for when in (begin, end)]
    return Jerk(integral, end - begin, float(np.linalg.norm(ways[1] - ways[0])))


def total_square_jerk(x: Array, rows: NDArray[np.int64]) -> float:
    """Return C [m²/s⁵] of the samples `rows` of places x (n, 3) at 60 Hz."""
    return _integral((third_derivative(x)[rows] ** 2).sum(axis=1), 1.0 / RATE)


def minimum_jerk_between(times: Array, p: Array, begin: float, end: float) -> float:
    """Return C of the smoothest movement with the same ends: their places, speeds, accelerations.

    That is a polynomial of degree five; no movement between these ends has less [m²/s⁵].
    """
    t, x = resampled(times, p)
    x = low_passed(x)
    v = np.gradient(x, 1.0 / RATE, axis=0)
    a = np.gradient(v, 1.0 / RATE, axis=0)
    time, total = end - begin, 0.0
    for axis in range(3):
        ends = [[float(np.interp(when, t, q[:, axis])) for q in (x, v, a)] for when in (begin, end)]
        total += _quintic_jerk(ends[0], ends[1], time)
    return total


def rank_correlation(one: Array, other: Array) -> float:
    """Returns how far two columns agree in their order, from -1 to 1.

    Source: Spearman 1904; ties share the mean of their ranks.
    """
    a, b = _ranks(one), _ranks(other)
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum() / scale) if scale > 0.0 else 0.0


def _ranks(values: Array) -> Array:
    below = (values[None, :] < values[:, None]).sum(axis=1)
    same = (values[None, :] == values[:, None]).sum(axis=1)
    return below + 0.5 * (same - 1)


def _integral(values: Array, h: float) -> float:
    if len(values) < 2:
        return 0.0
    return float(h * (values.sum() - 0.5 * (values[0] + values[-1])))


def _quintic_jerk(first: list[float], last: list[float], time: float) -> float:
    """Return ∫ x'''² dt of the quintic from (x, v, a) to (x, v, a) in `time`."""
    x0, v0, a0 = first[0], first[1] * time, first[2] * time**2
    x1, v1, a1 = last[0], last[1] * time, last[2] * time**2
    d = x1 - x0
    c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
    c5 = 6.0 * d - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1
    # x''' = 6 c3 + 24 c4 s + 60 c5 s², squared and integrated over s from 0 to 1.
    p, q, r = 6.0 * c3, 24.0 * c4, 60.0 * c5
    square = p * p + p * q + (q * q + 2.0 * p * r) / 3.0 + q * r / 2.0 + r * r / 5.0
    return square / time**5
