"""Smoothness of a hand's motion by its squared jerk, integrated over time.

    C = ∫ |d³x/dt³|² dt            [m²/s⁵]

Positions are resampled to 60 Hz and low-passed at 10 Hz, forward and backward, before
differentiation, since jerk amplifies position noise. The paper gives m²/s⁶ as the unit of the
integral, which is the unit of its mean over time; both are reported. C scales with T⁻⁵, so slow
movements have a small C whatever their form. The dimensionless C T⁵/D² is 720 for the
minimum-jerk straight reach over distance D in time T from rest to rest, and larger otherwise.

Source: Matarić, Zordan and Mason 1998, section 7.3; Flash and Hogan 1985.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array

SAMPLE_RATE = 60.0
"""Sample rate of the measurement [Hz]."""

CUTOFF_FREQUENCY = 10.0
"""Cut-off frequency of the Butterworth filter [Hz]."""

FILTER_ORDER = 4
"""Order of the Butterworth filter in each direction."""

MINIMUM_DIMENSIONLESS_JERK = 720.0
"""C T⁵/D² of the minimum-jerk straight reach."""


@dataclass(frozen=True, slots=True)
class Jerk:
    """Smoothness of one movement.

    Attributes:
        integral: C [m²/s⁵].
        time: T [s].
        distance: D, straight from start to end [m].
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
        """C T⁵/D²; infinite for a movement that ends at its start."""
        if self.distance <= 0.0:
            return float("inf")
        return float(self.integral * self.time**5 / self.distance**2)


def resampled(times: Array, p: Array) -> tuple[Array, Array]:
    """Returns times (n,) at 60 Hz and positions (n, 3) there, by four-point cubic interpolation.

    Args:
        times: (K,) equally spaced times [s].
        p: (K, 3) positions [m].
    """
    h = float(times[1] - times[0])
    count = int((times[-1] - times[0]) * SAMPLE_RATE + 1e-9) + 1
    wanted = times[0] + np.arange(count) / SAMPLE_RATE
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


def low_passed(p: Array, rate: float = SAMPLE_RATE) -> Array:
    """Returns positions (n, 3) after a zero-phase Butterworth filter.

    The gain of both passes is 1 / (1 + (tan(π f / r) / tan(π f_c / r))^(2 n)), the
    bilinear transform of the filter. Odd reflection extends both ends.
    """
    pad = min(len(p) - 1, int(rate))
    before = 2.0 * p[0] - p[pad:0:-1]
    after = 2.0 * p[-1] - p[-2 : -pad - 2 : -1]
    whole = np.concatenate([before, p, after])
    # Removing a line makes the signal periodic.
    n = len(whole)
    line = whole[0] + (whole[-1] - whole[0]) * (np.arange(n) / (n - 1))[:, None]
    f = np.fft.rfftfreq(n, 1.0 / rate)
    warped = np.tan(np.pi * np.minimum(f, 0.4999 * rate) / rate) / np.tan(
        np.pi * CUTOFF_FREQUENCY / rate
    )
    gain = 1.0 / (1.0 + warped ** (2 * FILTER_ORDER))
    smooth = np.fft.irfft(np.fft.rfft(whole - line, axis=0) * gain[:, None], n, axis=0)
    return (smooth + line)[pad : pad + len(p)]


def filtered_movement(
    times: Array, p: Array, start: float, end: float
) -> tuple[Array, Array, NDArray[np.int64]]:
    """Returns a record at 60 Hz after the low-pass, and the rows of the movement within it.

    Args:
        times: (K,) equally spaced times [s].
        p: (K, 3) positions of the hand [m].
        start: start of the movement [s].
        end: end of the movement [s].

    Returns:
        Times (n,) [s], positions (n, 3) [m], and numbers of the rows from `start` to `end`.
    """
    t, x = resampled(times, p)
    x = low_passed(x)
    return t, x, np.flatnonzero((t >= start - 1e-9) & (t <= end + 1e-9))


def third_derivative(p: Array, rate: float = SAMPLE_RATE) -> Array:
    """Returns the third derivatives (n, 3) by central differences; the two at each end repeat."""
    inner = (p[4:] - 2.0 * p[3:-1] + 2.0 * p[1:-3] - p[:-4]) * (0.5 * rate**3)
    return np.concatenate([inner[:1], inner[:1], inner, inner[-1:], inner[-1:]])


def measure_jerk(times: Array, p: Array, start: float, end: float) -> Jerk:
    """Returns the smoothness of a movement from `start` to `end` within a longer record.

    Args:
        times: (K,) equally spaced times [s].
        p: (K, 3) positions of the hand [m].
        start: start of the movement [s].
        end: end of the movement [s].
    """
    t, x, rows = filtered_movement(times, p, start, end)
    integral = total_square_jerk(x, rows)
    ends = [np.array([np.interp(when, t, axis) for axis in x.T]) for when in (start, end)]
    return Jerk(integral, end - start, float(np.linalg.norm(ends[1] - ends[0])))


def total_square_jerk(x: Array, rows: NDArray[np.int64]) -> float:
    """Returns C of the samples `rows` of positions x (n, 3) at 60 Hz [m²/s⁵]."""
    return _integral((third_derivative(x)[rows] ** 2).sum(axis=1), 1.0 / SAMPLE_RATE)


def minimum_jerk_between(times: Array, p: Array, start: float, end: float) -> float:
    """Returns the smallest C of any movement between the same end states [m²/s⁵].

    The quintic between the positions, velocities and accelerations of both ends attains it.
    """
    t, x, _ = filtered_movement(times, p, start, end)
    v = np.gradient(x, 1.0 / SAMPLE_RATE, axis=0)
    a = np.gradient(v, 1.0 / SAMPLE_RATE, axis=0)
    time, total = end - start, 0.0
    for axis in range(3):
        ends = [[float(np.interp(when, t, q[:, axis])) for q in (x, v, a)] for when in (start, end)]
        total += _quintic_jerk(ends[0], ends[1], time)
    return total


def rank_correlation(x: Array, y: Array) -> float:
    """Returns Spearman's rank correlation of two columns, with mean ranks for ties.

    Source: Spearman 1904.
    """
    a, b = _ranks(x), _ranks(y)
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
    """Returns ∫ x'''² dt of the quintic from (x, v, a) to (x, v, a) in `time`."""
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
