"""Ridges: polyhedra that meet the edges and vertices of a terrain that stand out.

Above the ground a convex body leaves a gap, measured straight up, that is linear between
the lines in which edges of either are seen from above. So the least gap lies at a vertex of
the body, at a vertex of the ground, or where two edges cross; and in hollows of the ground
only at the first. Vertices and crossings are looked at here, and only where the ground
stands out.

A gap counts along the normal of the contact: the facet's, or that of both edges.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.contacts import insert_new
from pipeline.simulation.dynamics.grid import Grid, Spans
from pipeline.simulation.dynamics.records import Room, Shapes
from pipeline.simulation.dynamics.vectors import (
    Rows,
    Vector,
    cross,
    dot,
    length,
    minus,
    plus,
    row,
    times,
    turned,
    unturned,
)
from pipeline.simulation.spatial import Array

OVERHANG = -0.1
"""Least rise of a contact's normal from the ground."""

PARALLEL = 1e-6
"""Sine of the angle between edges that cross nowhere in particular."""

AMISS = 1e-3
"""Depth of crossing edges from which facets are asked as well, in sizes of the body."""

UP = 1e-3
"""Rise of the normal of a facet that nothing below can touch."""

Box = tuple[Vector, Vector]
"""Least and greatest coordinates [m]."""


@compiled
def meet_ridges(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    p: Vector,
    R: Rows,
    room: Room,
    box: Box,
    cells: Spans,
    slack: float,
) -> None:
    """Add the contacts of a body with what stands out.

    Args:
        grid: the ground.
        shapes: of all bodies.
        body: the one that meets it.
        p: its place [m].
        R: its attitude.
        room: in it, its vertices in the world [m].
        box: that these lie in.
        cells: those under it.
        slack: gaps that are larger count for nothing [m].
    """
    vertices, ridges, starts = grid.vertices, grid.ridges, grid.starts
    i, i_last, j, j_last = cells
    least, most = box
    # The first ridge that is near asks for them.
    edges = -1
    for line in range(j, j_last + 1):
        start = line * grid.frame.n_x
        for k in range(starts[start + i], starts[start + i_last + 1]):
            one, other = ridges[k, 0], ridges[k, 1]
            c = (vertices[one, 0], vertices[one, 1], vertices[one, 2])
            d = (vertices[other, 0], vertices[other, 1], vertices[other, 2])
            apart = max(c[0], d[0]) < least[0] - slack or min(c[0], d[0]) > most[0] + slack
            apart = apart or max(c[2], d[2]) < least[2] - slack
            apart = apart or min(c[2], d[2]) > most[2] + slack
            if apart or max(c[1], d[1]) < least[1] - slack:
                continue
            if one == other:
                _meet_peak(shapes.facets, body, p, R, c, slack)
            else:
                if edges < 0:
                    edges = _lower_edges(shapes, body, R, room)
                _meet_edge(shapes.facets, room.edges, edges, body, p, R, c, minus(d, c), slack)


@compiled
def _lower_edges(shapes: Shapes, body: Record, R: Rows, room: Room) -> int:
    """Write beginnings and extents of edges that something below can touch; return how many."""
    n, edges, world = 0, room.edges, room.world
    first, count = body.edges
    facet = body.facets[0]
    for e in range(first, first + count):
        start, end = shapes.edges[e, 0], shapes.edges[e, 1]
        one = dot(R[1], row(shapes.facets, facet + shapes.edges[e, 2]))
        other = dot(R[1], row(shapes.facets, facet + shapes.edges[e, 3]))
        if min(one, other) < UP:
            for i in range(3):
                edges[n, i] = world[start, i]
                edges[n, 3 + i] = world[end, i] - world[start, i]
            n += 1
    return n


@compiled
def _meet_peak(facets: Array, body: Record, p: Vector, R: Rows, peak: Vector, slack: float) -> None:
    """Add a vertex of the ground near a facet, its gap being the distance from that."""
    lever = minus(peak, p)
    gap, normal = _out(facets, body, R, lever, slack)
    # No ground hangs over, so what lies in a facet that looks up is met by another.
    if gap <= slack and normal[1] > OVERHANG:
        insert_new(body, gap, normal, lever)


@compiled
def _out(facets: Array, body: Record, R: Rows, lever: Vector, slack: float) -> tuple[float, Vector]:
    """Return how far a place is outside the nearest facet, and the normal into that.

    Beyond `slack` whichever facet comes first is told.
    """
    place = unturned(R, lever)
    most, which = -np.inf, 0
    first, count = body.facets
    for k in range(first, first + count):
        away = dot(row(facets, k), place) - facets[k, 3]
        if away > most:
            most, which = away, k
            if away > slack:
                break
    return most, times(-1.0, turned(R, row(facets, which)))


@compiled
def _meet_edge(
    facets: Array,
    edges: Array,
    n: int,
    body: Record,
    p: Vector,
    R: Rows,
    c: Vector,
    ground: Vector,
    slack: float,
) -> None:
    """Add the places where n edges of a body pass over an edge of the ground, from c."""
    for e in range(n):
        x, z = edges[e, 3], edges[e, 5]
        between_x, between_z = c[0] - edges[e, 0], c[2] - edges[e, 2]
        # Areas of what two vectors span, seen from above.
        width = x * ground[2] - z * ground[0]
        s = between_x * ground[2] - between_z * ground[0]
        t = between_x * z - between_z * x
        if width < 0.0:
            width, s, t = -width, -s, -t
        if s >= 0.0 and t >= 0.0 and s <= width and t <= width and width > 0.0:
            s, t = s / width, t / width
            along = (x, edges[e, 4], z)
            rise = edges[e, 1] + s * along[1] - (c[1] + t * ground[1])
            lever = minus(plus(c, times(t, ground)), p)
            start = (-between_x, edges[e, 1] - c[1], -between_z)
            _cross(facets, body, R, along, ground, start, rise, lever, slack)


@compiled
def _cross(
    facets: Array,
    body: Record,
    R: Rows,
    along: Vector,
    ground: Vector,
    start: Vector,
    rise: float,
    lever: Vector,
    slack: float,
) -> None:
    """Add the contact of two edges that cross, seen from above, one above the other."""
    normal = cross(along, ground)
    square = dot(normal, normal)
    if square > PARALLEL * PARALLEL * dot(along, along) * dot(ground, ground):
        normal = times(math.copysign(1.0 / length(normal), normal[1]), normal)
        gap = rise * normal[1]
        if gap < -AMISS * body.size and not _nearest_within(along, ground, start):
            # Beside a wall this is deep below the edge, and yet others are nearer.
            away, out = _out(facets, body, R, lever, slack)
            if away < gap or out[1] <= OVERHANG:
                return
            gap, normal = away, out
        if gap <= slack:
            insert_new(body, gap, normal, lever)


@compiled
def _nearest_within(along: Vector, ground: Vector, start: Vector) -> bool:
    """Say whether edges come nearest to one another between their ends.

    Args:
        along: extent of the one [m].
        ground: of the other [m].
        start: from the begin of the other to that of the one [m].
    """
    a, b, c = dot(along, along), dot(along, ground), dot(ground, ground)
    d, e = dot(along, start), dot(ground, start)
    inside = a * c - b * b
    s, t = b * e - c * d, a * e - b * d
    return s >= 0.0 and t >= 0.0 and s <= inside and t <= inside
