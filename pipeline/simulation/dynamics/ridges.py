"""Ridges: the edges and vertices of a terrain that stand out, and bodies that meet them.

Above the ground a convex body leaves a gap, measured straight up, that is linear between
the lines in which edges of either are seen from above. So the least gap lies at a vertex of
the body, at a vertex of the ground, or where two edges cross; and in hollows of the ground
only at the first. Vertices and crossings are looked at here, and only where the ground
stands out.

A gap counts along the normal of the contact: the facet's, or that of both edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.bins import Bins, Numbers
from pipeline.simulation.dynamics.rigid import Bodies, dot, turned
from pipeline.simulation.spatial import Array, cross
from pipeline.simulation.terrain.heightfield import HeightField

STANDS_OUT = 1e-9
"""Height by which two triangles differ from one plane, in cells: less is rounding."""

OVERHANG = -0.1
"""Least rise of a contact's normal from the ground."""

PARALLEL = 1e-6
"""Sine of the angle between edges that cross nowhere in particular."""


@dataclass(frozen=True, eq=False)
class Found:
    """M contacts that may be.

    Attributes:
        body: (M,) whose.
        gap: (M,) [m].
        normal: (M, 3) from the ground.
        place: (M, 3) [m].
    """

    body: Numbers
    gap: Array
    normal: Array
    place: Array

    def some(self, which: NDArray[np.bool_]) -> Found:
        """Return some of them."""
        return Found(self.body[which], self.gap[which], self.normal[which], self.place[which])

    @staticmethod
    def joined(some: list[Found]) -> Found:
        """Put contacts one after the other."""
        names = ("body", "gap", "normal", "place")
        return Found(*(np.concatenate([getattr(one, name) for one in some]) for name in names))


@dataclass(frozen=True, eq=False)
class Ridges:
    """What of a surface stands out.

    Attributes:
        edges: (E, 2, 3) ends of edges [m].
        peaks: (V, 3) vertices [m].
        edge_bins: of the edges.
        peak_bins: of the vertices.
    """

    edges: Array
    peaks: Array
    edge_bins: Bins
    peak_bins: Bins

    @staticmethod
    def of(field: HeightField) -> Ridges:
        """Look for the edges of a surface that stand out; its border does."""
        vertices = field.vertices
        ends = _standing_out(vertices, field.faces.astype(np.int64), min(field.cell))
        edges = vertices[ends]
        peaks = vertices[np.unique(ends)]
        return Ridges(edges, peaks, Bins.of(field, edges.mean(axis=1)), Bins.of(field, peaks))

    def meet(self, bodies: Bodies, p: Array, R: Array, world: Array, slack: float) -> Found:
        """Return the contacts of polyhedra with what stands out, farther gaps left out.

        Args:
            bodies: B of them.
            p: (B, 3) their places [m].
            R: (B, 3, 3) their attitudes.
            world: (B, V, 3) their vertices in the world [m].
            slack: gaps that are larger count for nothing [m].
        """
        low = world[..., 1].min(axis=1) - slack
        normals = turned(R[:, None], bodies.normals)
        peaks = self._peaks(bodies, p, normals, low)
        crossings = self._crossings(bodies, p, world, low)
        found = Found.joined([peaks, crossings])
        return found.some(found.gap <= slack)

    def _peaks(self, bodies: Bodies, p: Array, normals: Array, low: Array) -> Found:
        """Return vertices of the ground near facets, their gaps being distances from these."""
        body, peak = self.peak_bins.near(p, bodies.reach)
        place = self.peaks[peak]
        high = place[:, 1] >= low[body]
        body, place = body[high], place[high]
        n = normals[body]
        away = dot(n, (place - p[body])[:, None]) - bodies.offsets[body]
        which = np.argmax(away, axis=1)
        rows = np.arange(len(body))
        normal = -n[rows, which]
        # No ground hangs over, so what lies in a facet that looks up is met by another.
        return Found(body, away[rows, which], normal, place).some(normal[:, 1] > OVERHANG)

    def _crossings(self, bodies: Bodies, p: Array, world: Array, low: Array) -> Found:
        """Return places where edges of bodies pass over edges of the ground."""
        body, edge = self.edge_bins.near(p, bodies.reach)
        ends = self.edges[edge]
        high = ends[..., 1].max(axis=1) >= low[body]
        body, ends = body[high], ends[high]
        corner = bodies.edges[body]
        a = world[body[:, None], corner[..., 0]]
        along = world[body[:, None], corner[..., 1]] - a
        c = ends[:, None, 0]
        ground = ends[:, None, 1] - c
        width = _seen_from_above(along, ground)
        safe = np.where(width == 0.0, 1.0, width)
        s = _seen_from_above(c - a, ground) / safe
        t = _seen_from_above(c - a, along) / safe
        crosses = (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0) & (width != 0.0)
        row, k = np.nonzero(crosses)
        a, along, s = a[row, k], along[row, k], s[row, k]
        c, ground, t = c[row, 0], ground[row, 0], t[row, k]
        rise = (a[:, 1] + s * along[:, 1]) - (c[:, 1] + t * ground[:, 1])
        normal = cross(along, ground)
        length = np.sqrt(dot(normal, normal))
        normal *= (np.sign(normal[:, 1]) / np.where(length > 0.0, length, 1.0))[:, None]
        lengths = np.sqrt(dot(along, along) * dot(ground, ground))
        firm = length > PARALLEL * lengths
        place = c + t[:, None] * ground
        return Found(body[row], rise * normal[:, 1], normal, place).some(firm)


def _seen_from_above(a: Array, b: Array) -> Array:
    """Return the area (...) of what vectors (..., 3) span, seen along -Y."""
    result: Array = a[..., 0] * b[..., 2] - a[..., 2] * b[..., 0]
    return result


def _standing_out(vertices: Array, faces: NDArray[np.int64], cell: float) -> NDArray[np.int64]:
    """Return the edges (E, 2) of triangles from which both sides fall away, and the border."""
    sides = np.concatenate([faces[:, [0, 1, 2]], faces[:, [1, 2, 0]], faces[:, [2, 0, 1]]])
    ends = np.sort(sides[:, :2], axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends, sides = ends[order], sides[order]
    twin = np.zeros(len(ends), dtype=bool)
    twin[:-1] = (ends[1:] == ends[:-1]).all(axis=1)
    first = np.flatnonzero(twin)
    a, b, c = np.moveaxis(vertices[sides[first]], 1, 0)
    other = vertices[sides[first + 1, 2]]
    up = cross(b - a, c - a)
    up /= np.sqrt(dot(up, up))[:, None]
    falls = dot(up, other - a) < -STANDS_OUT * cell
    alone = ~twin
    alone[first + 1] = False
    return np.concatenate([ends[first[falls]], ends[alone]])
