"""Hurdle: what is in the way of a jump, seen from the side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.locomotion.routes.route import heading_vector
from pipeline.simulation.spatial import Array

STATIONS = 49
"""Places along the way at which its height is known."""

EXACT = 10
"""Decimals of ways along it."""

NOWHERE = -1e6
"""Height of what is not there [m]."""


@dataclass(frozen=True, eq=False)
class Hurdle:
    """The outline of solids in the strip over which a body comes.

    Attributes:
        along: (k,) ways from where it is looked at, ascending [m].
        top: (k,) the greatest heights there, in the world [m].
    """

    along: Array
    top: Array

    @property
    def near(self) -> float:
        """Way to where it begins [m]."""
        return float(self.along[0])

    @property
    def far(self) -> float:
        """Way to where it ends [m]."""
        return float(self.along[-1])

    @property
    def highest(self) -> float:
        """[m]."""
        return float(self.top.max())

    def from_here(self, way: float) -> Hurdle:
        """Return it as it is seen from farther along the way [m]."""
        return Hurdle(self.along - way, self.top)

    def spare(self, along: Array, height: Array, margin: float) -> Array:
        """Return how far points are above it, infinite where they are neither over it nor near.

        Args:
            along: of any shape, ways of the points [m].
            height: of the same shape [m].
            margin: how far before and behind it counts, and above it [m].
        """
        over = (along >= self.near - margin) & (along <= self.far + margin)
        top = np.interp(along, self.along, self.top)
        return np.where(over, height - top - margin, np.inf)


def hurdle_on(
    solids: Sequence[Array], place: Array, heading: float, half_width: float
) -> Hurdle | None:
    """Return what of convex solids is in a strip, None if nothing is.

    Args:
        solids: their corners (n, 3) in the world [m].
        place: (x, z) in the middle of the strip, from which ways count [m].
        heading: of the strip [rad].
        half_width: of the strip [m].
    """
    ahead = heading_vector(heading)
    # Forward is (c, -s) and to the right (s, c) in x and z.
    right = np.array([-ahead[1], ahead[0]])
    outlines = [_clipped(corners, place, ahead, right, half_width) for corners in solids]
    outlines = [one for one in outlines if len(one) > 1 and np.ptp(one[:, 0]) > 0.0]
    if not outlines:
        return None
    first = min(float(one[:, 0].min()) for one in outlines)
    last = max(float(one[:, 0].max()) for one in outlines)
    along = np.linspace(first, last, STATIONS)
    tops = [_top(one, along) for one in outlines]
    return Hurdle(along, np.max(tops, axis=0))


def _clipped(corners: Array, place: Array, ahead: Array, right: Array, half: float) -> Array:
    """Return points (m, 2), way and height, whose hull is the side view of what is in a strip."""
    over = corners[:, [0, 2]] - place
    s, w, y = (over * ahead).sum(axis=-1), (over * right).sum(axis=-1), corners[:, 1]
    inside = np.abs(w) <= half
    found = [np.stack([s[inside], y[inside]], axis=-1)]
    # A convex solid has all lines between its corners: those that leave the strip are cut.
    i, j = np.triu_indices(len(corners), 1)
    for edge in (-half, half):
        cuts = (w[i] - edge) * (w[j] - edge) < 0.0
        a, b = i[cuts], j[cuts]
        u = (edge - w[a]) / (w[b] - w[a])
        found.append(np.stack([s[a] + u * (s[b] - s[a]), y[a] + u * (y[b] - y[a])], axis=-1))
    result = np.concatenate(found)
    # Upright sides are so in spite of rounding.
    result[:, 0] = np.round(result[:, 0], EXACT)
    return result


def _top(points: Array, along: Array) -> Array:
    """Return the upper side (k,) of the hull of points (m, 2) at ways (k,) [m]."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    upper = list[Array]()
    for point in points[order]:
        if upper and upper[-1][0] == point[0]:
            upper.pop()
        while len(upper) > 1 and _turns_left(upper[-2], upper[-1], point):
            upper.pop()
        upper.append(point)
    s, y = np.array(upper).T
    result: Array = np.interp(along, s, y, left=NOWHERE, right=NOWHERE)
    return result


def _turns_left(a: Array, b: Array, c: Array) -> bool:
    return bool((b[0] - a[0]) * (c[1] - a[1]) >= (b[1] - a[1]) * (c[0] - a[0]))
