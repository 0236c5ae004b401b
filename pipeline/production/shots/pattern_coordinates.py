"""Pattern coordinates: where the texture of each visible part is looked up, in its rest pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import UNSEEN, Mesh, Take
from render.config import Material

MIN_ELONGATION = 1.6
"""Ratio of deviations of the vertices from which a part's pattern runs along it."""

ALIGNED_COSINE = 0.98
"""Cosine of the angle up to which a part lies along an axis of its own frame."""

PATTERN_OFFSET = np.array([0.6180, 0.4142, 0.7321])
"""Offset between the patterns of two parts with one mesh [m]: never whole tiles."""


def pattern_coordinates(
    take: Take, materials: Mapping[str, Material]
) -> Sequence[NDArray[np.float32] | None]:
    """Return the pattern coordinates (V, 3) of each visible part, None for one without pattern."""
    aligned = lru_cache(maxsize=None)(lambda number: _aligned_vertices(take.meshes[number]))
    found: list[NDArray[np.float32] | None] = []
    for i, part in enumerate(take.parts):
        if part.seen == UNSEEN:
            continue
        plain = materials[part.material].texture == "none"
        found.append(
            None if plain else (aligned(part.seen) + i * PATTERN_OFFSET).astype(np.float32)
        )
    return found


def _aligned_vertices(mesh: Mesh) -> Array:
    """Return the rest vertices (V, 3) of a mesh with its longest extent along the first axis.

    A mesh about as long as wide keeps its own axes.
    """
    vertices = mesh.vertices.astype(float)
    vertices -= vertices.mean(axis=0)
    sizes, axes = np.linalg.eigh(np.cov(vertices.T))
    if sizes[2] < MIN_ELONGATION**2 * sizes[1]:
        return vertices
    along = axes[:, 2]
    first = int(np.abs(along).argmax())
    if abs(along[first]) > ALIGNED_COSINE:
        return vertices[:, [first, (first + 1) % 3, (first + 2) % 3]]
    along = along * np.sign(along[first])
    across = np.cross(along, np.eye(3)[int(np.abs(along).argmin())])
    across /= np.linalg.norm(across)
    return np.einsum("vk,ak->va", vertices, np.array([along, across, np.cross(along, across)]))
