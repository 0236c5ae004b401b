"""Skinning: where the vertices of a take's parts are in one row."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array, cross, matrix
from pipeline.simulation.take import UNSEEN, Part, Take

LEAP = 400.0
"""Speed over which something is taken to be set elsewhere [m/s]."""

_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Skin:
    """All that is seen of a take, part after part, with the nodes that vertices follow.

    Attributes:
        vertices: (V, 3) in the rest frame, relative to each of the two nodes: (2, V, 3) [m].
        nodes: (2, V).
        weights: (2, V, 1).
        blended: (B,) vertices that follow two nodes, in one part or the other.
        starts: (P + 1,) first vertex of each part that is seen.
    """

    vertices: Array
    nodes: NDArray[np.int32]
    weights: Array
    blended: NDArray[np.int64]
    starts: NDArray[np.int64]

    @staticmethod
    def of(take: Take) -> Skin:
        """Collect the vertices of all parts of `take` that are seen."""
        meshes = [take.meshes[part.seen] for part in seen_parts(take)]
        counts = [len(mesh.vertices) for mesh in meshes]
        nodes = np.concatenate([mesh.nodes for mesh in meshes]).T
        rest = np.array([node.rest for node in take.nodes])
        vertices = np.concatenate([mesh.vertices for mesh in meshes]).astype(float)
        weights = np.concatenate([mesh.weights for mesh in meshes]).T[..., None].astype(float)
        return Skin(
            vertices=vertices - rest[nodes],
            nodes=nodes,
            weights=weights,
            blended=np.flatnonzero(weights[1, :, 0] > 0.0),
            starts=np.concatenate([[0], np.cumsum(counts)]),
        )

    def posed(self, take: Take, at: float) -> NDArray[np.float32]:
        """Return the vertices (V, 3) in the world [m], at a row or between two."""
        q, p, scales = poses(take, at)
        row = int(at)
        R = matrix(q)
        # A scale is of the node's own geometry: along its axes, before it is turned.
        R[list(take.scaled)] *= scales[:, None, :]
        first = self.nodes[0]
        world: Array = p[first] + (R[first] @ self.vertices[0][..., None])[..., 0]
        if self.blended.size:
            world[self.blended] = self._bent(q, p, R)
        gone = ~take.alive[row]
        if gone.any():
            # Hidden by collapsing: the topology of a build stays as it is.
            world[gone[self.nodes[0]]] = 0.0
        return world.astype(np.float32)

    def _bent(self, q: Array, p: Array, R: Array) -> Array:
        """Return where the vertices that follow two nodes are (B, 3) [m].

        Each turns by a part of the way from one node to the other, about the axis on which the
        one turns into the other: a knee that is bent keeps its volume, where the mean of both
        places would fall in. Nodes that only move apart stretch what is between them.

        Source: Kavan et al. 2007, dual quaternions, for two of them.
        """
        some, share = self.blended, self.weights[1, self.blended]
        a, b = (self.nodes[k][some] for k in range(2))
        offset = self.vertices[0][some]
        # The one node carries the other's vertices; what is left is a turn and a shift.
        here = p[a] + (R[a] @ offset[..., None])[..., 0]
        there = p[b] + (R[b] @ self.vertices[1][some][..., None])[..., 0]
        turned = _product(q[b], q[a] * _CONJUGATE)
        turned = turned * np.where(turned[:, :1] < 0.0, -1.0, 1.0)
        # there = turned (here) + shift, whatever point both are told from.
        shift = there - _turned(turned, here)
        dual = 0.5 * _product(np.concatenate([np.zeros_like(share), shift], axis=-1), turned)
        real = share * turned
        real[:, :1] += 1.0 - share
        # A node that is not yet anywhere has no rotation at all.
        norm = np.maximum(np.sqrt((real * real).sum(axis=-1, keepdims=True)), 1e-12)
        real, dual = real / norm, share * dual / norm
        moved = 2.0 * _product(dual, real * _CONJUGATE)[:, 1:]
        result: Array = _turned(real, here) + moved
        return result


def seen_parts(take: Take) -> tuple[Part, ...]:
    """Return the parts of a take that are seen, in order."""
    return tuple(part for part in take.parts if part.seen != UNSEEN)


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


def _product(a: Array, b: Array) -> Array:
    """Return the products (n, 4) of quaternions wxyz."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a.T, b.T
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def _turned(q: Array, v: Array) -> Array:
    """Return vectors (n, 3) turned by unit quaternions (n, 4)."""
    w, u = q[:, :1], q[:, 1:]
    once = cross(u, v)
    result: Array = v + 2.0 * (w * once + cross(u, once))
    return result
