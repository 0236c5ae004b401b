"""Solid arrays: the solids of other rooms that characters may run into.

A solid is a ball, or a convex polyhedron: planes, the triangles between its corners, and these.
It moves on within a step at its velocity. A fixed solid pushes and has no inverse mass; a movable
one is pushed where it is met, and the impulses are reported to its own room.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import MassError
from pipeline.simulation.characters.body_arrays import IntArray, RecordArray
from pipeline.simulation.dynamics.compiled import Record
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.hull import Hull, hull_of
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.obstacles import Obstacle, SolidMotion, directions, outermost
from pipeline.simulation.spatial import Array

ROUNDNESS_TOLERANCE = 0.06  # of a ball's radius in any direction
SAGITTA = 2.5e-3  # by which a round solid may reach beyond its polyhedron, about [m]
MIN_DIRECTIONS, MAX_DIRECTIONS = 24, 96  # in which corners are looked for
DEFAULT_FRICTION = 0.6  # Coulomb's coefficient of solids that have none

SOLID = np.dtype(
    [
        # First and number of its planes, triangles and corners; none of a ball.
        ("planes", "i8", 2),
        ("triangles", "i8", 2),
        ("corners", "i8", 2),
        # Of a ball, else 0; farthest reach from the origin [m].
        ("radius", "f8"),
        ("reach", "f8"),
        # Middle and half extents of its bounding box in its own frame [m].
        ("middle", "f8", 3),
        ("half", "f8", 3),
        # 0 of a fixed solid [1/kg]; likewise in the world [1/(kg m²)].
        ("inverse_mass", "f8"),
        ("inverse_inertia", "f8", (3, 3)),
        ("friction", "f8"),
        ("bounciness", "f8"),
        # Pose [m], velocities [m/s], [rad/s]; acceleration where nothing bears it [m/s²].
        ("p", "f8", 3),
        ("R", "f8", (3, 3)),
        ("v", "f8", 3),
        ("w", "f8", 3),
        ("fall_acceleration", "f8"),
        # Impulses since the start of the step [N s], [N m s].
        ("impulse", "f8", 3),
        ("angular_impulse", "f8", 3),
        # Number of the thing that it is a part of; whether it is there.
        ("thing", "i8"),
        ("is_present", "?"),
        # Bounding box in the world [m].
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
        triangles: (T, 4) corners, counter-clockwise from outside, and their plane.
        corners: (V, 3) in the solid's frame [m].
        near: (n, 2) buffer for characters and solids with overlapping bounds.
    """

    bodies: RecordArray
    planes: Array
    triangles: IntArray
    corners: Array
    near: IntArray


def solids_of(obstacles: Sequence[Obstacle], characters: int) -> tuple[Solids, list[int]]:
    """Return the solids for a number of characters, and the indices of their obstacles.

    Obstacles without volume are left out.
    """
    shapes = [
        (k, shape)
        for k, obstacle in enumerate(obstacles)
        if (shape := _shape(obstacle)) is not None
    ]
    bodies = zero_records(len(shapes), SOLID)
    # Limbs of one creature are one thing; bricks of one wall are not.
    things = [
        obstacle.performer if obstacle.mass_properties is None else obstacle.name
        for obstacle in obstacles
    ]
    numbers = {name: n for n, name in enumerate(dict.fromkeys(things))}
    planes, triangles, corners = np.zeros((0, 4)), np.zeros((0, 4), np.int64), np.zeros((0, 3))
    for solid, (k, shape) in zip(bodies, shapes, strict=True):
        _describe(solid, obstacles[k], shape)
        solid["thing"] = numbers[things[k]]
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
    """Return the surroundings of characters that are alone."""
    return solids_of((), 0)[0]


Ball = tuple[Array, float]
"""Middle and radius [m]."""


def _shape(obstacle: Obstacle) -> Hull | Ball | None:
    return _shape_of(np.ascontiguousarray(obstacle.corners, dtype=float).tobytes())


@cache
def _shape_of(corners: bytes) -> Hull | Ball | None:
    """Return the shape of corners, cached for creatures of one figure."""
    points = np.frombuffer(corners).reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    radius = float(np.linalg.norm(points - middle, axis=1).max())
    # The corners of a box are as far from its middle as one another, and its faces are not.
    reaches = ((points - middle)[:, None, :] * directions(MAX_DIRECTIONS)).sum(axis=-1).max(axis=0)
    if float(reaches.min()) >= (1.0 - ROUNDNESS_TOLERANCE) * radius:
        # The mesh of a ball has corners a little outside and faces a little inside of it.
        return middle, float(reaches.mean())
    # The middle one of three extents: a long solid is as round as it is thick.
    radius = 0.5 * float(np.sort(high - low)[1])
    count = min(max(math.ceil(0.5 * math.pi * radius / SAGITTA), MIN_DIRECTIONS), MAX_DIRECTIONS)
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
    properties = obstacle.mass_properties
    solid["friction"] = DEFAULT_FRICTION if properties is None else properties.friction
    solid["bounciness"] = 0.0 if properties is None else properties.bounciness
    solid["inverse_mass"] = 0.0 if properties is None else 1.0 / properties.mass


def _facets(hull: Hull) -> NDArray[np.int64]:
    """Return the facet (F,) of each triangle, the one with the most similar normal."""
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    similarity = (np.cross(b - a, c - a)[:, None, :] * hull.normals).sum(axis=-1)
    return np.argmax(similarity, axis=1)


class SolidTracker:
    """The solids of other rooms around the characters, step by step.

    Attributes:
        obstacles: those with a volume, in their order.
        solids: as compiled loops know them.
    """

    def __init__(self, obstacles: Sequence[Obstacle] = (), characters: int = 0) -> None:
        self.solids: Solids
        self.solids, indices = solids_of(obstacles, characters)
        self.obstacles = [obstacles[k] for k in indices]
        inverse = [
            np.zeros((3, 3))
            if (properties := obstacle.mass_properties) is None
            else properties.inverse_inertia
            for obstacle in self.obstacles
        ]
        self._inverse = np.array(inverse).reshape(-1, 3, 3)
        self._inverse_masses = self.solids.bodies["inverse_mass"].copy()
        self._enclosing: NDArray[np.bool_] | None = None
        self._movable = np.array(
            [obstacle.mass_properties is not None for obstacle in self.obstacles], dtype=bool
        )

    @cached_property
    def thing_numbers(self) -> dict[str, int]:
        """Numbers of the things of solids by the names of their members."""
        return {
            name: int(solid["thing"])
            for obstacle, solid in zip(self.obstacles, self.solids.bodies, strict=True)
            for name in (obstacle.performer, obstacle.name)
        }

    def masses(self) -> dict[str, float]:
        """Return the masses of movable solids by the names of their members [kg]."""
        return {
            name: obstacle.mass_properties.mass
            for obstacle in self.obstacles
            if obstacle.mass_properties is not None
            for name in (obstacle.performer, obstacle.name)
        }

    def set_velocity(self, name: str, v: Array) -> None:
        """Give a movable member a velocity (3,) by an impulse at its centre [m/s].

        What has touched it before, such as the foot that kicks it, adds nothing.
        """
        for obstacle, solid in zip(self.obstacles, self.solids.bodies, strict=True):
            if name in (obstacle.performer, obstacle.name) and solid["inverse_mass"] > 0.0:
                solid["impulse"] += (v - solid["v"]) / solid["inverse_mass"]
                solid["v"] = v

    def update(
        self, motion: SolidMotion, characters: Sequence[Array], held: Collection[str] = ()
    ) -> None:
        """Update poses and velocities of the solids, and clear their impulses.

        Args:
            motion: of the solids.
            characters: (n, 3) nodes of each [m].
            held: names of members in hands, which nobody meets.
        """
        bodies = self.solids.bodies
        bodies["p"], bodies["R"] = motion.p, motion.R
        if self._enclosing is None:
            # A room or a sky: characters that start all inside a solid do not meet it.
            inside = [any(self._encloses(solid, p) for p in characters) for solid in bodies]
            self._enclosing = np.array(inside, dtype=bool)
        bodies["is_present"] = motion.is_present & np.logical_not(self._enclosing)
        if held:
            is_held = [{o.performer, o.name} & set(held) != set() for o in self.obstacles]
            bodies["is_present"] &= ~np.array(is_held, dtype=bool)
        bodies["v"], bodies["w"] = motion.v, motion.w
        R = motion.R
        bodies["inverse_inertia"] = R @ self._inverse @ np.swapaxes(R, -1, -2)
        bodies["inverse_inertia"][~motion.gives_way] = 0.0
        bodies["inverse_mass"] = np.where(motion.gives_way, self._inverse_masses, 0.0)
        bodies["fall_acceleration"] = np.where(self._movable & ~motion.is_supported, GRAVITY, 0.0)
        bodies["impulse"] = bodies["angular_impulse"] = 0.0

    def impulses(self) -> tuple[Array, Array]:
        """Return the impulses (S, 3) [N s] and angular impulses (S, 3) of this step [N m s]."""
        bodies = self.solids.bodies
        return bodies["impulse"].copy(), bodies["angular_impulse"].copy()

    def _encloses(self, solid: Record, p: Array) -> bool:
        """Tell whether all of p (n, 3) lie in a solid."""
        local = (p - solid["p"]) @ solid["R"]
        if solid["radius"] > 0.0:
            offset = local - solid["middle"]
            return bool((np.sqrt((offset * offset).sum(axis=1)) < solid["radius"]).all())
        first, count = solid["planes"]
        planes = self.solids.planes[first : first + count]
        return bool(((local[:, None, :] * planes[:, :3]).sum(axis=-1) < planes[:, 3]).all())
