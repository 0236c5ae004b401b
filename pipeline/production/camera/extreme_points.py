"""Outlines: the outermost points of the parts of a take, at every frame of a cut."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.row_storage import allocate_rows, row_chunks
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Mesh, Part, Take

DIRECTIONS: Array = np.array([v for v in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(v)])
"""In which the outermost vertices are sought: to faces, edges and corners of a cube.

A box has all its corners among them, and a ball is at most a tenth larger than they say.
"""


@dataclass(frozen=True, eq=False)
class Outlines:
    """Points in the frames of P nodes, each of a part or of what follows one node of it.

    Attributes:
        nodes: (P,) that they move with.
        points: (P, 26, 3) relative to their nodes [m].
        owners: the performer of each.
    """

    nodes: NDArray[np.int64]
    points: Array
    owners: tuple[str, ...]

    @staticmethod
    def of(take: Take, wanted: Callable[[Part], bool]) -> Outlines:
        """Return the outlines of the parts that are `wanted`."""
        found = [
            (node, points, part.performer)
            for part in take.parts
            if wanted(part)
            for node, points in _outlines(take, take.meshes[part.mesh])
        ]
        return Outlines(
            np.array([node for node, _, _ in found], dtype=np.int64),
            np.array([points for _, points, _ in found]).reshape(-1, len(DIRECTIONS), 3),
            tuple(owner for _, _, owner in found),
        )

    def placed(self, take: Take, rows: NDArray[np.int64]) -> Array:
        """Return the points (F, P, 26, 3) in the world, NaN of what is not there [m]."""
        scaled = [
            (j, take.scaled.index(n)) for j, n in enumerate(self.nodes) if n in set(take.scaled)
        ]
        points_W: Array = allocate_rows((len(rows), *self.points.shape), float)
        for some in row_chunks(points_W):
            which = np.ix_(rows[some], self.nodes)
            R, p = matrix(take.rotations[which]), take.positions[which]
            for j, n in scaled:
                R[:, j] *= take.scales[rows[some], n][:, None]
            points_W[some] = np.einsum("fpij,pcj->fpci", R, self.points) + p[:, :, None]
            points_W[some][~take.alive[which]] = np.nan
        return points_W


def _outlines(take: Take, mesh: Mesh) -> list[tuple[int, Array]]:
    """Return the outermost points (26, 3) of a mesh in the node it follows.

    The mesh of a group follows many nodes; each has points of its own then.
    """
    nodes = mesh.nodes[:, 0]
    several = bool((mesh.weights[:, 1] == 0.0).all()) and bool((nodes != nodes[0]).any())
    outlines = []
    for node in np.unique(nodes) if several else nodes[:1]:
        vertices = (mesh.vertices[nodes == node] if several else mesh.vertices).astype(float)
        outer = [int((vertices * direction).sum(axis=1).argmax()) for direction in DIRECTIONS]
        outlines.append((int(node), vertices[outer] - take.nodes[int(node)].rest))
    return outlines
