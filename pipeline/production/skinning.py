"""Skinning: where the vertices of a take's parts are in one row."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Take

LEAP = 400.0
"""Speed over which something is taken to be set elsewhere [m/s]."""


@dataclass(frozen=True, eq=False)
class Skin:
    """All vertices of a take, part after part, with the nodes that they follow.

    Attributes:
        vertices: (V, 3) in the rest frame, relative to each of the two nodes: (2, V, 3) [m].
        nodes: (2, V).
        weights: (2, V, 1).
        blended: whether any vertex follows two nodes.
        starts: (P + 1,) first vertex of each part.
    """

    vertices: Array
    nodes: NDArray[np.int32]
    weights: Array
    blended: bool
    starts: NDArray[np.int64]

    @staticmethod
    def of(take: Take) -> Skin:
        """Collect the vertices of all parts of `take`."""
        meshes = [take.meshes[part.mesh] for part in take.parts]
        counts = [len(mesh.vertices) for mesh in meshes]
        nodes = np.concatenate([mesh.nodes for mesh in meshes]).T
        rest = np.array([node.rest for node in take.nodes])
        vertices = np.concatenate([mesh.vertices for mesh in meshes]).astype(float)
        weights = np.concatenate([mesh.weights for mesh in meshes]).T[..., None].astype(float)
        return Skin(
            vertices=vertices - rest[nodes],
            nodes=nodes,
            weights=weights,
            blended=bool(np.any(weights[1] > 0.0)),
            starts=np.concatenate([[0], np.cumsum(counts)]),
        )

    def posed(self, take: Take, at: float) -> NDArray[np.float32]:
        """Return the vertices (V, 3) in the world [m], at a row or between two."""
        q, p, scales = poses(take, at)
        row = int(at)
        R = matrix(q)
        # A scale is of the node's own geometry: along its axes, before it is turned.
        R[list(take.scaled)] *= scales[:, None, :]
        world = np.zeros((self.vertices.shape[1], 3))
        for k in range(2 if self.blended else 1):
            moved = p[self.nodes[k]] + (R[self.nodes[k]] @ self.vertices[k][..., None])[..., 0]
            world += self.weights[k] * moved
        gone = ~take.alive[row]
        if gone.any():
            # Hidden by collapsing: the topology of a build stays as it is.
            world[gone[self.nodes[0]]] = 0.0
        return world.astype(np.float32)


def poses(take: Take, at: float) -> tuple[Array, Array, Array]:
    """Return rotations wxyz (J, 4), positions (J, 3) [m] and scales, straight between two rows."""
    row = int(at)
    part, after = at - row, min(row + 1, len(take.positions) - 1)
    q, p, scales = take.rotations[row], take.positions[row], take.scales[row]
    if part == 0.0 or after == row:
        return q, p, scales
    # Who is set from one place to another in no time is not drawn on the way there.
    step = take.positions[after] - p
    rate = float(take.header.rate * take.header.samples)
    goes = (np.linalg.norm(step, axis=-1) * rate < LEAP)[:, None]
    # Signs of neighbours agree, and a row is short: a chord is as good as the arc.
    turned = q + part * (take.rotations[after] - q)
    turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
    scaled = scales + part * (take.scales[after] - scales)
    return np.where(goes, turned, q), np.where(goes, p + part * step, p), scaled
