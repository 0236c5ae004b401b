"""Edge contacts: polyhedra on the convex edges and vertices of a terrain.

Above the ground a convex body leaves a gap, measured straight up, that is linear between the lines
in which edges of either are seen from above. So the least gap lies at a vertex of the body, at a
vertex of the ground, or where two edges cross; in hollows of the ground only at the first. Vertices
and crossings are looked at here, only where the ground is convex.

Two edges count where the gap grows from their crossing along both: else it is less at another
crossing or an end. Then their normal lies between those of the ground beside the one and between
those of the body beside the other, so it is a direction in which they can be separated. An edge
deep in a wall is measured from that wall, not from the top. The gap counts along the normal of the
contact: the facet's, or that of both edges.

A contact that is deep along its normal although the body hardly overlaps the ground in another
direction is none: beside a wall, an edge of the ground above the bottom of the body is in front of
it, and the wall is what the body meets. Steep edges that cross far apart, seen from above, may be
nearest to one another beyond their ends.

Source: Gregorius 2013 (arcs of the Gauss map that cross), for edges of two convex solids.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.dynamics.body_record import Shapes, Workspace, insert_new_contact
from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.terrain_grid import Grid, Spans
from pipeline.simulation.dynamics.vectors import (
    Rows,
    Vector,
    cross,
    dot,
    inverse_turned,
    length,
    minus,
    plus,
    row,
    times,
    turned,
)
from pipeline.simulation.spatial import Array

LEVEL_NORMAL = 1e-9
"""Vertical component of a normal that counts as zero."""

PARALLEL_EDGES = 1e-6
"""Sine of the angle between edges that count as parallel."""

EDGE_IN_PLANE = 1e-3
"""Sine of the angle to a plane at which an edge counts as lying in it."""

DEEP_OVERLAP = 1e-3
"""Depth beyond which a contact must be the direction of least overlap, in sizes of the body."""

UPWARD_FACET = 1e-3
"""Vertical component of the normal above which nothing below can touch a facet."""

Box = tuple[Vector, Vector]
"""Lower and upper corner [m]."""


@compiled
def add_edge_contacts(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    p: Vector,
    R: Rows,
    room: Workspace,
    box: Box,
    cells: Spans,
    slack: float,
) -> None:
    """Adds the contacts of a body with the convex edges of a terrain.

    Args:
        grid: the ground.
        shapes: of all bodies.
        body: the body.
        p: its position [m].
        R: its attitude.
        room: workspace with its vertices in the world [m].
        box: bounding box of these.
        cells: cells under the box.
        slack: largest gap of a contact [m].
    """
    vertices, ridges, starts = grid.vertices, grid.ridges, grid.starts
    i, i_last, j, j_last = cells
    least, most = box
    # Edges are computed at the first ridge that is near.
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
                _add_vertex_on_facet(shapes.facets, body, p, R, c, slack)
            else:
                if edges < 0:
                    edges = _downward_edges(shapes, body, R, room)
                _add_crossings(room, edges, body, p, c, minus(d, c), grid.sides[k], slack)


@compiled
def _downward_edges(shapes: Shapes, body: Record, R: Rows, room: Workspace) -> int:
    """Writes the edges that something below can touch; returns their number.

    Starts and extents, and the normals of the adjacent facets, all in the world.
    """
    n, edges, world = 0, room.edges, room.world
    first, count = body.edges
    facet = body.facets[0]
    for e in range(first, first + count):
        start, end = shapes.edges[e, 0], shapes.edges[e, 1]
        one = row(shapes.facets, facet + shapes.edges[e, 2])
        other = row(shapes.facets, facet + shapes.edges[e, 3])
        if min(dot(R[1], one), dot(R[1], other)) < UPWARD_FACET:
            one, other = turned(R, one), turned(R, other)
            for i in range(3):
                edges[n, i] = world[start, i]
                edges[n, 3 + i] = world[end, i] - world[start, i]
                edges[n, 6 + i], edges[n, 9 + i] = one[i], other[i]
            n += 1
    return n


@compiled
def _add_vertex_on_facet(
    facets: Array, body: Record, p: Vector, R: Rows, peak: Vector, slack: float
) -> None:
    """Adds a vertex of the ground near a facet, with its distance from the facet as the gap.

    The ground has no overhangs, so its vertices enter through downward facets, also where the body
    has got below a vertex from the side.
    """
    lever = minus(peak, p)
    place = inverse_turned(R, lever)
    most, which, beside = -np.inf, -1, -np.inf
    # Where the vertical line through it enters and leaves the body.
    low, high = -np.inf, np.inf
    first, count = body.facets
    for k in range(first, first + count):
        away, up = dot(row(facets, k), place) - facets[k, 3], dot(R[1], row(facets, k))
        if up < -LEVEL_NORMAL:
            if away > slack:
                return
            low = max(low, -away / up)
            if away > most:
                most, which = away, k
        else:
            beside = max(beside, away)
            if up > LEVEL_NORMAL:
                high = min(high, -away / up)
            elif away > 0.0:
                return
    if most < -DEEP_OVERLAP * body.size and beside > most:
        return
    if which >= 0 and low <= high:
        insert_new_contact(body, most, times(-1.0, turned(R, row(facets, which))), lever)


@compiled
def _add_crossings(
    room: Workspace,
    n: int,
    body: Record,
    p: Vector,
    c: Vector,
    ground: Vector,
    sides: Array,
    slack: float,
) -> None:
    """Adds the crossings of n edges of a body with an edge of the ground that starts at c."""
    edges = room.edges
    for e in range(n):
        x, z = edges[e, 3], edges[e, 5]
        between_x, between_z = c[0] - edges[e, 0], c[2] - edges[e, 2]
        # Areas of parallelograms, seen from above.
        width = x * ground[2] - z * ground[0]
        s = between_x * ground[2] - between_z * ground[0]
        t = between_x * z - between_z * x
        if width < 0.0:
            width, s, t = -width, -s, -t
        if s >= 0.0 and t >= 0.0 and s <= width and t <= width and width > 0.0:
            s, t = s / width, t / width
            along = (x, edges[e, 4], z)
            one, other = (
                (edges[e, 6], edges[e, 7], edges[e, 8]),
                (edges[e, 9], edges[e, 10], edges[e, 11]),
            )
            if _separates(along, row(sides, 0), row(sides, 1)) and _separates(ground, one, other):
                place = plus(c, times(t, ground))
                start = row(edges, e)
                rise = start[1] + s * along[1] - place[1]
                normal = cross(along, ground)
                size = length(normal)
                if size <= PARALLEL_EDGES * length(along) * length(ground):
                    continue
                normal = times(math.copysign(1.0 / size, normal[1]), normal)
                gap = rise * normal[1]
                if gap > slack:
                    continue
                if gap < -DEEP_OVERLAP * body.size:
                    s, t = _nearest_of_lines(minus(c, start), along, ground)
                    if min(s, t) < 0.0 or max(s, t) > 1.0:
                        continue
                    place = plus(c, times(t, ground))
                    if gap < _lowest_over_planes(body, room.world, sides, place):
                        continue
                insert_new_contact(body, gap, normal, minus(place, p))


@compiled
def _separates(way: Vector, one: Vector, other: Vector) -> bool:
    """Returns whether a line leaves one of two planes that meet in an edge and enters the other."""
    first, second = dot(way, one), dot(way, other)
    level = EDGE_IN_PLANE * length(way)
    return first * second <= 0.0 or min(abs(first), abs(second)) <= level


@compiled
def _nearest_of_lines(between: Vector, along: Vector, ground: Vector) -> tuple[float, float]:
    """Returns where two lines are nearest to one another, in extents of each.

    Args:
        between: from the start of the one to that of the other [m].
        along: extent of the one [m].
        ground: extent of the other [m].
    """
    normal = cross(along, ground)
    square = dot(normal, normal)
    return dot(cross(between, ground), normal) / square, dot(cross(between, along), normal) / square


@compiled
def _lowest_over_planes(body: Record, world: Array, sides: Array, place: Vector) -> float:
    """Returns the largest height over two planes through a place of a body's lowest vertex [m]."""
    most = -np.inf
    for side in range(2):
        least, normal = np.inf, row(sides, side)
        for k in range(body.corners[1]):
            least = min(least, dot(normal, minus(row(world, k), place)))
        most = max(most, least)
    return most
