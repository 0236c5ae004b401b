"""Coarse people: fewer triangles for people who stay small in all frames of a film."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.skinning import visible_parts
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Take

FINE_PIXEL = 0.0055
"""Size of a pixel on people beyond which they are coarse [m]: some 41 pixels from chin to crown."""

CELL_PIXELS, MAX_CELL = 1.7, 0.03
"""Size of the cells within which vertices become one, in pixels, and the largest [m]."""

PAINTED = 0.9
"""Share of paint from which on a vertex joins painted ones alone: irises, lips and teeth. Otherwise
eyes would be white and teeth would come through lips."""


def with_coarse_people(take: Take, finest: Array) -> Take:
    """Return a take whose people are as fine as they show, in all meshes that fold or move a face.

    Args:
        take: of the film.
        finest: (P,) least size of a pixel on each visible part [m]; empty where nobody has hair.
    """
    meshes = list(take.meshes)
    made: dict[tuple[int, float], tuple[NDArray[np.int64], NDArray[np.uint32]]] = {}
    for part, pixel in zip(visible_parts(take), finest, strict=False):
        mesh = take.meshes[part.seen]
        of_person = len(mesh.targets) or len(mesh.creases) or len(mesh.twists)
        if not of_person or len(mesh.hair) or pixel <= FINE_PIXEL:
            continue
        cell = min(CELL_PIXELS * float(pixel), MAX_CELL)
        # Rounded, so that people in like clothes share it.
        cell = FINE_PIXEL * 1.25 ** np.floor(np.log(cell / FINE_PIXEL) / np.log(1.25))
        # People of one size share the arrays of their meshes.
        key = id(mesh.vertices), cell
        if key not in made:
            made[key] = _clustered(mesh, cell)
        meshes[part.seen] = _of_vertices(mesh, *made[key])
    return replace(take, meshes=tuple(meshes))


def _clustered(mesh: Mesh, cell: float) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
    """Return the vertices of a mesh that are left, and the faces between these.

    Vertices become one within a cell, the first of them; painted ones apart, and those of other
    nodes: an arm does not grow on the trunk.
    """
    cells = np.floor(mesh.vertices / cell).astype(np.int64)
    painted = np.zeros(len(cells), bool)
    if len(mesh.paint):
        painted = (mesh.paint[:, 3] > PAINTED) & (mesh.nodes == _head(mesh)).any(axis=1)
    keys = np.concatenate([cells, mesh.nodes, painted[:, None]], axis=1)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    faces = first[inverse.reshape(-1)][mesh.faces.astype(np.int64)]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    if not len(faces):
        # An eye within one cell; no part may vanish.
        return _clustered(mesh, 0.5 * cell)
    kept, faces = np.unique(faces, return_inverse=True)
    return kept, faces.reshape(-1, 3).astype(np.uint32)


def _head(mesh: Mesh) -> int:
    """Return the number of the head's node, which most units of a face move; -1 without."""
    moved = mesh.nodes[mesh.targets[:, 0], 0]
    return int(np.bincount(moved).argmax()) if len(moved) else -1


def _of_vertices(mesh: Mesh, kept: NDArray[np.int64], faces: NDArray[np.uint32]) -> Mesh:
    """Return a mesh of some of its vertices."""
    number = np.full(len(mesh.vertices), -1)
    number[kept] = np.arange(len(kept))
    targets = number[mesh.targets[:, 0]]
    stay = targets >= 0
    return replace(
        mesh,
        vertices=mesh.vertices[kept],
        faces=faces,
        nodes=mesh.nodes[kept],
        weights=mesh.weights[kept],
        uv=mesh.uv[kept] if len(mesh.uv) else mesh.uv,
        paint=mesh.paint[kept] if len(mesh.paint) else mesh.paint,
        targets=np.stack([targets, mesh.targets[:, 1]], axis=-1)[stay].astype(np.int32),
        offsets=mesh.offsets[stay],
        creases=mesh.creases[kept] if len(mesh.creases) else mesh.creases,
        twists=mesh.twists[kept] if len(mesh.twists) else mesh.twists,
    )
