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
from pipeline.simulation.bodies.body_meshes import PIP_MATERIAL, bevelled, pips
from pipeline.simulation.dynamics.hull import Hull, hull_of
from pipeline.simulation.dynamics.mass import MassProperties, mass_of_solid
from pipeline.simulation.dynamics.rigid_body import BodyModel
from pipeline.simulation.figures.solids import Solid, ball_solid
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh
from pipeline.simulation.terrain.height_files import MeshError, obj_vertices, ply_vertices
from pipeline.spec.body import Box, Brick, Cube, HullBody, MeshBody, Regular, Sphere, Upright
from pipeline.spec.model_base import WORLD_LIMIT

GOLDEN_RATIO = (1.0 + 5.0**0.5) / 2.0

CUBE_CORNERS: Array = np.array(list(product((-1.0, 1.0), repeat=3)))

MESH_READERS = {".obj": obj_vertices, ".ply": ply_vertices}

MAX_FILE_BYTES = 2**28


def _box_points(words: Box | Brick) -> Array:
    """Return the corners of a box."""
    return CUBE_CORNERS * (0.5 * np.array(words.size))


def _cube_points(words: Cube) -> Array:
    """Return the corners of a cube."""
    return CUBE_CORNERS * (0.5 * words.size)


def _regular_points(words: Regular) -> Array:
    """Return the corners of a regular solid."""
    match words.shape:
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
    result: Array = corners * (0.5 * words.size / radius)
    return result


def _golden_points(a: float, b: float) -> Array:
    """Return the 12 points (0, ±a, ±b) and those with their coordinates moved on."""
    signs = np.array(list(product((-1.0, 1.0), repeat=2)))
    flat = np.column_stack([np.zeros(4), signs * (a, b)])
    return np.concatenate([np.roll(flat, k, axis=1) for k in range(3)])


def _upright_points(words: Upright) -> Array:
    """Return the corners of a prism or a pyramid."""
    angle = (np.arange(words.sides) + 0.5) * (2.0 * np.pi / words.sides)
    ring = np.column_stack([np.sin(angle), np.zeros(words.sides), np.cos(angle)]) * words.radius
    top = np.array([0.0, words.height, 0.0])
    return np.concatenate([ring, ring + top if words.shape == "prism" else top[None]])


def _given_points(words: HullBody) -> Array:
    """Return the points that the author gave."""
    return np.array(words.points)


def _mesh_points(words: MeshBody) -> Array:
    """Return the vertices of a mesh file.

    Raises:
        NotRead: the file is no mesh that can be read.
    """
    path = Path(words.file)
    reader = MESH_READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshError("it should end in .obj or .ply")
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise MeshError(f"it is larger than {MAX_FILE_BYTES // 2**20} MiB")
        vertices = words.scale * reader(path.read_bytes())
    except OSError as error:
        raise MeshError(f"{error.strerror}") from None
    if not np.isfinite(vertices).all() or np.abs(vertices).max() > WORLD_LIMIT:
        raise MeshError(f"it reaches farther than {WORLD_LIMIT:g} m; is its scale right?")
    return np.unique(vertices, axis=0)


HULL_POINTS: dict[type[Any], Callable[[Any], Array]] = {
    Box: _box_points,
    Brick: _box_points,
    Cube: _cube_points,
    Regular: _regular_points,
    Upright: _upright_points,
    HullBody: _given_points,
    MeshBody: _mesh_points,
}


def body_hull(words: Any, path: str) -> Hull:
    """Return the hull of a body that is no ball.

    Args:
        words: of the body.
        path: where they stand in the scene.

    Raises:
        SceneError: its points or its file make no solid.
    """
    where = {"hull": ".points", "mesh": ".file"}.get(words.shape, "")
    name = f"'{Path(words.file).name}' " if isinstance(words, MeshBody) else ""
    try:
        return hull_of(HULL_POINTS[type(words)](words))
    except MeshError as error:
        message = f"{name}cannot be read: {error}"
    except MassError as error:
        message = f"{name}is no solid: {error}"
    raise SceneError([Problem(path + where, message)])


def build_body(words: Any, path: str) -> BodyModel:
    """Return a body as it is built.

    Args:
        words: of the body.
        path: where they stand in the scene.

    Raises:
        SceneError: its shape is no solid.
    """
    if isinstance(words, Sphere):
        mass = words.density * 4.0 / 3.0 * math.pi * words.radius**3
        moment = 0.4 * mass * words.radius**2
        own, hull, radius = (
            MassProperties(mass, np.zeros(3), moment * np.eye(3)),
            None,
            words.radius,
        )
    else:
        hull = body_hull(words, path)
        own, radius = mass_of_solid(hull.vertices, hull.faces, words.density), 0.0
        hull = replace(hull, vertices=hull.vertices - own.centre)
    if words.inertia == "scalar":
        own = _isotropic(own)
    return BodyModel(
        mass=own,
        hull=hull,
        radius=radius,
        bounciness=words.bounciness,
        friction=words.friction,
        rolling=words.rolling if words.friction > 0.0 else 0.0,
        soft=words.soft,
    )


def _isotropic(mass: MassProperties) -> MassProperties:
    """Return mass properties with the mean moment of inertia about every axis.

    Source: Sims 1987, 7.1.1: "approximated to be a constant, independent of the axis". A
    moment that is taken anew for each torque's axis, as in (7.10), gives a body more energy
    than it was given.
    """
    return replace(mass, inertia=np.trace(mass.inertia) / 3.0 * np.eye(3))


def seen_of(words: Any, build: BodyModel, material: str) -> list[tuple[str, Solid, str]]:
    """Return what is seen of a body: names after its own, solids and materials."""
    if build.hull is None:
        return [("", ball_solid(np.zeros(3), build.radius), material)]
    seen = [("", bevelled(build.hull), material)]
    if words.shape == "die":
        seen.append((".pips", pips(words.size), PIP_MATERIAL))
    return seen


def mesh_of(solid: Solid, node: int) -> Mesh:
    """Return the mesh of a solid that follows one node."""
    count = len(solid.vertices)
    return Mesh(
        solid.vertices.astype(np.float32),
        solid.faces,
        np.full((count, 2), node, dtype=np.int32),
        np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1)),
    )
