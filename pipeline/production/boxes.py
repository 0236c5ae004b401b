"""Boxes: around the parts of a take, at every frame of a cut."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.reel import reel, rows_of
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Mesh, Part, Take


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes in the frames of P nodes, each around a part or around what follows one node of it.

    Attributes:
        nodes: (P,) that they move with.
        corners: (P, 8, 3) relative to their nodes [m].
        owners: the performer of each.
    """

    nodes: NDArray[np.int64]
    corners: Array
    owners: tuple[str, ...]

    @staticmethod
    def of(take: Take, wanted: Callable[[Part], bool]) -> Boxes:
        """Return the boxes of the parts that are `wanted`."""
        found = [
            (node, box, part.performer)
            for part in take.parts
            if wanted(part)
            for node, box in _boxes(take, take.meshes[part.mesh])
        ]
        return Boxes(
            np.array([node for node, _, _ in found], dtype=np.int64),
            np.array([box for _, box, _ in found]).reshape(-1, 8, 3),
            tuple(owner for _, _, owner in found),
        )

    def placed(self, take: Take, rows: NDArray[np.int64]) -> Array:
        """Return the corners (F, P, 8, 3) in the world, NaN of what is not there [m]."""
        scaled = [
            (j, take.scaled.index(n)) for j, n in enumerate(self.nodes) if n in set(take.scaled)
        ]
        corners_W: Array = reel((len(rows), len(self.nodes), 8, 3), float)
        for some in rows_of(corners_W):
            which = np.ix_(rows[some], self.nodes)
            R, p = matrix(take.rotations[which]), take.positions[which]
            for j, n in scaled:
                R[:, j] *= take.scales[rows[some], n][:, None]
            corners_W[some] = np.einsum("fpij,pcj->fpci", R, self.corners) + p[:, :, None]
            corners_W[some][~take.alive[which]] = np.nan
        return corners_W


def _boxes(take: Take, mesh: Mesh) -> list[tuple[int, Array]]:
    """Return the corners (8, 3) of a box around a mesh in the node it follows.

    The mesh of a group follows many nodes; each has a box then.
    """
    nodes = mesh.nodes[:, 0]
    several = bool((mesh.weights[:, 1] == 0.0).all()) and bool((nodes != nodes[0]).any())
    boxes = []
    for node in np.unique(nodes) if several else nodes[:1]:
        vertices = mesh.vertices[nodes == node] if several else mesh.vertices
        ends = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
        box = np.stack(np.meshgrid(*ends.T.astype(float)), axis=-1).reshape(8, 3)
        boxes.append((int(node), box - take.nodes[int(node)].rest))
    return boxes
