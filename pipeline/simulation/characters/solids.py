"""Solids: what stands and moves about characters in other rooms, for compiled loops.

A solid is a ball, or a convex polyhedron: planes, the triangles between its corners, and these.
It goes on within a step as fast as it was seen to go. Who pushes and is not pushed has no inverse
mass; what gives way is pushed as it is met, and what was pushed of it is told to its own room.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import MassError
from pipeline.simulation.characters.layout import Numbers, Structures
from pipeline.simulation.dynamics.compiled import Record, inlined
from pipeline.simulation.dynamics.hull import Hull, hull_of
from pipeline.simulation.dynamics.records import zeros
from pipeline.simulation.dynamics.vectors import (
    Vector,
    cross,
    dot,
    length,
    plus,
    rows_of,
    set_triple,
    times,
    triple,
    turned,
)
from pipeline.simulation.obstacles import directions, outermost
from pipeline.simulation.solid import Obstacle
from pipeline.simulation.spatial import Array

ROUND = 0.06
"""What a ball's corners may lack of its radius in any direction, as a part of it."""

SAGITTA = 2.5e-3
"""How far what is round reaches beyond its polyhedron, about [m]."""

LEAST, MOST = 24, 96
"""Directions in which corners are looked for."""

FRICTION = 0.6
"""Coulomb's coefficient of what has none of its own."""

SOLID = np.dtype(
    [
        # First and number of its planes, triangles and corners; none of a ball.
        ("planes", "i8", 2),
        ("triangles", "i8", 2),
        ("corners", "i8", 2),
        # Of a ball, 0 of what is none; how far it reaches from where it turns about [m].
        ("radius", "f8"),
        ("reach", "f8"),
        # In its own frame the middle and half the extent of the box around it [m].
        ("middle", "f8", 3),
        ("half", "f8", 3),
        # 0 of what is not pushed [1/kg]; in the world, likewise [1/(kg m²)].
        ("inverse_mass", "f8"),
        ("inverse_inertia", "f8", (3, 3)),
        ("friction", "f8"),
        ("bounciness", "f8"),
        # Where it is [m], how fast [m/s, rad/s]; what makes it fall if nothing bears it [m/s²].
        ("p", "f8", 3),
        ("R", "f8", (3, 3)),
        ("v", "f8", 3),
        ("w", "f8", 3),
        ("fall", "f8"),
        # What it was pushed by since it was seen [N s, N m s].
        ("push", "f8", 3),
        ("twist", "f8", 3),
        # Number of the thing that it is a part of; whether it is there.
        ("whole", "i8"),
        ("here", "?"),
        # The box around it in the world [m].
        ("low", "f8", 3),
        ("high", "f8", 3),
    ],
    align=True,
)
"""A solid of another room."""


class Solids(NamedTuple):
    """All solids that characters may run into.

    Attributes:
        bodies: (S,) `SOLID`.
        planes: (P, 4) outward normals and distances from the origin, in the solid's frame [m].
        triangles: (T, 4) corners, counter-clockwise from outside, and the plane they lie in.
        corners: (V, 3) in the solid's frame [m].
        near: (n, 2) room for characters and solids whose boxes overlap.
    """

    bodies: Structures
    planes: Array
    triangles: Numbers
    corners: Array
    near: Numbers


def solids_of(obstacles: Sequence[Obstacle], characters: int) -> tuple[Solids, list[int]]:
    """Return solids for so many characters, and which of the obstacles they are, in order.

    Those in whose corners there is no solid are left out.
    """
    shapes = [(k, shape) for k, one in enumerate(obstacles) if (shape := _shape(one)) is not None]
    bodies = zeros(len(shapes), SOLID)
    # Limbs of one creature are one thing; bricks of one wall are not.
    wholes = [one.performer if one.weight is None else one.name for one in obstacles]
    numbers = {name: n for n, name in enumerate(dict.fromkeys(wholes))}
    planes, triangles, corners = np.zeros((0, 4)), np.zeros((0, 4), np.int64), np.zeros((0, 3))
    for solid, (k, shape) in zip(bodies, shapes, strict=True):
        _describe(solid, obstacles[k], shape)
        solid["whole"] = numbers[wholes[k]]
        if isinstance(shape, Hull):
            solid["planes"] = len(planes), len(shape.normals)
            solid["triangles"] = len(triangles), len(shape.faces)
            solid["corners"] = len(corners), len(shape.vertices)
            own = np.column_stack([shape.faces + len(corners), _facets(shape) + len(planes)])
            planes = np.concatenate([planes, np.column_stack([shape.normals, shape.offsets])])
            triangles = np.concatenate([triangles, own.astype(np.int64)])
            corners = np.concatenate([corners, shape.vertices])
    near = np.zeros((characters * len(shapes), 2), dtype=np.int64)
    return Solids(bodies, planes, triangles, corners, near), [k for k, _ in shapes]


def no_solids() -> Solids:
    """Return what there is about characters that are alone."""
    return solids_of((), 0)[0]


Ball = tuple[Array, float]
"""Middle and radius [m]."""


def _shape(obstacle: Obstacle) -> Hull | Ball | None:
    corners = np.ascontiguousarray(obstacle.corners, dtype=float)
    return _shape_of(corners.tobytes())


@cache
def _shape_of(corners: bytes) -> Hull | Ball | None:
    """Return the shape of corners; creatures of one figure share theirs."""
    points = np.frombuffer(corners).reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    radius = float(np.linalg.norm(points - middle, axis=1).max())
    # The corners of a box are as far from its middle as one another, and its faces are not.
    reaches = ((points - middle)[:, None, :] * directions(MOST)).sum(axis=-1).max(axis=0)
    if float(reaches.min()) >= (1.0 - ROUND) * radius:
        # What is seen of a ball has corners a little outside and faces a little inside it.
        return middle, float(reaches.mean())
    # The middle one of three extents: what is long is as round as it is thick.
    radius = 0.5 * float(np.sort(high - low)[1])
    count = min(max(math.ceil(0.5 * math.pi * radius / SAGITTA), LEAST), MOST)
    try:
        return hull_of(outermost(points, count) if len(points) > count else points)
    except MassError:
        return None


def _describe(solid: Record, obstacle: Obstacle, shape: Hull | Ball) -> None:
    if isinstance(shape, Hull):
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        solid["middle"], solid["half"] = 0.5 * (low + high), 0.5 * (high - low)
        solid["reach"] = float(np.linalg.norm(shape.vertices, axis=1).max())
    else:
        solid["middle"], solid["radius"] = shape
        solid["half"] = shape[1]
        solid["reach"] = float(np.linalg.norm(shape[0])) + shape[1]
    weight = obstacle.weight
    solid["friction"] = FRICTION if weight is None else weight.friction
    solid["bounciness"] = 0.0 if weight is None else weight.bounciness
    solid["inverse_mass"] = 0.0 if weight is None else 1.0 / weight.mass


def _facets(hull: Hull) -> NDArray[np.int64]:
    """Return the facet (F,) that each triangle lies in: the one whose normal is most its own."""
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    alike = (normals[:, None, :] * hull.normals).sum(axis=-1)
    result: NDArray[np.int64] = np.argmax(alike, axis=1)
    return result


# --- in compiled code -------------------------------------------------------------------


@inlined
def go_on(solid: Record, h: float) -> None:
    """Let a solid go on by a sub-step `h` [s] as fast as it goes."""
    if not solid.here:
        return
    solid.v[1] -= solid.fall * h
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
        solid.push[k] += impulse[k]
        solid.twist[k] += twist[k]
        solid.v[k] += solid.inverse_mass * impulse[k]
        solid.w[k] += spin[k]
        solid.p[k] += h * solid.inverse_mass * impulse[k]
