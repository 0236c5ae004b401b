"""Polyhedra: the words of a body -> the hull that it is.

A new shape is a model in `pipeline/spec/body.py`, a function here and a line in `POINTS`.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.errors import MassError, Problem, SceneError
from pipeline.simulation.dynamics.hull import Hull, hull_of
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain.height_files import MeshError, obj_vertices, ply_vertices
from pipeline.spec.body import Box, Brick, Cube, HullBody, MeshBody, Regular, Upright
from pipeline.spec.model_base import WORLD_LIMIT

GOLDEN = (1.0 + 5.0**0.5) / 2.0

CORNERS: Array = np.array(list(product((-1.0, 1.0), repeat=3)))

READERS = {".obj": obj_vertices, ".ply": ply_vertices}

MOST_BYTES = 2**28


def box(words: Box | Brick) -> Array:
    """Return the corners of a box."""
    return CORNERS * (0.5 * np.array(words.size))


def cube(words: Cube) -> Array:
    """Return the corners of a cube."""
    return CORNERS * (0.5 * words.size)


def regular(words: Regular) -> Array:
    """Return the corners of a regular solid."""
    match words.shape:
        case "tetrahedron":
            corners = CORNERS[CORNERS.prod(axis=1) > 0.0]
        case "octahedron":
            corners = np.concatenate([np.eye(3), -np.eye(3)])
        case "icosahedron":
            corners = _golden(1.0, GOLDEN)
        case "dodecahedron":
            corners = np.concatenate([CORNERS, _golden(1.0 / GOLDEN, GOLDEN)])
    radius = np.sqrt((corners[0] ** 2).sum())
    result: Array = corners * (0.5 * words.size / radius)
    return result


def _golden(a: float, b: float) -> Array:
    """Return the 12 points (0, ±a, ±b) and those with their coordinates moved on."""
    signs = np.array(list(product((-1.0, 1.0), repeat=2)))
    flat = np.column_stack([np.zeros(4), signs * (a, b)])
    return np.concatenate([np.roll(flat, k, axis=1) for k in range(3)])


def upright(words: Upright) -> Array:
    """Return the corners of a prism or a pyramid."""
    angle = (np.arange(words.sides) + 0.5) * (2.0 * np.pi / words.sides)
    ring = np.column_stack([np.sin(angle), np.zeros(words.sides), np.cos(angle)]) * words.radius
    top = np.array([0.0, words.height, 0.0])
    return np.concatenate([ring, ring + top if words.shape == "prism" else top[None]])


def points(words: HullBody) -> Array:
    """Return the points that the author gave."""
    return np.array(words.points)


def mesh(words: MeshBody) -> Array:
    """Return the vertices of a mesh file.

    Raises:
        NotRead: the file is no mesh that can be read.
    """
    path = Path(words.file)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshError("it should end in .obj or .ply")
    try:
        if path.stat().st_size > MOST_BYTES:
            raise MeshError(f"it is larger than {MOST_BYTES // 2**20} MiB")
        vertices = words.scale * reader(path.read_bytes())
    except OSError as error:
        raise MeshError(f"{error.strerror}") from None
    if not np.isfinite(vertices).all() or np.abs(vertices).max() > WORLD_LIMIT:
        raise MeshError(f"it reaches farther than {WORLD_LIMIT:g} m; is its scale right?")
    return np.unique(vertices, axis=0)


POINTS: dict[type[Any], Callable[[Any], Array]] = {
    Box: box,
    Brick: box,
    Cube: cube,
    Regular: regular,
    Upright: upright,
    HullBody: points,
    MeshBody: mesh,
}


def hull_of_words(words: Any, path: str) -> Hull:
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
        return hull_of(POINTS[type(words)](words))
    except MeshError as error:
        message = f"{name}cannot be read: {error}"
    except MassError as error:
        message = f"{name}is no solid: {error}"
    raise SceneError([Problem(path + where, message)])
