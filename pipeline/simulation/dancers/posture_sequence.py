"""Postures: desired angles by a spline through key postures and intermediate ones.

The spline runs through the postures at knots spaced by how far they are apart; where on it the
arm is to be follows the smooth step of least jerk, so that it begins and ends at rest.

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
    """The way of some joints through postures.

    Args:
        postures: (m, n) the first of them where they are now [rad].
        begin: when they leave it [s].
        land: when they are at the last [s]; or at `meets`, if that is given.
        meets: (n,) a posture shortly before the last, in which a hand touches.
    """

    def __init__(
        self,
        postures: Sequence[Array],
        begin: float,
        land: float,
        meets: Array | None = None,
    ) -> None:
        self.keys = np.array(postures)
        self.begin, self.time = begin, max(land - begin, 1e-3)
        apart = np.sqrt(np.maximum(np.abs(np.diff(self.keys, axis=0)).max(axis=1), 1e-3))
        knots = np.concatenate([[0.0], np.cumsum(apart)])
        knots /= knots[-1]
        self.knots: list[float] = knots.tolist()
        self._powers = _cubics(knots, self.keys)
        if meets is not None:
            # In the last piece, by how far the shoulder and the elbow have come of it.
            left, whole = (np.abs(self.keys[-1] - one)[:4].max() for one in (meets, self.keys[-2]))
            left = float(left / max(whole, 1e-3))
            under = min(left, SURFACE_FRACTION_LIMIT) * (1.0 - self.knots[-2])
            self.time /= minimum_jerk_phase(1.0 - under)
        self._still = np.zeros(self.keys.shape[1])

    def is_over(self, now: float) -> bool:
        """Returns whether the last posture is reached."""
        return now >= self.begin + self.time

    def at(self, now: float) -> tuple[Array, Array]:
        """Returns angles (n,) and their speeds (n,) [rad], [rad/s]."""
        if self.is_over(now):
            return self.keys[-1], self._still
        u, slope = minimum_jerk_step((now - self.begin) / self.time)
        i = min(bisect_right(self.knots, u), len(self._powers)) - 1
        a, b, c, d = self._powers[i]
        x = u - self.knots[i]
        cx, dx = c * x, d * (x * x)
        q = a + (b + cx + dx) * x
        speed = (b + 2.0 * cx + 3.0 * dx) * (slope / self.time)
        return q, speed


def _cubics(knots: Array, keys: Array) -> list[tuple[Array, Array, Array, Array]]:
    """Returns the natural cubic spline, piece by piece, as powers of the way from its knot."""
    m, h = natural_spline_curvatures(knots, keys), np.diff(knots)[:, None]
    slope = np.diff(keys, axis=0) / h - h * (2.0 * m[:-1] + m[1:]) / 6.0
    cube = np.diff(m, axis=0) / (6.0 * h)
    return list(zip(keys[:-1], slope, 0.5 * m[:-1], cube, strict=True))


def natural_spline_curvatures(knots: Array, keys: Array) -> Array:
    """Returns the second derivatives (m, n) at the knots of the natural cubic spline.

    Args:
        knots: (m,) increasing.
        keys: (m, n) values there.
    """
    h, m = np.diff(knots), len(knots)
    bends = np.zeros_like(keys)
    if m < 3:
        return bends
    system = np.zeros((m - 2, m - 2))
    slopes = np.diff(keys, axis=0) / h[:, None]
    for i in range(m - 2):
        system[i, i] = 2.0 * (h[i] + h[i + 1])
        if i + 1 < m - 2:
            system[i, i + 1] = system[i + 1, i] = h[i + 1]
    bends[1:-1] = np.linalg.solve(system, 6.0 * np.diff(slopes, axis=0))
    return bends
