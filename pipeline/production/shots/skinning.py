"""Skinning: world vertices of the visible parts of a take, in one row or between two."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.face_motions import FaceMotions
from pipeline.simulation.spatial import Array, cross, matrix
from pipeline.simulation.take import UNSEEN, Mesh, Part, Take

TELEPORT_SPEED = 400.0
"""Speed above which a node is not interpolated between rows [m/s]."""

_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Skin:
    """All visible vertices of a take, part after part, with the nodes that they follow.

    Attributes:
        vertices: (V, 3) in the rest frame, relative to each of the two nodes: (2, V, 3) [m].
        nodes: (2, V).
        weights: (2, V, 1).
        blended: (B,) vertices that follow two nodes, or crease where these are bent.
        starts: (P + 1,) first vertex of each visible part.
        motions: of the faces.
        creases: (V, 3) moves where both nodes are turned by 90 degrees [m]; (0, 3) for none.
        twists: (V, 3) middle directions of limbs, as long as the share of twist that is not taken;
            (0, 3) for none.
    """

    vertices: Array
    nodes: NDArray[np.int32]
    weights: Array
    blended: NDArray[np.int64]
    starts: NDArray[np.int64]
    motions: FaceMotions = field(default_factory=FaceMotions)
    creases: Array = field(default_factory=lambda: np.zeros((0, 3)))
    twists: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @staticmethod
    def of(take: Take) -> Skin:
        """Return the skin of the visible parts of `take`."""
        return Skin.of_meshes(take, [take.meshes[part.seen] for part in visible_parts(take)])

    @staticmethod
    def of_meshes(
        take: Take, meshes: Sequence[Mesh], places: Sequence[NDArray[np.float32]] | None = None
    ) -> Skin:
        """Return the skin of some meshes of a take.

        Args:
            take: that has their nodes.
            meshes: in the order of the skin.
            places: (V, 3) for each mesh in the rest frame, that follow its nodes in place of its
                vertices [m].
        """
        counts = [len(mesh.vertices) for mesh in meshes]
        starts = np.concatenate([[0], np.cumsum(counts)])
        placed = places or [mesh.vertices for mesh in meshes]
        nodes = np.concatenate([mesh.nodes for mesh in meshes]).T
        rest = np.array([node.rest for node in take.nodes])
        vertices = np.concatenate(placed).astype(float)
        weights = np.concatenate([mesh.weights for mesh in meshes]).T[..., None].astype(float)
        creases, twists = (_rows(meshes, name) for name in ("creases", "twists"))
        blended = weights[1, :, 0] > 0.0
        if len(creases):
            blended = blended | creases.any(axis=1)
        if len(twists):
            blended = blended | twists.any(axis=1)
        return Skin(
            vertices=vertices - rest[nodes],
            nodes=nodes,
            weights=weights,
            blended=np.flatnonzero(blended),
            starts=starts,
            motions=FaceMotions.of(take, meshes, starts),
            creases=creases,
            twists=twists,
        )

    def thinned(self, most: int) -> Skin:
        """Return the skin with about `most` vertices of each part, the outermost among them."""
        kept = [
            first + spread_vertices(self.vertices[0, first:end], most)
            for first, end in itertools.pairwise(self.starts)
        ]
        some = np.concatenate(kept)
        weights = self.weights[:, some]
        return Skin(
            vertices=self.vertices[:, some],
            nodes=self.nodes[:, some],
            weights=weights,
            blended=np.flatnonzero(weights[1, :, 0] > 0.0),
            starts=np.concatenate([[0], np.cumsum([len(part) for part in kept])]),
        )

    def posed(self, take: Take, at: float) -> NDArray[np.float32]:
        """Return the vertices (V, 3) in the world [m], at a row or between two."""
        q, p, scales = interpolated_poses(take, at)
        row = int(at)
        R = matrix(q)
        # A scale acts along the node's own axes, before its rotation.
        R[list(take.scaled)] *= scales[:, None, :]
        first = self.nodes[0]
        world: Array = p[first] + (R[first] @ self.vertices[0][..., None])[..., 0]
        acts = self.motions.touched
        moves = self.motions.offsets(len(first), take, at) if acts.size else None
        if moves is not None:
            world[acts] += (R[first[acts]] @ moves[acts][..., None])[..., 0]
        if self.blended.size:
            offsets = self.vertices[:, self.blended]
            if moves is not None:
                # Both nodes of a vertex are turned alike at rest.
                offsets = offsets + moves[self.blended]
            world[self.blended] = self._blended_vertices(offsets, q, p, R)
        gone = ~take.alive[row]
        if gone.any():
            # Hidden by collapsing, because the topology of a build is constant.
            world[gone[self.nodes[0]]] = 0.0
        return world.astype(np.float32)

    def _blended_vertices(self, offsets: Array, q: Array, p: Array, R: Array) -> Array:
        """Return the vertices that follow two nodes (B, 3) [m], by dual quaternion skinning.

        A bent knee keeps its volume, where linear blending would collapse it. Nodes that only
        move apart stretch what is between them.

        Source: Kavan et al. 2007, for two dual quaternions.
        """
        some, share = self.blended, self.weights[1, self.blended]
        a, b = (self.nodes[k][some] for k in range(2))
        offset, other, own = offsets[0], offsets[1], q[b]
        signed = np.zeros(0, np.int64)
        if len(self.twists):
            signed = held = np.flatnonzero(self.twists[some].any(axis=1))
            against = _product(q[a[held]] * _CONJUGATE, own[held])
            back = _untwisted(self.twists[some[held]], against)
            other = other.copy()
            other[held] = _turned(back, other[held])
            own[held] = _product(own[held], back)
        # Relative to the first node the second one is a rotation and a translation.
        here = p[a] + (R[a] @ offset[..., None])[..., 0]
        there = p[b] + (R[b] @ other[..., None])[..., 0]
        turned = _product(own, q[a] * _CONJUGATE)
        # The shorter way around, but for limbs whose middle direction says which way they went.
        flips = turned[:, 0] < 0.0
        flips[signed] = False
        turned[flips] *= -1.0
        if len(self.creases):
            bend = _sine_of_bend(turned)
            # A shoulder rises late, with the height of the arm and not with its swing.
            bend[signed] = _rise_of_bend(turned[signed])
            folded = bend[:, None] * self.creases[some]
            here = here + (R[a] @ folded[..., None])[..., 0]
            there = there + (R[b] @ folded[..., None])[..., 0]
        # there = turned (here) + shift
        shift = there - _turned(turned, here)
        dual = 0.5 * _product(np.concatenate([np.zeros_like(share), shift], axis=-1), turned)
        real = share * turned
        real[:, :1] += 1.0 - share
        # A node that is not alive yet has a zero quaternion.
        norm = np.maximum(np.sqrt((real * real).sum(axis=-1, keepdims=True)), 1e-12)
        real, dual = real / norm, share * dual / norm
        moved = 2.0 * _product(dual, real * _CONJUGATE)[:, 1:]
        return _turned(real, here) + moved


def _rows(meshes: Sequence[Mesh], name: str) -> Array:
    """Return an optional array (V, 3) of all vertices of some meshes; (0, 3) without any."""
    found = [getattr(mesh, name) for mesh in meshes]
    if not any(len(rows) for rows in found):
        return np.zeros((0, 3))
    parts = (x if len(x) else np.zeros_like(m.vertices) for x, m in zip(found, meshes, strict=True))
    return np.concatenate([*parts]).astype(float)


def _untwisted(twists: Array, turned: Array) -> Array:
    """Return turns (n, 4) about Y at rest, wxyz, by which limbs are twisted back.

    The twist is measured from the limb's middle direction, to which it is swung from hanging: so
    it is defined in all directions but the opposite one. Their signs are such that limbs came by
    their middle directions.

    Args:
        twists: (n, 3) middle directions times the shares that are twisted back.
        turned: (n, 4) turns of the limbs against their trunks, from hanging along -Y.
    """
    share = np.sqrt((twists * twists).sum(axis=-1))
    along = twists / share[:, None]
    # From hanging to the middle direction; w is the cosine of half the angle.
    x, y, z = along.T
    w = np.sqrt(np.maximum(0.5 * (1.0 - y), 1e-12))
    zero = np.zeros_like(w)
    swing = np.stack([w, -0.5 * z / w, zero, 0.5 * x / w], axis=-1)
    further = _product(turned, swing * _CONJUGATE)
    angle = 2.0 * np.arctan2((further[:, 1:] * along).sum(axis=-1), further[:, 0])
    angle = np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
    # The limb hangs along -Y: back by its twist is ahead about Y.
    half = 0.5 * share * angle
    back = np.stack([np.cos(half), zero, np.sin(half), zero], axis=-1)
    way = (_product(turned, back) * swing).sum(axis=-1)
    return back * np.where(way < 0.0, -1.0, 1.0)[:, None]


def _sine_of_bend(turned: Array) -> Array:
    """Return the sines (n,) of the angles of quaternions wxyz (n, 4); 1 beyond 90 degrees.

    w is the cosine of half the angle. A negative one counts as beyond 90 degrees.
    """
    w = np.clip(turned[:, 0], np.sqrt(0.5), 1.0)
    return 2.0 * w * np.sqrt(1.0 - w * w)


def _rise_of_bend(turned: Array) -> Array:
    """Return 1 less the cosines (n,) of the angles of quaternions wxyz; 1 beyond 90 degrees."""
    w = np.clip(turned[:, 0], np.sqrt(0.5), 1.0)
    return np.asarray(2.0 * (1.0 - w * w))


def spread_vertices(vertices: Array, most: int) -> NDArray[np.int64]:
    """Return the numbers of some vertices (V, 3): every n-th, and the outermost six."""
    every = np.arange(0, len(vertices), -(-len(vertices) // most))
    return np.unique(np.concatenate([every, vertices.argmin(axis=0), vertices.argmax(axis=0)]))


def visible_parts(take: Take) -> tuple[Part, ...]:
    """Return the visible parts of a take in order."""
    return tuple(part for part in take.parts if part.seen != UNSEEN)


def interpolated_poses(take: Take, at: float) -> tuple[Array, Array, Array]:
    """Return rotations wxyz (J, 4), positions (J, 3) [m] and scales, linear between two rows."""
    row = int(at)
    part, after = at - row, min(row + 1, len(take.positions) - 1)
    q, p, scales = take.rotations[row], take.positions[row], take.scales[row]
    if part == 0.0 or after == row:
        return q, p, scales
    # Teleported nodes are not drawn between their positions.
    step = take.positions[after] - p
    rate = float(take.header.rate * take.header.samples)
    goes = (np.linalg.norm(step, axis=-1) * rate < TELEPORT_SPEED)[:, None]
    # Signs of neighbours agree and a row is short, so the chord replaces the arc.
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
    return v + 2.0 * (w * once + cross(u, once))
