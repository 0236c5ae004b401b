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
from pipeline.simulation.dynamics.grid import Grid, Numbers, Spans
from pipeline.simulation.dynamics.records import Shapes
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

Box = tuple[Vector, Vector]
"""Least and greatest coordinates [m]."""


@compiled
def meet_ridges(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    p: Vector,
    R: Rows,
    world: Array,
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
        world: (V, 3) its vertices in the world [m].
        box: that these lie in.
        cells: those under it.
        slack: gaps that are larger count for nothing [m].
    """
    i, i_last, j, j_last = cells
    least, most = box
    for line in range(j, j_last + 1):
        start = line * grid.frame.n_x
        for k in range(grid.starts[start + i], grid.starts[start + i_last + 1]):
            one, other = grid.ridges[k, 0], grid.ridges[k, 1]
            c, d = row(grid.vertices, one), row(grid.vertices, other)
            apart = max(c[0], d[0]) < least[0] - slack or min(c[0], d[0]) > most[0] + slack
            apart = apart or max(c[2], d[2]) < least[2] - slack
            apart = apart or min(c[2], d[2]) > most[2] + slack
            if apart or max(c[1], d[1]) < least[1] - slack:
                continue
            if one == other:
                _meet_peak(shapes.facets, body, p, R, c, slack)
            else:
                _meet_edge(shapes.edges, body, p, world, c, d, slack)


@compiled
def _meet_peak(facets: Array, body: Record, p: Vector, R: Rows, peak: Vector, slack: float) -> None:
    """Add a vertex of the ground near a facet, its gap being the distance from that."""
    lever = minus(peak, p)
    place = unturned(R, lever)
    most, which = -np.inf, 0
    first, count = body.facets
    for k in range(first, first + count):
        away = dot(row(facets, k), place) - facets[k, 3]
        if away > slack:
            return
        if away > most:
            most, which = away, k
    normal = times(-1.0, turned(R, row(facets, which)))
    # No ground hangs over, so what lies in a facet that looks up is met by another.
    if normal[1] > OVERHANG:
        insert_new(body, most, normal, lever)


@compiled
def _meet_edge(
    edges: Numbers, body: Record, p: Vector, world: Array, c: Vector, d: Vector, slack: float
) -> None:
    """Add the places where edges of a body pass over an edge of the ground."""
    top = max(c[1], d[1]) + slack
    ground = minus(d, c)
    first, count = body.edges
    for e in range(first, first + count):
        a, end = row(world, edges[e, 0]), row(world, edges[e, 1])
        if min(a[1], end[1]) > top:
            continue
        along, between = minus(end, a), minus(c, a)
        # Areas of what two vectors span, seen from above.
        width = along[0] * ground[2] - along[2] * ground[0]
        s = between[0] * ground[2] - between[2] * ground[0]
        t = between[0] * along[2] - between[2] * along[0]
        if width < 0.0:
            width, s, t = -width, -s, -t
        if width > 0.0 and s >= 0.0 and t >= 0.0 and s <= width and t <= width:
            s, t = s / width, t / width
            rise = a[1] + s * along[1] - (c[1] + t * ground[1])
            lever = minus(plus(c, times(t, ground)), p)
            _cross(body, along, ground, rise, lever, slack)


@compiled
def _cross(
    body: Record, along: Vector, ground: Vector, rise: float, lever: Vector, slack: float
) -> None:
    """Add the contact of two edges that cross, seen from above, one above the other."""
    normal = cross(along, ground)
    square = dot(normal, normal)
    if square > PARALLEL * PARALLEL * dot(along, along) * dot(ground, ground):
        normal = times(math.copysign(1.0 / length(normal), normal[1]), normal)
        gap = rise * normal[1]
        if gap <= slack:
            insert_new(body, gap, normal, lever)
