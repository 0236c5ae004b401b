"""Tubes: round surfaces along a line, closed by caps; and balls."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.figures.solids import loft
from pipeline.simulation.people.patches import Surface
from pipeline.simulation.spatial import Array, cross, normalized

CAP = np.radians([25.0, 65.0])
"""Latitudes of the rings of a cap."""


def tube(points: Array, radii: Array, around: int) -> Surface:
    """Return the surface around a line.

    Args:
        points: (n, 3) of the line [m]; it does not run along X.
        radii: (n,) there [m].
        around: vertices of a ring.
    """
    along = normalized(np.gradient(points, axis=0))
    x = np.array([1.0, 0.0, 0.0])
    places, sizes, ways = list(points), list(radii), list(along)
    for k, sign in ((0, -1.0), (-1, 1.0)):
        rings = [points[k] + sign * radii[k] * np.sin(a) * along[k] for a in CAP]
        narrow = [radii[k] * np.cos(a) for a in CAP]
        if k == 0:
            places, sizes = [*rings[::-1], *places], [*narrow[::-1], *sizes]
            ways = [along[0]] * len(CAP) + ways
        else:
            places, sizes = [*places, *rings], [*sizes, *narrow]
            ways = ways + [along[-1]] * len(CAP)
    y = normalized(cross(np.array(ways), np.broadcast_to(x, (len(ways), 3))))
    z = cross(np.array(ways), y)
    angle = np.arange(around) * (2.0 * np.pi / around)
    ring = np.cos(angle)[:, None] * y[:, None] + np.sin(angle)[:, None] * z[:, None]
    rings = np.array(places)[:, None] + np.array(sizes)[:, None, None] * ring
    ends = np.stack([points[0] - radii[0] * along[0], points[-1] + radii[-1] * along[-1]])
    solid = loft(rings, ends)
    return Surface(solid.vertices, solid.faces)


def globe(centre: Array, radii: Array, rings: int, around: int) -> Surface:
    """Return an ellipsoid around `centre` (3,) of `radii` (3,), its poles above and below."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, rings + 2)[1:-1]
    turn = np.arange(around) * (2.0 * np.pi / around)
    ring = np.stack(
        [
            np.cos(angle)[:, None] * np.sin(turn),
            np.repeat(np.sin(angle)[:, None], around, axis=1),
            np.cos(angle)[:, None] * np.cos(turn),
        ],
        axis=-1,
    )
    poles = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    solid = loft(ring * radii + centre, poles * radii + centre)
    return Surface(solid.vertices, solid.faces)
