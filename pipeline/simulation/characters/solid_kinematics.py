"""Solid kinematics."""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.dynamics.compiled import Record, compiled, inlined
from pipeline.simulation.dynamics.terrain_contacts import nearest_on_triangle
from pipeline.simulation.dynamics.vectors import (
    Vector,
    cross,
    dot,
    length,
    minus,
    plus,
    row,
    rows_of,
    set_triple,
    times,
    triple,
    turned,
    unturned,
)


@inlined
def go_on(solid: Record, h: float) -> None:
    """Let a solid go on by a sub-step `h` [s] as fast as it goes."""
    if not solid.is_present:
        return
    solid.v[1] -= solid.fall_acceleration * h
    v, w = triple(solid.v), triple(solid.w)
    set_triple(solid.p, plus(triple(solid.p), times(h, v)))
    angle = h * length(w)
    if angle > 0.0:
        _turn(solid, times(h / angle, w), angle)
    R, middle, half = rows_of(solid.R), triple(solid.middle), solid.half
    for k in range(3):
        # Around the box of its own frame.
        if solid.radius > 0.0:
            around: float = solid.radius
        else:
            around = abs(R[k][0]) * half[0] + abs(R[k][1]) * half[1] + abs(R[k][2]) * half[2]
        at = solid.p[k] + dot(R[k], middle)
        solid.low[k], solid.high[k] = at - around, at + around


@inlined
def _turn(solid: Record, axis: Vector, angle: float) -> None:
    """Turn a solid about an axis.

    Source: Rodrigues, R' = R + sin(a) [n]R + (1 - cos(a)) [n][n]R, column by column.
    """
    s, c = math.sin(angle), 1.0 - math.cos(angle)
    for k in range(3):
        column = (solid.R[0, k], solid.R[1, k], solid.R[2, k])
        once = cross(axis, column)
        new = plus(column, plus(times(s, once), times(c, cross(axis, once))))
        solid.R[0, k], solid.R[1, k], solid.R[2, k] = new[0], new[1], new[2]


@inlined
def velocity_at(solid: Record, arm: Vector) -> Vector:
    """Return how fast the place of a solid at an arm from where it is goes [m/s]."""
    return plus(triple(solid.v), cross(triple(solid.w), arm))


@inlined
def gives(solid: Record, arm: Vector, n: Vector) -> float:
    """Return the speed that a unit of impulse along n gives a place of a solid [1/kg]."""
    if solid.inverse_mass == 0.0:
        return 0.0
    lever = cross(arm, n)
    result: float = solid.inverse_mass + dot(lever, turned(rows_of(solid.inverse_inertia), lever))
    return result


@inlined
def shove(solid: Record, arm: Vector, impulse: Vector, h: float) -> None:
    """Push a solid at an arm from where it is; what it goes by in this sub-step changes too."""
    if solid.inverse_mass == 0.0:
        return
    twist = cross(arm, impulse)
    spin = turned(rows_of(solid.inverse_inertia), twist)
    for k in range(3):
        solid.impulse[k] += impulse[k]
        solid.angular_impulse[k] += twist[k]
        solid.v[k] += solid.inverse_mass * impulse[k]
        solid.w[k] += spin[k]
        solid.p[k] += h * solid.inverse_mass * impulse[k]


FAR = 1e9
"""Gap of what is nowhere near [m]."""

TINY = 1e-9


@compiled
def gap_of(solids: Solids, s: int, at: Vector, reach: float) -> tuple[float, Vector]:
    """Return how far a place is from a solid, negative inside [m], and the way out of it.

    What is farther than `reach` is just far.
    """
    solid = solids.bodies[s]
    R = rows_of(solid.R)
    local = unturned(R, minus(at, triple(solid.p)))
    if solid.radius > 0.0:
        away = minus(local, triple(solid.middle))
        far = length(away)
        up = times(1.0 / far, away) if far > TINY else (0.0, 1.0, 0.0)
        return far - solid.radius, turned(R, up)
    planes, best, way = solids.planes, -FAR, 0
    for k in range(solid.planes[0], solid.planes[0] + solid.planes[1]):
        gap = planes[k, 0] * local[0] + planes[k, 1] * local[1] + planes[k, 2] * local[2]
        gap -= planes[k, 3]
        if gap > best:
            best, way = gap, k
            if best > reach:
                return FAR, (0.0, 1.0, 0.0)
    normal = (planes[way, 0], planes[way, 1], planes[way, 2])
    if best > 0.0:
        best, normal = _beyond(solids, solid, local)
    return best, turned(R, normal)


@compiled
def _beyond(solids: Solids, solid: Record, local: Vector) -> tuple[float, Vector]:
    """Return how far a place outside a polyhedron is from it, and the way [m]."""
    planes, corners, least, normal = solids.planes, solids.corners, FAR, (0.0, 1.0, 0.0)
    for k in range(solid.triangles[0], solid.triangles[0] + solid.triangles[1]):
        a, b, c, lies = _four(solids.triangles, k)
        up = (planes[lies, 0], planes[lies, 1], planes[lies, 2])
        gap = dot(up, local) - planes[lies, 3]
        if gap <= 0.0 or gap >= least:
            # It looks the other way, or its whole plane is farther.
            continue
        away = minus(
            local, nearest_on_triangle(local, (row(corners, a), row(corners, b), row(corners, c)))
        )
        far = length(away)
        if far < least:
            least, normal = far, times(1.0 / far, away) if far > TINY else up
    return least, normal


@inlined
def _four(numbers: IntArray, k: int) -> tuple[int, int, int, int]:
    return numbers[k, 0], numbers[k, 1], numbers[k, 2], numbers[k, 3]
