"""Resting: where the vertices of a part lie in a frame of its own, which its pattern follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import UNSEEN, Mesh, Take
from render.config import Material

LONG = 1.6
"""How much longer than wide a part is whose pattern runs along it (deviations of vertices)."""

ALIGNED = 0.98
"""Cosine of the angle up to which a part is taken to lie along an axis of its own frame."""

APART = np.array([0.6180, 0.4142, 0.7321])
"""How far apart patterns are that two parts show of one mesh [m]: never whole tiles."""


def rests(take: Take, materials: Mapping[str, Material]) -> Sequence[NDArray[np.float32] | None]:
    """Return the places (V, 3) of the vertices of all parts seen; None for one without pattern."""
    aligned = lru_cache(maxsize=None)(lambda number: along_first(take.meshes[number]))
    found: list[NDArray[np.float32] | None] = []
    for i, part in enumerate(take.parts):
        if part.seen == UNSEEN:
            continue
        plain = materials[part.material].texture == "none"
        found.append(None if plain else (aligned(part.seen) + i * APART).astype(np.float32))
    return found


def along_first(mesh: Mesh) -> Array:
    """Return the vertices (V, 3) of a mesh at rest, turned so that it lies along the first axis.

    What is about as long as wide keeps its own axes.
    """
    vertices = mesh.vertices.astype(float)
    vertices -= vertices.mean(axis=0)
    sizes, axes = np.linalg.eigh(np.cov(vertices.T))
    if sizes[2] < LONG**2 * sizes[1]:
        return vertices
    along = axes[:, 2]
    first = int(np.abs(along).argmax())
    if abs(along[first]) > ALIGNED:
        return vertices[:, [first, (first + 1) % 3, (first + 2) % 3]]
    along = along * np.sign(along[first])
    across = np.cross(along, np.eye(3)[int(np.abs(along).argmin())])
    across /= np.linalg.norm(across)
    result: Array = np.einsum(
        "vk,ak->va", vertices, np.array([along, across, np.cross(along, across)])
    )
    return result
