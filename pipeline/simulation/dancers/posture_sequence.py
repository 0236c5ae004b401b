"""Desired angles on a spline through key postures.

The knots are spaced by the square roots of the distances between the postures. The phase on the
spline follows a minimum-jerk step, so the motion starts and ends at rest.

Source: Matarić, Zordan and Mason 1998, section 6.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.dancers.force_fields import (
    SURFACE_FRACTION_LIMIT,
    minimum_jerk_phase,
    minimum_jerk_step,
)
from pipeline.simulation.spatial import Array


class PostureSpline:
    """Passage of joints through postures.

    Args:
        postures: (m, n) postures, starting with the present one [rad].
        start: start [s].
        land: arrival at the last posture, or at `meets` where given [s].
        meets: (n,) posture shortly before the last in which the hand touches [rad].
    """

    def __init__(
        self,
        postures: Sequence[Array],
        start: float,
        land: float,
        meets: Array | None = None,
    ) -> None:
        self.keys = np.array(postures)
        self.start, self.duration = start, max(land - start, 1e-3)
        spacing = np.sqrt(np.maximum(np.abs(np.diff(self.keys, axis=0)).max(axis=1), 1e-3))
        knots = np.concatenate([[0.0], np.cumsum(spacing)])
        knots /= knots[-1]
        self.knots: list[float] = knots.tolist()
        self._coefficients = _cubic_coefficients(knots, self.keys)
        if meets is not None:
            # Fraction of the last segment beyond the contact, by shoulder and elbow angles.
            remaining, total = (
                np.abs(self.keys[-1] - posture)[:4].max() for posture in (meets, self.keys[-2])
            )
            remaining = float(remaining / max(total, 1e-3))
            below = min(remaining, SURFACE_FRACTION_LIMIT) * (1.0 - self.knots[-2])
            self.duration /= minimum_jerk_phase(1.0 - below)
        self._zero_speed = np.zeros(self.keys.shape[1])

    def is_over(self, now: float) -> bool:
        """Returns whether the last posture has been reached."""
        return now >= self.start + self.duration

    def at(self, now: float) -> tuple[Array, Array]:
        """Returns the angles (n,) [rad] and their rates (n,) [rad/s]."""
        if self.is_over(now):
            return self.keys[-1], self._zero_speed
        u, slope = minimum_jerk_step((now - self.start) / self.duration)
        i = min(bisect_right(self.knots, u), len(self._coefficients)) - 1
        a, b, c, d = self._coefficients[i]
        x = u - self.knots[i]
        cx, dx = c * x, d * (x * x)
        q = a + (b + cx + dx) * x
        speed = (b + 2.0 * cx + 3.0 * dx) * (slope / self.duration)
        return q, speed


def _cubic_coefficients(knots: Array, keys: Array) -> list[tuple[Array, Array, Array, Array]]:
    """Returns the coefficients of each segment in powers of the distance to its first knot."""
    m, h = natural_spline_curvatures(knots, keys), np.diff(knots)[:, None]
    slope = np.diff(keys, axis=0) / h - h * (2.0 * m[:-1] + m[1:]) / 6.0
    cube = np.diff(m, axis=0) / (6.0 * h)
    return list(zip(keys[:-1], slope, 0.5 * m[:-1], cube, strict=True))


def natural_spline_curvatures(knots: Array, keys: Array) -> Array:
    """Returns the second derivatives (m, n) of the natural cubic spline at its knots.

    Args:
        knots: (m,) knots, increasing.
        keys: (m, n) values at the knots.
    """
    h, m = np.diff(knots), len(knots)
    curvatures = np.zeros_like(keys)
    if m < 3:
        return curvatures
    system = np.zeros((m - 2, m - 2))
    slopes = np.diff(keys, axis=0) / h[:, None]
    for i in range(m - 2):
        system[i, i] = 2.0 * (h[i] + h[i + 1])
        if i + 1 < m - 2:
            system[i, i + 1] = system[i + 1, i] = h[i + 1]
    curvatures[1:-1] = np.linalg.solve(system, 6.0 * np.diff(slopes, axis=0))
    return curvatures
