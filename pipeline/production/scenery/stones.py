"""Stones: spheres that are cut by planes and roughened by noise."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from pipeline.production.scenery.prototype import Color, Prototype, Shape, mixed, unit
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array

GREY: Color = (0.262, 0.246, 0.218)
LICHEN: Color = (0.19, 0.2, 0.105)

KINDS: tuple[tuple[float, Color, float], ...] = (
    (1.0, (1.0, 1.0, 1.0), 0.05),
    (0.72, (0.78, 0.75, 0.72), 0.22),
    (1.18, (1.08, 0.96, 0.84), 0.10),
    (0.9, (0.86, 0.9, 0.94), 0.0),
)
"""Kinds of stone, by the seed: height relative to the usual, tint, and how much its layers differ:
granite, slate, sandstone and basalt."""

LAYERS = 5.5
"""Layers of a stone by its length."""


@cache
def icosphere(halvings: int) -> tuple[Array, NDArray[np.int64]]:
    """Return vertices (V, 3) on the unit sphere and faces (F, 3), 20 times four to `halvings`."""
    t = (1.0 + 5.0**0.5) / 2.0
    corners = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0)]
    corners += [(z, x, y) for x, y, z in corners[:4]] + [(y, z, x) for x, y, z in corners[:4]]
    vertices = unit(np.array(corners, float))
    # The faces are the triples of corners that lie nearest to one another.
    near = np.linalg.norm(vertices[:, None] - vertices[None], axis=-1) < 1.1
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    triangles = np.array(faces)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    inward = (np.cross(b - a, c - a) * a).sum(axis=-1) < 0.0
    triangles[inward] = triangles[inward][:, [0, 2, 1]]
    for _ in range(halvings):
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, number = np.unique(edges, axis=0, return_inverse=True)
        x, y, z = (number.reshape(-1, 3) + len(vertices)).T
        p, q, r = triangles.T
        vertices = np.concatenate([vertices, unit(vertices[unique].mean(axis=1))])
        triangles = np.concatenate(
            [np.stack(t, axis=-1) for t in ((p, x, z), (q, y, x), (r, z, y), (x, y, z))]
        )
    return vertices, triangles


def surface_normals(vertices: Array, faces: NDArray[np.int64]) -> Array:
    """Return the normals (V, 3) of a closed surface, weighted by area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, faces[:, k], n)
    return unit(total)


def rough(points: Array, seed: int, octaves: int = 4) -> Array:
    """Return noise (N,) at points (N, 3) of a surface around the origin."""
    x, y, z = points.T
    planes = [np.stack(pair, axis=-1) for pair in ((x, y), (y, z), (z, x))]
    return np.asarray(sum(fractal(p, seed + 7 * k, octaves) for k, p in enumerate(planes)) / 1.8)


def stone(
    seed: int,
    halvings: int,
    *,
    edged: float = 1.0,
    flat: float = 0.62,
    planes: tuple[int, int] = (6, 15),
) -> Prototype:
    """Return a stone about two metres long that lies a third in the ground.

    Args:
        seed: of its shape.
        halvings: of the edges of its sphere: 320 triangles for 2.
        edged: share of the sphere that its planes cut off.
        flat: height relative to its length.
        planes: least number of planes, and the number that they are fewer than: few planes leave
            blocks, many leave what water has rolled.
    """
    rng = np.random.default_rng(seed)
    high, tint, layered = KINDS[seed % len(KINDS)]
    vertices, faces = icosphere(halvings)
    for _ in range(int(rng.integers(*planes))):
        normal = unit(rng.normal(size=3))
        beyond = vertices @ normal - rng.uniform(0.52, 0.88)
        vertices = vertices - (edged * 0.92 * np.maximum(beyond, 0.0))[:, None] * normal
    vertices = vertices * (1.0 + 0.10 * rough(1.4 * vertices, seed, 3))[:, None]
    vertices = vertices * [1.0, flat * high * rng.uniform(0.8, 1.2), rng.uniform(0.55, 0.95)]
    normals = surface_normals(vertices, faces)
    vertices = vertices * (1.0 + 0.035 * rough(4.3 * vertices, seed + 3, 3))[:, None]
    grain = rough(3.1 * vertices, seed + 5)
    bed = unit(np.array([0.0, 1.0, 0.0]) + 0.35 * rng.normal(size=3))
    layer = layered * np.sin(2.0 * np.pi * LAYERS * (vertices @ bed) + 2.5 * grain)
    color = np.asarray(GREY) * tint * (0.9 + 0.42 * grain + layer)[:, None]
    lichen = smoothstep(0.15, 0.5, rough(2.0 * vertices, seed + 9)) * smoothstep(
        0.2, 0.8, normals[:, 1]
    )
    color = mixed(color, LICHEN, 0.6 * lichen)
    # Soil clings to the foot, and little light reaches it.
    color = color * (0.55 + 0.45 * smoothstep(-0.25, 0.15, vertices[:, 1]))[:, None]
    shape = Shape()
    lifted = vertices + np.array([0.0, 0.22 * flat, 0.0])
    shape.add(lifted, normals, color, faces, thin=False)
    return shape.prototype()


SMALLEST, LARGEST, STEEPNESS = 0.0045, 0.042, 0.62
"""Half the lengths of the smallest and of the largest pebble [m], and the steepness of the power
law of the sizes between them: many are grit, few are stones."""

COARSE = 0.009
"""Size below which a pebble is drawn with a fourth of the triangles [m]."""


def pebbles(seed: int, count: int, halvings: int) -> Prototype:
    """Return pebbles from 1 to 8 cm long, strewn in heaps over 0.5 m."""
    rng = np.random.default_rng(seed)
    shape = Shape()
    heaps = rng.normal(0.0, 0.16, (3, 3)) * [1, 0, 1]
    for k in range(count):
        angle, share = rng.uniform(0, 2 * np.pi), rng.uniform()
        size = min(SMALLEST * (1.0 - share) ** -STEEPNESS, LARGEST)
        fineness = halvings if size > COARSE else max(halvings - 1, 0)
        # Most are split, some are rolled.
        split = rng.uniform() < 0.7
        one = stone(
            *(1000 * seed + k, fineness),
            edged=1.04 if split else 0.9,
            flat=0.5 * np.exp(rng.normal(0.0, 0.25)),
            planes=(4, 9) if split else (8, 15),
        )
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        # Sunk into the soil by some of their height: they do not lie on it like eggs.
        spread = (0.05, 0.14)[k % 2]
        sunk = rng.uniform(0.10, 0.32) * size
        at = heaps[k % 3] + rng.normal(0.0, spread, 3) * [1, 0, 1] - [0.0, sunk, 0.0]
        light = np.exp(rng.normal(0.0, 0.34)) * np.array([1.0, *rng.normal([0.98, 0.93], 0.05)])
        shape.add(
            one.vertices @ turn.T * size + at,
            one.normals @ turn.T,
            one.colors * light,
            one.solid.astype(np.int64),
            thin=False,
        )
    return shape.prototype()
