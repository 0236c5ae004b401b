"""Convex hull of points: the polyhedron of a body.

Points are added one by one; the faces that a new point sees are replaced by triangles from their
rim to it. That is exact but for one tolerance and runs once a body, so no geometry library is
needed.

Source: Ericson 2005, chapter 3 (incremental hulls).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import MassError
from pipeline.simulation.spatial import Array, cross, normalized

SAME_PLANE = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5)
"""Distances from a plane that count as zero, relative to the extent of the points.

The first one that rounding of the points leaves a closed hull: those of meshes may be rounded to
single precision.
"""

SAME_FACET_SINE = 1e-7
"""Sine of the angle between neighbouring triangles of one facet."""

MOST_OUTSIDE = 2e-5
"""Farthest that a point may lie outside a face, relative to the extent of the points."""


class UnresolvedHull(MassError):
    """Points are too near to one another, or to one plane, for the hull to be told."""

    def __init__(self) -> None:
        super().__init__(
            "its points are too near to one another, or to one plane, to tell its corners"
        )


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex polyhedron.

    Attributes:
        vertices: (V, 3) [m].
        faces: (F, 3) triangles, counter-clockwise from outside.
        facets: each a plane polygon of vertices, counter-clockwise from outside.
        normals: (P, 3) of the facets, outward.
        edges: (E, 2) between facets.
    """

    vertices: Array
    faces: NDArray[np.uint32]
    facets: tuple[tuple[int, ...], ...]
    normals: Array
    edges: NDArray[np.int64]

    @property
    def offsets(self) -> Array:
        """Distances (P,) of the facets from the origin [m]."""
        first = np.array([facet[0] for facet in self.facets])
        return np.sum(self.normals * self.vertices[first], axis=-1)


def hull_of(points: Array) -> Hull:
    """Returns the convex hull of points (n, 3).

    Raises:
        MassError: if they lie in one plane, or are fewer than four.
    """
    hull = _hull(points)
    # Points inside a facet or an edge are no corners; the hull is the same without them.
    facets = np.zeros(len(hull.vertices), dtype=np.int64)
    for facet in hull.facets:
        facets[list(facet)] += 1
    corners = facets >= 3
    return hull if corners.all() else _hull(hull.vertices[corners])


def _hull(points: Array) -> Hull:
    extent = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    for tolerance in SAME_PLANE[:-1]:
        try:
            return _hull_within(points, tolerance * extent)
        except UnresolvedHull:
            continue
    return _hull_within(points, SAME_PLANE[-1] * extent)


def _hull_within(points: Array, near: float) -> Hull:
    """Returns the hull of points, of which those within `near` [m] of a plane lie in it.

    Raises:
        UnresolvedHull: if rounding left the triangles open.
        MassError: as `hull_of`.
    """
    faces = _grow_hull(points, _initial_tetrahedron(points, near), near)
    normals, offsets = _planes(points, faces)
    if (points @ normals.T - offsets).max() > MOST_OUTSIDE * np.ptp(points, axis=0).max():
        raise UnresolvedHull
    used = np.unique(faces)
    number = np.zeros(len(points), dtype=np.int64)
    number[used] = np.arange(len(used))
    faces = number[faces]
    return _with_facets(points[used], faces)


def _initial_tetrahedron(points: Array, near: float) -> list[int]:
    """Returns four points, far apart from one another, that span a solid."""
    if len(points) < 4:
        raise MassError(f"a solid needs four points or more, not {len(points)}")
    a = int(np.argmin(points[:, 0]))
    away = points - points[a]
    b = int(np.argmax(np.linalg.norm(away, axis=-1)))
    along = normalized(away[b])
    beside = np.linalg.norm(away - (away @ along)[:, None] * along, axis=-1)
    c = int(np.argmax(beside))
    if beside[c] <= near:
        raise MassError("its points lie in one line, which encloses no volume")
    height = away @ normalized(np.cross(away[b], away[c]))
    d = int(np.argmax(np.abs(height)))
    if abs(height[d]) <= near:
        raise MassError("its points lie in one plane, which encloses no volume")
    return [a, b, c, d] if height[d] < 0.0 else [a, c, b, d]


def _grow_hull(points: Array, first: Sequence[int], near: float) -> NDArray[np.int64]:
    """Returns the triangles (F, 3) of the hull, grown from a tetrahedron."""
    a, b, c, d = first
    faces = np.array([[a, b, c], [a, d, b], [b, d, c], [c, d, a]])
    normals, offsets = _planes(points, faces)
    # Farthest points first: most others then lie inside at once.
    order = np.argsort(-np.linalg.norm(points - points[list(first)].mean(axis=0), axis=-1))
    for i in order:
        seen = normals @ points[i] - offsets > near
        if not seen.any():
            continue
        rim = _rim(faces[seen])
        if not len(rim):
            raise UnresolvedHull
        new = np.column_stack([rim, np.full(len(rim), i)])
        faces = np.concatenate([faces[~seen], new])
        own = _planes(points, new)
        normals = np.concatenate([normals[~seen], own[0]])
        offsets = np.concatenate([offsets[~seen], own[1]])
    return faces


def _planes(points: Array, faces: NDArray[np.int64]) -> tuple[Array, Array]:
    a, b, c = points[faces.T]
    normals = normalized(cross(b - a, c - a))
    return normals, np.sum(normals * a, axis=-1)


def _rim(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Returns the directed edges (n, 2) around a patch of triangles."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there = {(int(a), int(b)) for a, b in edges}
    return np.array([e for e in map(tuple, edges.tolist()) if (e[1], e[0]) not in there])


def _with_facets(vertices: Array, faces: NDArray[np.int64]) -> Hull:
    """Merges coplanar triangles into facets.

    Raises:
        MassError: if rounding left the triangles open, or one beside another.
    """
    normals, _ = _planes(vertices, faces)
    owner = {}
    for f, (a, b, c) in enumerate(faces.tolist()):
        owner[a, b] = owner[b, c] = owner[c, a] = f
    if len(owner) < 3 * len(faces) or any((b, a) not in owner for a, b in owner):
        raise UnresolvedHull
    group = list(range(len(faces)))

    def root(f: int) -> int:
        while group[f] != f:
            f = group[f]
        return f

    for (a, b), f in owner.items():
        g = owner[b, a]
        if np.linalg.norm(np.cross(normals[f], normals[g])) < SAME_FACET_SINE:
            group[max(root(f), root(g))] = min(root(f), root(g))
    patches: dict[int, list[int]] = {}
    for f in range(len(faces)):
        patches.setdefault(root(f), []).append(f)
    facets, flat = list[tuple[int, ...]](), list[Array]()
    edges = set[tuple[int, int]]()
    for members in patches.values():
        loop = _loop(_rim(faces[members]))
        facets.append(tuple(loop))
        flat.append(_polygon_area(vertices[loop]))
        edges |= {(min(e), max(e)) for e in pairwise([*loop, loop[0]])}
    return Hull(
        vertices,
        faces.astype(np.uint32),
        tuple(facets),
        normalized(np.array(flat)),
        np.array(sorted(edges)),
    )


def _loop(rim: NDArray[np.int64]) -> list[int]:
    """Returns the vertices of a closed rim (n, 2) of directed edges, in their order.

    Raises:
        UnresolvedHull: if the edges are no single loop.
    """
    after = {int(a): int(b) for a, b in rim}
    loop = [min(after, default=0)]
    while len(loop) < len(after):
        loop.append(after.get(loop[-1], -1))
    if len(set(loop)) < len(rim) or after.get(loop[-1]) != loop[0]:
        raise UnresolvedHull
    return loop


def _polygon_area(polygon: Array) -> Array:
    """Returns the area vector (3,) of a plane polygon (n, 3)."""
    arms = polygon - polygon[0]
    return 0.5 * cross(arms[1:-1], arms[2:]).sum(axis=0)
