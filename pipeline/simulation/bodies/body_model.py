"""Body models: mass, hull and contact properties of a body from its configuration.

A new shape is a model in `pipeline/spec/body.py`, a function here and a line in `HULL_POINTS`.

Source: Sims 1987, 7.1.1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.errors import MassError, Problem, SceneError
from pipeline.foreign_files.safe_file import BODY_MESH
from pipeline.simulation.dynamics.hull import Hull, hull_of
from pipeline.simulation.dynamics.mass import MassProperties, mass_of_solid
from pipeline.simulation.dynamics.rigid_body import BodyModel
from pipeline.simulation.mesh_file import MeshError, mesh_vertices
from pipeline.simulation.spatial import Array
from pipeline.spec.body import (
    Box,
    Brick,
    Cube,
    HullBody,
    Matter,
    MeshBody,
    Regular,
    Sphere,
    Upright,
)
from pipeline.spec.model_base import WORLD_LIMIT

GOLDEN_RATIO = (1.0 + 5.0**0.5) / 2.0

CUBE_CORNERS: Array = np.array(list(product((-1.0, 1.0), repeat=3)))

MAX_VERTICES = 2**20
"""Vertices of a mesh whose hull is a body."""

MAX_CORNERS = 5000
"""Corners of the hull of a mesh: the time that it takes grows with their square."""


def _box_points(config: Box | Brick) -> Array:
    return CUBE_CORNERS * (0.5 * np.array(config.size))


def _cube_points(config: Cube) -> Array:
    return CUBE_CORNERS * (0.5 * config.size)


def _regular_points(config: Regular) -> Array:
    match config.shape:
        case "tetrahedron":
            corners = CUBE_CORNERS[CUBE_CORNERS.prod(axis=1) > 0.0]
        case "octahedron":
            corners = np.concatenate([np.eye(3), -np.eye(3)])
        case "icosahedron":
            corners = _golden_points(1.0, GOLDEN_RATIO)
        case "dodecahedron":
            corners = np.concatenate(
                [CUBE_CORNERS, _golden_points(1.0 / GOLDEN_RATIO, GOLDEN_RATIO)]
            )
    radius = np.sqrt((corners[0] ** 2).sum())
    return corners * (0.5 * config.size / radius)


def _golden_points(a: float, b: float) -> Array:
    """Returns the 12 points (0, ±a, ±b) and their cyclic permutations."""
    signs = np.array(list(product((-1.0, 1.0), repeat=2)))
    flat = np.column_stack([np.zeros(4), signs * (a, b)])
    return np.concatenate([np.roll(flat, k, axis=1) for k in range(3)])


def _upright_points(config: Upright) -> Array:
    """Returns the corners of a prism or a pyramid."""
    angle = (np.arange(config.sides) + 0.5) * (2.0 * np.pi / config.sides)
    ring = np.column_stack([np.sin(angle), np.zeros(config.sides), np.cos(angle)]) * config.radius
    top = np.array([0.0, config.height, 0.0])
    return np.concatenate([ring, ring + top if config.shape == "prism" else top[None]])


def _given_points(config: HullBody) -> Array:
    return np.array(config.points)


def _mesh_points(config: MeshBody) -> Array:
    """Returns the vertices of a mesh file.

    Raises:
        MeshError: if the file is not a readable mesh.
    """
    vertices = mesh_vertices(Path(config.file), BODY_MESH, MAX_VERTICES)
    if np.abs(vertices).max(initial=0.0) > WORLD_LIMIT / config.scale:
        raise MeshError(f"reaches farther than {WORLD_LIMIT:g} m; is its scale right?")
    vertices *= config.scale
    return _few_points(np.unique(vertices, axis=0))


def _few_points(points: Array) -> Array:
    """Returns points (n, 3) that have the same hull, at most `MAX_CORNERS`.

    Raises:
        MeshError: if the hull has more corners.
    """
    if len(points) <= MAX_CORNERS:
        return points
    # Only large meshes wait for it.
    from scipy.spatial import ConvexHull, QhullError

    try:
        corners = np.sort(ConvexHull(points).vertices)
    except QhullError:
        raise MeshError("lies in one plane, which encloses no volume") from None
    if len(corners) > MAX_CORNERS:
        limit = f"{len(corners)} corners, more than {MAX_CORNERS}"
        raise MeshError(f"has a hull of {limit}; make it simpler")
    return points[corners]


HULL_POINTS: dict[type[Any], Callable[[Any], Array]] = {
    Box: _box_points,
    Brick: _box_points,
    Cube: _cube_points,
    Regular: _regular_points,
    Upright: _upright_points,
    HullBody: _given_points,
    MeshBody: _mesh_points,
}


def body_hull(config: Any, path: str) -> Hull:
    """Returns the hull of a body that is not a ball.

    Args:
        config: of the body.
        path: its path in the scene.

    Raises:
        SceneError: if its points or its file are no solid.
    """
    where = {"hull": ".points", "mesh": ".file"}.get(config.shape, "")
    name = f"'{Path(config.file).name}' " if isinstance(config, MeshBody) else ""
    try:
        return hull_of(HULL_POINTS[type(config)](config))
    except MeshError as error:
        message = f"{name}{error}"
    except MassError as error:
        message = f"{name}is no solid: {error}"
    raise SceneError([Problem(path + where, message)])


def build_body(config: Any, path: str) -> BodyModel:
    """Returns the model of a body.

    Args:
        config: of the body.
        path: its path in the scene.

    Raises:
        SceneError: if its shape is no solid.
    """
    if isinstance(config, Sphere):
        mass = config.density * 4.0 / 3.0 * math.pi * config.radius**3
        moment = 0.4 * mass * config.radius**2
        own, hull, radius = (
            MassProperties(mass, np.zeros(3), moment * np.eye(3)),
            None,
            config.radius,
        )
    else:
        hull = body_hull(config, path)
        own, radius = mass_of_solid(hull.vertices, hull.faces, config.density), 0.0
        hull = replace(hull, vertices=hull.vertices - own.centre)
    return model_of_matter(config, own, hull, radius)


def model_of_matter(
    config: Matter, own: MassProperties, hull: Hull | None, radius: float
) -> BodyModel:
    """Returns the model of a body of some matter, its hull about its centre of mass."""
    if config.inertia == "scalar":
        own = _isotropic(own)
    return BodyModel(
        mass=own,
        hull=hull,
        radius=radius,
        bounciness=config.bounciness,
        friction=config.friction,
        rolling=config.rolling if config.friction > 0.0 else 0.0,
        soft=config.soft,
    )


def _isotropic(mass: MassProperties) -> MassProperties:
    """Returns mass properties with the mean moment of inertia about every axis.

    Source: Sims 1987, 7.1.1: "approximated to be a constant, independent of the axis". A moment
    computed anew for the axis of each torque, as in (7.10), gives a body more energy than was put
    in.
    """
    return replace(mass, inertia=np.trace(mass.inertia) / 3.0 * np.eye(3))
