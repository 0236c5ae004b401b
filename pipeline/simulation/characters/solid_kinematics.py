"""Solid kinematics: motion, impulses and signed distance of the solids of other rooms."""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.dynamics.compiled import Record, compiled, inlined
from pipeline.simulation.dynamics.nearest_ground import nearest_on_triangle
from pipeline.simulation.dynamics.vectors import (
    Vector,
    cross,
    dot,
    inverse_turned,
    length,
    minus,
    plus,
    row,
    rows_of,
    set_triple,
    times,
    triple,
    turned,
)


@inlined
def advance_solid(solid: Record, h: float) -> None:
    """Advance a solid by a sub-step `h` [s] at its velocity, and update its bounds."""
    if not solid.is_present:
        return
    solid.v[1] -= solid.fall_acceleration * h
    v, w = triple(solid.v), triple(solid.w)
    set_triple(solid.p, plus(triple(solid.p), times(h, v)))
    angle = h * length(w)
    if angle > 0.0:
        _turn_solid(solid, times(h / angle, w), angle)
    R, middle, half = rows_of(solid.R), triple(solid.middle), solid.half
    for k in range(3):
        if solid.radius > 0.0:
            extent: float = solid.radius
        else:
            extent = abs(R[k][0]) * half[0] + abs(R[k][1]) * half[1] + abs(R[k][2]) * half[2]
        at = solid.p[k] + dot(R[k], middle)
        solid.low[k], solid.high[k] = at - extent, at + extent


@inlined
def _turn_solid(solid: Record, axis: Vector, angle: float) -> None:
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
    """Return the velocity of a place at an arm from the origin of a solid [m/s]."""
    return plus(triple(solid.v), cross(triple(solid.w), arm))


@inlined
def mobility_at(solid: Record, arm: Vector, n: Vector) -> float:
    """Return the speed that a unit impulse along n gives a place of a solid [1/kg]."""
    if solid.inverse_mass == 0.0:
        return 0.0
    lever = cross(arm, n)
    return solid.inverse_mass + dot(lever, turned(rows_of(solid.inverse_inertia), lever))


@inlined
def apply_impulse(solid: Record, arm: Vector, impulse: Vector, h: float) -> None:
    """Apply an impulse at an arm from a solid's origin, which moves it in this sub-step too."""
    if solid.inverse_mass == 0.0:
        return
    torque_impulse = cross(arm, impulse)
    spin = turned(rows_of(solid.inverse_inertia), torque_impulse)
    for k in range(3):
        solid.impulse[k] += impulse[k]
        solid.angular_impulse[k] += torque_impulse[k]
        solid.v[k] += solid.inverse_mass * impulse[k]
        solid.w[k] += spin[k]
        solid.p[k] += h * solid.inverse_mass * impulse[k]


OUT_OF_REACH = 1e9  # gap beyond the reach asked for [m]
TINY = 1e-9


@compiled
def signed_distance(solids: Solids, s: int, at: Vector, reach: float) -> tuple[float, Vector]:
    """Return the gap between a place and a solid, negative inside [m], and the outward normal.

    A gap beyond `reach` is OUT_OF_REACH.
    """
    solid = solids.bodies[s]
    R = rows_of(solid.R)
    local = inverse_turned(R, minus(at, triple(solid.p)))
    if solid.radius > 0.0:
        offset = minus(local, triple(solid.middle))
        distance = length(offset)
        up = times(1.0 / distance, offset) if distance > TINY else (0.0, 1.0, 0.0)
        return distance - solid.radius, turned(R, up)
    planes, best, facet = solids.planes, -OUT_OF_REACH, 0
    for k in range(solid.planes[0], solid.planes[0] + solid.planes[1]):
        gap = planes[k, 0] * local[0] + planes[k, 1] * local[1] + planes[k, 2] * local[2]
        gap -= planes[k, 3]
        if gap > best:
            best, facet = gap, k
            if best > reach:
                return OUT_OF_REACH, (0.0, 1.0, 0.0)
    normal = (planes[facet, 0], planes[facet, 1], planes[facet, 2])
    if best > 0.0:
        best, normal = _distance_outside(solids, solid, local)
    return best, turned(R, normal)


@compiled
def _distance_outside(solids: Solids, solid: Record, local: Vector) -> tuple[float, Vector]:
    """Return the distance of an outside place from a polyhedron [m], and the normal."""
    planes, corners, least, normal = solids.planes, solids.corners, OUT_OF_REACH, (0.0, 1.0, 0.0)
    for k in range(solid.triangles[0], solid.triangles[0] + solid.triangles[1]):
        a, b, c, plane = _row_of_four(solids.triangles, k)
        up = (planes[plane, 0], planes[plane, 1], planes[plane, 2])
        gap = dot(up, local) - planes[plane, 3]
        if gap <= 0.0 or gap >= least:
            # It looks the other way, or its whole plane is farther.
            continue
        offset = minus(
            local, nearest_on_triangle(local, (row(corners, a), row(corners, b), row(corners, c)))
        )
        distance = length(offset)
        if distance < least:
            least, normal = distance, times(1.0 / distance, offset) if distance > TINY else up
    return least, normal


@inlined
def _row_of_four(numbers: IntArray, k: int) -> tuple[int, int, int, int]:
    return numbers[k, 0], numbers[k, 1], numbers[k, 2], numbers[k, 3]
