"""Floor mesh: slabs one by one, those of the border sunk, tilted and chipped; or a deck."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.surroundings.lattice_noise import fractal, smoothstep
from pipeline.simulation.spatial import Array
from render.shot import Mesh

GAP = 0.007
"""Half the width of a joint between loose slabs [m]."""

SUNK, TILT, SHIFT, TURN = 0.028, 0.018, 0.02, 0.022
"""How far loose slabs lie lower [m], lean, are displaced, relative to their side, and turned."""

THICK = 0.11
"""Depth to which sides of slabs and of a deck go [m]."""

EARTH, MOSS, MOST_DIRT = (0.075, 0.058, 0.038), (0.052, 0.062, 0.022), 0.62
"""Linear colours of what soils the border of paving, and its greatest share."""

STAINED = 0.3
"""Share of earth in the stains of paving."""

CHIPPED = 0.22
"""Share of the corners of loose slabs that are broken off."""


def paving_mesh(plan: FloorPlan, material: str, seed: int) -> Mesh:
    """Return the slabs of a floor."""
    rng = np.random.default_rng([seed, 417])
    bare = np.pad(~plan.kept, 1, constant_values=True)
    beside = binary_dilation(bare, np.ones((3, 3)))[1:-1, 1:-1]
    loose = plan.kept & ~plan.whole & beside
    firm = plan.kept & ~loose
    vertices: list[Array] = []
    faces: list[NDArray[np.int64]] = []
    count = 0
    for j, i in np.argwhere(firm):
        corner = plan.low + plan.piece * np.array([i, j])
        ring = corner + plan.piece * np.array([[0, 0], [0, 1], [1, 1], [1, 0]])
        count = _added(vertices, faces, count, _at(ring, plan.height), side=bool(beside[j, i]))
    for j, i in np.argwhere(loose):
        ring = _loose_outline(plan, rng, i, j)
        count = _added(vertices, faces, count, ring, side=True)
    points = np.concatenate(vertices).astype(np.float32)
    return Mesh(
        "terrain",
        points,
        np.concatenate(faces).astype(np.uint32),
        material,
        uv=points[:, [0, 2]],
        smooth=False,
        cover=dirt(plan, points, seed),
    )


def dirt(plan: FloorPlan, points: NDArray[np.float32], seed: int) -> NDArray[np.float32]:
    """Return what covers slabs: earth and moss that come in from the border (V, 4)."""
    places = points[:, [0, 2]].astype(float)
    inward = -plan.beyond(places)
    value = 0.5 + 0.7 * fractal(places / 2.6, seed + 471, 3)
    share = MOST_DIRT * np.clip(value, 0.0, 1.2) * (1.0 - smoothstep(0.2, 3.2, inward))
    stains = smoothstep(0.1, 0.7, fractal(places / 1.6, seed + 474, 4))
    share = np.maximum(share, STAINED * stains)
    green = smoothstep(-0.3, 0.4, fractal(places / 3.7, seed + 472, 3))[:, None]
    color = np.array(EARTH) + green * (np.array(MOSS) - np.array(EARTH))
    return np.column_stack([color, share]).astype(np.float32)


def soiled_wall(wall: Mesh) -> Mesh:
    """Return the walls of a floor with moss and earth that rise from their feet."""
    foot = wall.vertices[:, 1] <= wall.vertices[:, 1].min() + 1e-4
    places = wall.vertices[:, [0, 2]].astype(float)
    value = 0.75 + 0.5 * fractal(places / 0.8, 473, 3)
    share = np.clip(np.where(foot, 0.95, 0.22) * value, 0.0, 0.95)
    green = smoothstep(-0.3, 0.4, fractal(places / 1.7, 472, 3))[:, None]
    color = np.array(EARTH) + green * (np.array(MOSS) - np.array(EARTH))
    return replace(wall, cover=np.column_stack([color, share]).astype(np.float32))


def deck_mesh(plan: FloorPlan, material: str) -> Mesh:
    """Return the boards of a deck, with its sides."""
    ring = np.array([plan.low, [plan.low[0], plan.high[1]], plan.high, [plan.high[0], plan.low[1]]])
    vertices: list[Array] = []
    faces: list[NDArray[np.int64]] = []
    _added(vertices, faces, 0, _at(ring, plan.height), side=True, deep=0.3)
    points = np.concatenate(vertices).astype(np.float32)
    numbers = np.concatenate(faces).astype(np.uint32)
    return Mesh("terrain", points, numbers, material, uv=points[:, [0, 2]], smooth=False)


def _loose_outline(plan: FloorPlan, rng: np.random.Generator, i: int, j: int) -> Array:
    """Return the upper outline (K, 3) of a loose slab [m]."""
    half = 0.5 * plan.piece - GAP
    corners = half * np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]], float)
    outline = []
    for k in range(4):
        if rng.uniform() < CHIPPED:
            cut = rng.uniform(0.08, 0.42, 2) * half
            before, after = corners[k - 1] - corners[k], corners[(k + 1) % 4] - corners[k]
            ends = [
                corners[k] + cut[m] * way / np.linalg.norm(way)
                for m, way in enumerate((before, after))
            ]
            middle = 0.5 * (ends[0] + ends[1]) + 0.12 * cut.min() * rng.normal(size=2)
            outline += [ends[0], middle, ends[1]]
        else:
            outline.append(corners[k])
    flat = np.array(outline)
    angle = TURN * rng.normal()
    c, s = np.cos(angle), np.sin(angle)
    flat = flat @ np.array([[c, s], [-s, c]])
    lean = TILT * rng.normal(size=2)
    # The pattern lies by places of the world: a shift must stay within the joints.
    middle = plan.low + plan.piece * (np.array([i, j]) + 0.5) + SHIFT * rng.normal(size=2)
    height = plan.height - SUNK * abs(rng.normal()) + flat @ lean
    return np.stack([*(flat + middle).T, height], axis=-1)[:, [0, 2, 1]]


def _at(ring: Array, height: float) -> Array:
    return np.stack([ring[:, 0], np.full(len(ring), height), ring[:, 1]], axis=-1)


def _added(
    vertices: list[Array],
    faces: list[NDArray[np.int64]],
    count: int,
    ring: Array,
    *,
    side: bool,
    deep: float = THICK,
) -> int:
    """Add a piece by its upper outline (K, 3), and return the number of vertices after it."""
    n = len(ring)
    order = np.arange(1, n - 1)
    vertices.append(ring)
    faces.append(count + np.stack([np.zeros_like(order), order, order + 1], axis=-1))
    count += n
    if side:
        here, there = np.arange(n), (np.arange(n) + 1) % n
        vertices.append(np.concatenate([ring, ring - [0.0, deep, 0.0]]))
        faces.append(
            count
            + np.concatenate(
                [
                    np.stack([here, here + n, there], axis=-1),
                    np.stack([there, here + n, there + n], axis=-1),
                ]
            )
        )
        count += 2 * n
    return count
