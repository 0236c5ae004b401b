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

EDGE_END = 1e-6
"""Distance beyond the end of an edge that still belongs to it, in lengths of the edge."""

EDGE_IN_PLANE = 1e-3
"""Sine of the angle to a plane at which an edge counts as lying in it."""

DEEP_OVERLAP = 1e-3
"""Depth beyond which a contact must be the direction of least overlap, in sizes of the body."""

EQUAL_DISTANCE = 1e-5
"""Difference of distances that count as equal, in sizes of the body."""

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
    has got below a vertex from the side. At an edge of the body all facets count that are equally
    near: their order must not decide to which side the vertex pushes.
    """
    lever = minus(peak, p)
    place = inverse_turned(R, lever)
    most, beside = -np.inf, -np.inf
    # Where the vertical line through it enters and leaves the body.
    low, high = -np.inf, np.inf
    near = EQUAL_DISTANCE * body.size
    first, count = body.facets
    for k in range(first, first + count):
        away, up = dot(row(facets, k), place) - facets[k, 3], dot(R[1], row(facets, k))
        if up < -LEVEL_NORMAL:
            if away > slack:
                return
            low = max(low, -away / up)
            most = max(most, away)
        else:
            beside = max(beside, away)
            if up > LEVEL_NORMAL:
                high = min(high, -away / up)
            elif away > near:
                return
    if most < -DEEP_OVERLAP * body.size and beside > most + near:
        return
    if most == -np.inf or low > high + near:
        return
    for k in range(first, first + count):
        away = dot(row(facets, k), place) - facets[k, 3]
        if away >= most - near and dot(R[1], row(facets, k)) < -LEVEL_NORMAL:
            insert_new_contact(body, away, times(-1.0, turned(R, row(facets, k))), lever)


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
        # Edges that meet at an end cross, whichever way that is rounded.
        end = EDGE_END * width
        if width > 0.0 and min(s, t) >= -end and max(s, t) <= width + end:
            start, along = row(edges, e), (x, edges[e, 4], z)
            one, other = (
                (edges[e, 6], edges[e, 7], edges[e, 8]),
                (edges[e, 9], edges[e, 10], edges[e, 11]),
            )
            if _separates(along, row(sides, 0), row(sides, 1)) and _separates(ground, one, other):
                place = plus(c, times(t / width, ground))
                rise = start[1] + s / width * along[1] - place[1]
                _add_crossing(
                    room.world, body, p, (start, along), (c, ground), sides, rise, place, slack
                )


@compiled
def _add_crossing(
    world: Array,
    body: Record,
    p: Vector,
    edge: tuple[Vector, Vector],
    ridge: tuple[Vector, Vector],
    sides: Array,
    rise: float,
    place: Vector,
    slack: float,
) -> None:
    """Adds the contact of two edges that cross, seen from above.

    Args:
        world: (V, 3) vertices of the body in the world [m].
        body: the body.
        p: its position [m].
        edge: start and extent of its edge [m].
        ridge: start and extent of that of the ground [m].
        sides: (2, 3) normals of the ground beside it.
        rise: height of the edge above the ridge where they cross [m].
        place: this point of the ridge [m].
        slack: largest gap of a contact [m].
    """
    (start, along), (c, ground) = edge, ridge
    normal = cross(along, ground)
    size = length(normal)
    if size <= PARALLEL_EDGES * length(along) * length(ground):
        return
    normal = times(math.copysign(1.0 / size, normal[1]), normal)
    gap = rise * normal[1]
    if gap > slack or not _is_between(normal, row(sides, 0), row(sides, 1)):
        return
    if gap < -DEEP_OVERLAP * body.size:
        s, t = _nearest_of_lines(minus(c, start), along, ground)
        if min(s, t) < -EDGE_END or max(s, t) > 1.0 + EDGE_END:
            return
        place = plus(c, times(t, ground))
        if gap < _lowest_over_planes(body, world, sides, place) - EQUAL_DISTANCE * body.size:
            return
    insert_new_contact(body, gap, normal, minus(place, p))


@compiled
def _separates(way: Vector, one: Vector, other: Vector) -> bool:
    """Returns whether a line leaves one of two planes that meet in an edge and enters the other."""
    first, second = dot(way, one), dot(way, other)
    level = EDGE_IN_PLANE * length(way)
    return first * second <= 0.0 or min(abs(first), abs(second)) <= level


@compiled
def _is_between(normal: Vector, one: Vector, other: Vector) -> bool:
    """Returns whether a normal of an edge lies between those of the planes beside it.

    Edges that nearly lie in one vertical plane have a level normal, which separates nothing.
    """
    least = dot(one, other) - EDGE_IN_PLANE
    return min(dot(normal, one), dot(normal, other)) >= least


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
