"""Balls on the triangles of a terrain: the nearest point of each, but for what is no corner.

Where two triangles lie in one plane, or fall away from an edge, the nearest point of the
one that is farther lies behind the plane in which the ball touches the nearer one, and says
nothing that this does not. Such points would be corners that are felt and not there.

Source: Ericson 2005, 5.1.5 (closest point on a triangle).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dynamics.bins import Bins
from pipeline.simulation.dynamics.ridges import Found
from pipeline.simulation.dynamics.rigid import dot
from pipeline.simulation.spatial import Array, cross
from pipeline.simulation.terrain.heightfield import HeightField

BEHIND = 1e-7
"""Height above a plane that is none, in radii."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """The triangles of a surface.

    Attributes:
        corners: (F, 3, 3) [m].
        bins: of their middles.
    """

    corners: Array
    bins: Bins

    @staticmethod
    def of(field: HeightField) -> Triangles:
        """Collect the triangles of a surface."""
        corners = field.vertices[field.faces.astype(np.int64)]
        return Triangles(corners, Bins.of(field, corners.mean(axis=1)))

    def meet(self, p: Array, radius: Array, slack: float) -> Found:
        """Return the contacts of balls, larger gaps than `slack` left out.

        Args:
            p: (B, 3) their middles [m].
            radius: (B,) [m].
            slack: [m].
        """
        body, number = self.bins.near(p, radius + slack)
        corners = self.corners[number]
        high = corners[..., 1].max(axis=1) >= p[body, 1] - radius[body] - slack
        body, corners = body[high], corners[high]
        place = nearest(p[body], corners)
        away = p[body] - place
        distance = np.sqrt(dot(away, away))
        up = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        up /= np.sqrt(dot(up, up))[:, None]
        # On which side of a triangle's plane a middle lies says nothing beyond its sides.
        field = self.bins.field
        above = (p[:, 1] > field.height(p[:, 0], p[:, 2]))[body] & (distance > 0.0)
        normal = np.where(above[:, None], away / np.maximum(distance, 1e-300)[:, None], up)
        gap = np.where(above, distance, -distance) - radius[body]
        found = Found(body, gap, normal, place).some(gap <= slack)
        return found.some(_counts(found, radius))


def _counts(found: Found, radius: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Say which contacts are not behind the plane of a nearer one of the same ball."""
    order = np.lexsort((found.gap, found.body))
    counts = np.ones(len(order), dtype=bool)
    body = found.body[order]
    for back in range(1, int(np.bincount(body).max(initial=0))):
        here, there = order[back:], order[:-back]
        same = body[back:] == body[:-back]
        over = dot(found.place[here] - found.place[there], found.normal[there])
        counts[here] &= ~(same & (over <= BEHIND * radius[body[back:]]))
    return counts


def nearest(point: Array, corners: Array) -> Array:
    """Return the nearest points (M, 3) of triangles (M, 3, 3) to points (M, 3)."""
    best = np.full(len(point), np.inf)
    result = np.empty_like(point)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    up = cross(b - a, c - a)
    square = dot(up, up)
    inside = np.ones(len(point), dtype=bool)
    for start, end in ((a, b), (b, c), (c, a)):
        side = end - start
        t = np.clip(dot(point - start, side) / dot(side, side), 0.0, 1.0)
        place = start + t[:, None] * side
        away = point - place
        distance = dot(away, away)
        nearer = distance < best
        best = np.where(nearer, distance, best)
        result[nearer] = place[nearer]
        inside &= dot(cross(side, point - start), up) >= 0.0
    flat = point - (dot(point - a, up) / square)[:, None] * up
    result[inside] = flat[inside]
    return result
