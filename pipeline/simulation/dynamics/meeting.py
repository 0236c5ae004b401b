"""Meeting: where bodies touch a terrain, or are about to.

Polyhedra touch it with their vertices (`corners`), and with facets and edges where it stands
out (`ridges`); balls with what is nearest (`rounding`). A body whose centre of mass has left
the terrain is held by nothing any more, nor is one that has got under it from beside.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.dynamics.compiled import Record, compiled
from pipeline.simulation.dynamics.corners import meet_corners
from pipeline.simulation.dynamics.grid import Grid, Spans, highest, inside, span, surface, to_grid
from pipeline.simulation.dynamics.records import Room, Shapes
from pipeline.simulation.dynamics.ridges import Box, meet_ridges
from pipeline.simulation.dynamics.rounding import meet_ball
from pipeline.simulation.dynamics.vectors import (
    Quaternion,
    Rows,
    Vector,
    plus,
    put,
    rotation,
    row,
    turned,
)
from pipeline.simulation.spatial import Array


@compiled
def meet(
    grid: Grid,
    shapes: Shapes,
    body: Record,
    p: Vector,
    q: Quaternion,
    slack: float,
    room: Room,
) -> None:
    """Find the contacts of a body.

    Args:
        grid: the ground.
        shapes: of all bodies.
        body: its contacts are written anew.
        p: where it is meant to be [m].
        q: in which attitude.
        slack: gaps that are larger need not be told [m].
        room: to work in.
    """
    body.count = 0
    if not inside(grid.frame, p[0], p[2]):
        return
    top = highest(grid.frame, grid.tops, p[0], p[2], body.reach + slack) + slack
    if p[1] - body.reach > top:
        return
    if body.radius > 0.0:
        meet_ball(grid, body, p, slack)
        return
    R = rotation(q)
    box, over = _placed(grid.frame, shapes.corners, body, p, R, slack, room.world)
    if box[0][1] <= top:
        meet_corners(grid, body, p, room.world, slack)
        meet_ridges(grid, shapes, body, p, R, room, box, over, slack)


@compiled
def _placed(
    frame: Record, corners: Array, body: Record, p: Vector, R: Rows, slack: float, world: Array
) -> tuple[Box, Spans]:
    """Write the vertices of a body in the world; return what they span, and the cells there."""
    low, high = (np.inf, np.inf, np.inf), (-np.inf, -np.inf, -np.inf)
    u_low, u_high, v_low, v_high = np.inf, -np.inf, np.inf, -np.inf
    first, count = body.corners
    for k in range(count):
        at = plus(p, turned(R, row(corners, first + k)))
        put(world, k, at)
        low = (min(low[0], at[0]), min(low[1], at[1]), min(low[2], at[2]))
        high = (max(high[0], at[0]), max(high[1], at[1]), max(high[2], at[2]))
        u, v = to_grid(frame, at[0], at[2])
        u_low, u_high, v_low, v_high = min(u_low, u), max(u_high, u), min(v_low, v), max(v_high, v)
    i, i_last = span(u_low - slack, u_high + slack, frame.size_x, frame.n_x)
    j, j_last = span(v_low - slack, v_high + slack, frame.size_z, frame.n_z)
    return (low, high), (i, i_last, j, j_last)


@compiled
def under(grid: Grid, body: Record, p: Vector) -> bool:
    """Say whether a body at p is wholly below the ground: it fell beside it and came back."""
    if not inside(grid.frame, p[0], p[2]):
        return False
    below: bool = p[1] < surface(grid.frame, grid.vertices, p[0], p[2])[0] - 2.0 * body.reach
    return below
