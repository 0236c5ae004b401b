"""Masonry and hedges: stones of dry walls and lengths of clipped hedge, as shapes to be copied."""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.prototype import (
    UP,
    Prototype,
    Shape,
    add_leaves,
    mixed,
    random_directions,
    unit,
)
from pipeline.production.scenery.stones import icosphere, rough, surface_normals
from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array

SQUARENESS = 9.0
"""Exponent of the superquadric of a stone: 2 is a sphere, infinite a box."""

GREY, BROWN, LICHEN = (0.23, 0.222, 0.205), (0.20, 0.178, 0.145), (0.20, 0.215, 0.13)

LEAF, YOUNG, WOOD = (0.075, 0.118, 0.032), (0.170, 0.235, 0.065), (0.058, 0.085, 0.028)

HEDGE_LENGTH, HEDGE_HEIGHT, HEDGE_DEPTH = 1.0, 1.0, 0.62
"""Of one length of hedge at scale 1 [m]."""

HEDGE_LEAVES = ((1500, 0.055), (820, 0.085), (420, 0.15))
"""Number and length [m] of the leaves by level of detail."""


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
    shape = Shape()
    # Broken faces have edges: each is shaded as it lies.
    corners = vertices[faces]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    mixed_normals = 0.6 * unit(facing)[:, None] + 0.4 * normals[faces]
    numbers = np.arange(3 * len(faces)).reshape(-1, 3)
    shape.add(corners, mixed_normals, color[faces], numbers, thin=False)
    return shape.prototype()


@lru_cache(maxsize=16)
def hedge_length(seed: int, level: int) -> Prototype:
    """Return a length of hedge, clipped some weeks ago, along x from its middle."""
    rng, shape = np.random.default_rng([seed, 433, level]), Shape()
    count, size = HEDGE_LEAVES[min(level, len(HEDGE_LEAVES) - 1)]
    half = 0.5 * np.array([HEDGE_LENGTH, HEDGE_HEIGHT, HEDGE_DEPTH])
    # A dark body, through which nobody sees.
    vertices, faces = icosphere(1)
    body = np.sign(vertices) * np.abs(vertices) ** 0.22 * half * [1.06, 0.9, 0.8]
    shape.add(body + half[1] * UP, vertices, np.asarray(WOOD), faces, thin=False)
    side = rng.choice(3, count, p=[0.36, 0.32, 0.32])
    place = rng.uniform(-1.0, 1.0, (count, 3))
    place[side == 0, 1] = 1.0
    place[side == 1, 2] = 1.0
    place[side == 2, 2] = -1.0
    out = np.zeros((count, 3))
    out[side == 0, 1] = 1.0
    out[side == 1, 2] = 1.0
    out[side == 2, 2] = -1.0
    # Shoulders are round, the foot is narrower, and shoots stand out.
    shoulder = np.abs(place[:, 1:]).min(axis=1, keepdims=True) ** 6
    place[:, 1:] *= 1.0 - 0.12 * shoulder
    place[:, 2] *= 0.86 + 0.14 * smoothstep(-1.0, 0.0, place[:, 1])
    depth = rng.uniform(-0.16, 0.05, (count, 1)) + 0.1 * (rng.uniform(size=(count, 1)) < 0.06)
    uneven = 0.05 * rough(1.7 * place * half + 10.0 * seed, seed, 2)[:, None]
    base = place * half + (depth + uneven) * out + [0.0, half[1], 0.0]
    way = 0.7 * out + 0.75 * random_directions(rng, count) + [0.0, 0.25, 0.0]
    lit = smoothstep(-0.15, 0.06, depth[:, 0]) * (0.55 + 0.45 * (place[:, 1] * 0.5 + 0.5))
    color = mixed(LEAF, YOUNG, lit) * rng.uniform(0.75, 1.25, (count, 1))
    normals: Array = unit(out + 0.55 * random_directions(rng, count) + [0.0, 0.2, 0.0])
    lengths = size * rng.uniform(0.7, 1.2, count)
    face = 0.6 * out + random_directions(rng, count)
    add_leaves(
        *(shape, base, way, face, lengths, 0.55 * lengths, color, normals),
        triangles=2 if level == 0 else 1,
    )
    return shape.prototype()


@lru_cache(maxsize=1)
def lantern() -> Prototype:
    """Return a white paper lantern of unit width around the origin."""
    vertices, faces = icosphere(3)
    # Wires inside show as darker lines.
    wire = np.exp(-((np.sin(7.0 * np.pi * vertices[:, 1:2]) / 0.3) ** 2))
    shape = Shape()
    shape.add(0.5 * vertices, vertices, 0.9 - 0.25 * wire * np.ones(3), faces, thin=True)
    return shape.prototype()
