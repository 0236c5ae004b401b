"""Joint tracks: poses of a take's nodes below their parents, and of helpers between two nodes.

glTF blends the matrices of two joints linearly, the renderer blends their screws. A vertex between
two nodes therefore follows the two nearest of some helper joints, which stand at equal shares of
the screw that takes the first node to the second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.shots.skinning import Skin
from pipeline.simulation.spatial import Array, continuous, matrix, quaternion, turn_inverse
from pipeline.simulation.take import Mesh, Take


@dataclass(frozen=True, eq=False)
class JointTrack:
    """The poses of a joint relative to its parent.

    Attributes:
        positions: (K, 3) [m].
        rotations: (K, 4) quaternions wxyz with continuous sign.
    """

    positions: Array
    rotations: Array


def unit_rotations(take: Take) -> Array:
    """Return the rotations (K, J, 4) wxyz of a take; those of nodes that are not alive are none."""
    rotations = take.rotations
    empty = np.linalg.norm(rotations, axis=-1, keepdims=True) < 0.5
    return np.where(empty, [1.0, 0.0, 0.0, 0.0], rotations)


def node_track(take: Take, rotations: Array, node: int) -> JointTrack:
    """Return the track of a node relative to its parent node, or to the world.

    Args:
        take: that has the node.
        rotations: (K, J, 4) wxyz of all its nodes, none of them zero.
        node: its number.
    """
    parent = take.nodes[node].parent
    positions, own = take.positions[:, node], rotations[:, node]
    if parent < 0:
        return JointTrack(positions, continuous(own))
    R_WP = matrix(rotations[:, parent])
    positions = turn_inverse(R_WP, positions - take.positions[:, parent])
    R_PN = np.swapaxes(R_WP, -1, -2) @ matrix(own)
    return JointTrack(positions, continuous(quaternion(R_PN)))


def helper_tracks(
    take: Take, rotations: Array, helpers: list[tuple[int, int, float]]
) -> list[JointTrack]:
    """Return the tracks of helper joints in the world; at rest each stands at its second node.

    Args:
        take: that has their nodes.
        rotations: (K, J, 4) wxyz of all nodes, none of them zero.
        helpers: first node, second node and share of the second, 0 to 1, of each.
    """
    if not helpers:
        return []
    nodes = np.array([(a, b) for a, b, _ in helpers], np.int32)
    share = np.array([s for _, _, s in helpers], np.float32)
    rest = np.array([take.nodes[b].rest for _, b, _ in helpers], np.float32)
    weights = np.stack([1.0 - share, share], axis=-1)
    skin = Skin.of_meshes(take, [Mesh(rest, np.zeros((0, 3), np.uint32), nodes, weights)])
    positions = np.stack([skin.posed(take, row) for row in range(len(take.positions))])
    first, second = rotations[:, nodes[:, 0]], rotations[:, nodes[:, 1]]
    sign = np.where((first * second).sum(axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    between = (1.0 - share[:, None]) * first + share[:, None] * sign * second
    turned = continuous(between / np.linalg.norm(between, axis=-1, keepdims=True))
    return [JointTrack(positions[:, i].astype(float), turned[:, i]) for i in range(len(helpers))]


@dataclass(frozen=True, eq=False)
class Binding:
    """The joints that the vertices of a mesh follow, at most two each.

    Attributes:
        helpers: first node, second node and share of the second, of each joint; the share is 0
            for a node itself, whose second node is then the first.
        joints: (V, 2) numbers in `helpers`.
        weights: (V, 2), summing to one.
    """

    helpers: list[tuple[int, int, float]]
    joints: NDArray[np.int64]
    weights: Array


def bind(mesh: Mesh, between: int) -> Binding:
    """Return the joints that a mesh follows.

    Args:
        mesh: whose vertices follow at most two nodes.
        between: number of helper joints between two nodes.
    """
    steps = between + 1
    nodes, share = mesh.nodes.astype(int), mesh.weights[:, 1].astype(float)
    alone = share <= 0.0
    first = nodes[:, 0]
    second = np.where(alone, first, nodes[:, 1])
    place = np.where(alone, 0.0, np.clip(share, 0.0, 1.0) * steps)
    low = np.minimum(np.floor(place), steps - 1).astype(int)
    keys = np.stack(
        [np.stack([first, second, np.where(alone, 0, low + k)], axis=-1) for k in range(2)],
        axis=1,
    )
    # The ends of the row are the nodes themselves.
    keys[keys[..., 2] == 0, 1] = keys[keys[..., 2] == 0, 0]
    last = keys[..., 2] == steps
    keys[last, 0] = keys[last, 1]
    keys[last, 2] = 0
    unique, joints = np.unique(keys.reshape(-1, 3), axis=0, return_inverse=True)
    upper = np.where(alone, 0.0, place - low)
    return Binding(
        [(int(a), int(b), k / steps) for a, b, k in unique],
        joints.reshape(-1, 2),
        np.stack([1.0 - upper, upper], axis=-1),
    )
