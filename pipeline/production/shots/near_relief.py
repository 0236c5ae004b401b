"""Near relief: the ground near the cameras in fine triangles, raised and lowered by its pattern.

The shader bends the normals of all ground by the slopes of the same pattern; here clods, stones
and ripples also get an outline and shadows. Feet stand on the true ground: the relief ends around
their treads. It depends on the whole film, never on a frame, so that nothing moves with the camera.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.puddles import Puddles
from pipeline.production.scenery.treads import Treads
from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array
from render.config import Material
from render.shot import Mesh
from render.textures.ground_relief import ground_relief, has_relief
from render.vertex_normals import vertex_normals

BUDGET = 240_000
"""Triangles of a wide frame's relief; the nearest to the cameras have it."""

SPACING, FINEST, COARSEST = 0.02, 2, 64
"""Wanted length of an edge [m], and least and most edges to one of the terrain."""

WIDEST = 0.1
"""Length of an edge from which it would show nothing of the pattern [m]."""

REACH = 8.0
"""Distance from the cameras up to which the ground has a relief [m]."""

LEAST_REACH = 0.5
"""Distance up to which the budget must suffice; cells as wide as that have no relief [m]."""

FADE = 0.6, 0.92
"""Distances between which the relief ends, relative to the farthest that has one."""

MOST, MOST_OF_DISTANCE = 0.025, 0.006
"""Greatest height of the relief [m], and relative to the distance from the nearest camera."""

LEVEL = 0.75, 0.9
"""Upward parts of normals between which ground is level enough for a relief."""

TREAD_EDGE = 0.06
"""Distance over which the relief rises from the edge of a tread [m]."""

NEAREST_TREADS = 4


def with_relief(
    mesh: Mesh,
    material: Material,
    view: FilmView,
    treads: Treads,
    detail: float,
    puddles: Puddles | None = None,
) -> Mesh:
    """Return the terrain with a relief near the cameras.

    Args:
        mesh: of the terrain.
        material: of it.
        view: of the film.
        treads: of the performers, where the ground stays as it is.
        detail: 1 for frames 1280 pixels wide.
        puddles: below which the ground is level, None without any.
    """
    if not (mesh.smooth and has_relief(material)):
        return mesh
    corners = mesh.vertices[mesh.faces].astype(float)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=1)
    n = int(np.clip(np.ceil(np.median(longest) / SPACING), 1, COARSEST))
    near = view.tile_distances(corners.mean(axis=1), 0.6 * longest, around=0.0)
    order = np.argsort(near, kind="stable")
    most = int(BUDGET * detail**1.5) // n**2
    chosen = order[:most][near[order[:most]] < REACH]
    spacing = float(np.median(longest)) / n
    if n < FINEST or spacing > WIDEST or not len(chosen):
        return mesh
    reach = REACH if len(chosen) < most else float(near[chosen[-1]])
    if reach < LEAST_REACH:
        return mesh
    normals = vertex_normals(mesh.vertices, mesh.faces)
    inner = (~_on_border(mesh.faces, len(mesh.vertices))).astype(float)
    weights, pattern = _subdivision(n)
    points, up, share = (
        np.einsum("kc,tc...->tk...", weights, values[mesh.faces[chosen]].astype(float))
        for values in (mesh.vertices, normals, inner)
    )
    points[..., 1] += share * _heights(
        points, up, material, (view, treads, puddles), (FADE[0] * reach, FADE[1] * reach), spacing
    )
    kept = np.ones(len(mesh.faces), bool)
    kept[chosen] = False
    first = len(mesh.vertices) + len(weights) * np.arange(len(chosen))
    faces = (first[:, None, None] + pattern).reshape(-1, 3)
    points = points.reshape(-1, 3)
    warned = mesh.warned
    if warned is not None:
        warned = np.concatenate([warned[kept], np.repeat(warned[chosen], len(pattern))])
    return replace(
        mesh,
        vertices=np.concatenate([mesh.vertices, points.astype(np.float32)]),
        faces=np.concatenate([mesh.faces[kept], faces.astype(np.uint32)]),
        normals=np.concatenate([normals, _unit(up.reshape(-1, 3)).astype(np.float32)]),
        uv=np.ascontiguousarray(
            np.concatenate([mesh.vertices, points.astype(np.float32)])[:, [0, 2]]
        ),
        warned=warned,
    )


def _heights(
    points: Array,
    normals: Array,
    material: Material,
    film: tuple[FilmView, Treads, Puddles | None],
    fade: tuple[float, float],
    spacing: float,
) -> Array:
    """Return the heights (T, K) of the relief at points (T, K, 3) with normals (T, K, 3) [m]."""
    view, treads, puddles = film
    flat = points.reshape(-1, 3)
    places = flat[:, [0, 2]]
    far = view.distances(flat)
    most = np.minimum(MOST, MOST_OF_DISTANCE * far)
    height = most * np.tanh(ground_relief(material, places, spacing) / most)
    height *= 1.0 - smoothstep(*fade, far)
    height *= smoothstep(*LEVEL, normals.reshape(-1, 3)[:, 1])
    height *= _untrodden(places, treads)
    if puddles is not None:
        height *= puddles.relief(*places.T)
    return np.asarray(height.reshape(points.shape[:2]))


def _untrodden(places: Array, treads: Treads) -> Array:
    """Return 0 for places (N, 2) on treads and 1 away from them, (N,)."""
    count = min(NEAREST_TREADS, len(treads.places))
    if not count:
        return np.ones(len(places))
    apart, number = cKDTree(treads.places).query(places, k=np.arange(1, count + 1), workers=1)
    beyond = (apart - treads.radii[number]).min(axis=1)
    return smoothstep(0.0, TREAD_EDGE, beyond)


def _on_border(faces: NDArray[np.uint32], count: int) -> NDArray[np.bool_]:
    """Return which vertices (count,) lie on edges of a single triangle."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64), axis=1)
    keys, times = np.unique(edges[:, 0] * count + edges[:, 1], return_counts=True)
    single = keys[times == 1]
    result = np.zeros(count, bool)
    result[single // count] = result[single % count] = True
    return result


def _subdivision(n: int) -> tuple[Array, NDArray[np.int64]]:
    """Return the places (K, 3) in a triangle of n² ones, as shares of its corners, and these."""
    i, j = np.triu_indices(n + 1)
    weights = np.stack([n - j, j - i, i], axis=-1) / n
    number = np.zeros((n + 1, n + 1), np.int64)
    number[i, j] = np.arange(len(i))
    a, b = np.triu_indices(n)
    upright = np.stack([number[a, b], number[a, b + 1], number[a + 1, b + 1]], axis=-1)
    c, d = np.triu_indices(n, 1)
    turned = np.stack([number[c, d], number[c + 1, d + 1], number[c + 1, d]], axis=-1)
    return weights, np.concatenate([upright, turned])


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9))
