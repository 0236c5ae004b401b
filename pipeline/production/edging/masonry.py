"""Masonry: stones of dry walls, and paper lanterns, as shapes to be copied."""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.prototype import (
    Prototype,
    Shape,
    add_rings,
    mixed,
    turned_rings,
    unit,
)
from pipeline.production.scenery.stones import rough, surface_normals
from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array

SQUARENESS = 9.0
"""Exponent of the superquadric of a stone: 2 is a sphere, infinite a box."""

GREY, BROWN, LICHEN = (0.27, 0.258, 0.236), (0.235, 0.206, 0.165), (0.22, 0.235, 0.145)

JOINT = 0.7
"""By how much a stone is darker at its edges, where it meets others."""


@cache
def gridded_cube(across: int) -> tuple[Array, NDArray[np.int64]]:
    """Return vertices (V, 3), -1 to 1, and faces (F, 3) of a cube of 12 `across`² triangles."""
    t = np.linspace(-1.0, 1.0, across + 1)
    u, v = (a.ravel() for a in np.meshgrid(t, t))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(across), np.arange(across)))
    a = j * (across + 1) + i
    quads = np.stack([a, a + 1, a + across + 2, a, a + across + 2, a + across + 1], axis=-1)
    points: list[Array] = []
    faces: list[NDArray[np.int64]] = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            points.append(np.roll(np.stack([np.full_like(u, side), u, v], axis=-1), axis, axis=1))
            turned = quads if side > 0 else quads[:, ::-1]
            faces.append(turned.reshape(-1, 3) + len(u) * len(faces))
    every: Array = np.round(np.concatenate(points), 9).astype(np.float64)
    vertices, number = np.unique(every, axis=0, return_inverse=True)
    return vertices, np.asarray(number.ravel()[np.concatenate(faces)], np.int64)


@lru_cache(maxsize=64)
def wall_stone(seed: int, across: int) -> Prototype:
    """Return a rough-hewn stone of unit length, height and depth around the origin.

    Args:
        seed: of its shape.
        across: edges of its triangles along each side.
    """
    rng = np.random.default_rng([seed, 431])
    vertices, faces = gridded_cube(across)
    radius = (np.abs(vertices) ** SQUARENESS).sum(axis=1) ** (-1.0 / SQUARENESS)
    vertices = 0.5 * vertices * radius[:, None]
    for _ in range(7):
        normal = unit(rng.normal(size=3))
        beyond = vertices @ normal - rng.uniform(0.5, 0.66)
        vertices = vertices - np.maximum(beyond, 0.0)[:, None] * normal
    vertices = vertices * (1.0 + 0.06 * rough(4.0 * vertices, seed, 4))[:, None]
    normals = surface_normals(vertices, faces)
    base = mixed(GREY, BROWN, np.full(len(vertices), rng.uniform(0.0, 1.0)))
    color = base * (1.0 + 0.35 * rough(5.0 * vertices, seed + 5))[:, None]
    growth = smoothstep(0.1, 0.5, rough(3.0 * vertices, seed + 9)) * smoothstep(
        0.1, 0.7, normals[:, 1]
    )
    color = mixed(color, LICHEN, 0.7 * growth)
    # Soil and shade in the joints: without them a wall in the shade is one dark mass.
    rim = np.sort(np.abs(vertices), axis=1)[:, 1]
    color = color * (1.0 - JOINT * smoothstep(0.24, 0.46, rim))[:, None]
    shape = Shape()
    # Broken faces have edges: each is shaded as it lies.
    corners = vertices[faces]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    mixed_normals = 0.6 * unit(facing)[:, None] + 0.4 * normals[faces]
    numbers = np.arange(3 * len(faces)).reshape(-1, 3)
    shape.add(corners, mixed_normals, color[faces], numbers, thin=False)
    return shape.prototype()


GAPS, LANTERN_SIDES = 9, 20
"""Gaps between the hoops of wire in a paper lantern, and its sides."""


@lru_cache(maxsize=1)
def lantern() -> Prototype:
    """Return a white paper lantern of unit width around the origin, between caps of wood."""
    up = np.linspace(-0.46, 0.46, 4 * GAPS + 1)[:, None]
    sag = np.abs(np.sin(np.pi * GAPS * (up / 0.92 + 0.5)))
    around = np.linspace(0.0, 2.0 * np.pi, LANTERN_SIDES, endpoint=False)
    # Paper sags inward between the hoops, and is darker where it is folded over them.
    radius = np.sqrt(0.25 - up * up) * (1.0 - 0.05 * sag)
    shade = (0.55 + 0.35 * smoothstep(0.1, 0.6, sag)) * (0.8 + 0.2 * smoothstep(-0.5, 0.3, up))
    shape = Shape()
    add_rings(shape, turned_rings(radius, up, around), shade[..., None] * np.ones(3), thin=True)
    for level in (-0.47, 0.47):
        wood = np.array([0.12, 0.09, 0.06])
        rim = np.array([[-0.045], [0.045]])
        add_rings(shape, turned_rings(np.full((2, 1), 0.2), level + rim, around), wood)
        # Its outer face; the other lies within the paper.
        outward = 0.045 if level > 0.0 else -0.045
        disc = turned_rings(np.array([[0.002], [0.2]]), np.full((2, 1), level + outward), around)
        add_rings(shape, disc[:: 1 if level > 0.0 else -1], wood, upward=True)
    return shape.prototype()
