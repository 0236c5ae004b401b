"""Postures: desired angles by a spline through key postures and intermediate ones.

The spline runs through the postures at knots spaced by how far they are apart; where on it the
arm is to be follows the smooth step of least jerk, so that it begins and ends at rest.

Source: Matarić et al. 1998, section 6.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.dancers.fields import smooth
from pipeline.simulation.spatial import Array


class Passage:
    """The way of some joints through postures.

    Args:
        postures: (m, n) the first of them where they are now [rad].
        begin: when they leave it [s].
        land: when they are at the last [s].
    """

    def __init__(self, postures: Sequence[Array], begin: float, land: float) -> None:
        self.keys = np.array(postures)
        self.begin, self.time = begin, max(land - begin, 1e-3)
        apart = np.sqrt(np.maximum(np.abs(np.diff(self.keys, axis=0)).max(axis=1), 1e-3))
        knots = np.concatenate([[0.0], np.cumsum(apart)])
        self.knots = knots / knots[-1]
        self.bends = natural_bends(self.knots, self.keys)

    def at(self, now: float) -> tuple[Array, Array]:
        """Return angles (n,) and their speeds (n,) [rad], [rad/s]."""
        u, slope = smooth((now - self.begin) / self.time)
        i = min(int(np.searchsorted(self.knots, u, side="right")) - 1, len(self.knots) - 2)
        h = self.knots[i + 1] - self.knots[i]
        a, b = (self.knots[i + 1] - u) / h, (u - self.knots[i]) / h
        y, m = self.keys, self.bends
        q = a * y[i] + b * y[i + 1]
        q += ((a * a * a - a) * m[i] + (b * b * b - b) * m[i + 1]) * (h * h / 6.0)
        rate = (y[i + 1] - y[i]) / h
        rate = rate + ((3.0 * b * b - 1.0) * m[i + 1] - (3.0 * a * a - 1.0) * m[i]) * (h / 6.0)
        return q, rate * (slope / self.time)


def natural_bends(knots: Array, keys: Array) -> Array:
    """Return the second derivatives (m, n) at the knots of the natural cubic spline.

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
