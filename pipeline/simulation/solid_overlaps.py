"""Solid overlaps: how deep the convex solids of performers are in one another.

A part that is not convex, such as a ring or a room, is left out, since what stands in its hull may
well be outside of it.

Source: Ericson 2005, 3.11 (Minkowski differences).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from pipeline.simulation.members import Members
from pipeline.simulation.obstacles import directions, outermost
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Mesh
from pipeline.spec.cast import Member

TOLERANCE = 0.02
"""Depth that counts as touching [m]."""

THIN = 0.2
"""Depth that counts as touching, in the smallest extent of the thinner solid."""

BULGE = 0.05
"""Height of a convex part above the planes of its faces, in its extent."""

SUPPORT: Array = directions(400)
"""Directions in which the outermost points of large hulls are looked for."""


class PlacedSolid(NamedTuple):
    """A convex solid in the world.

    Attributes:
        part: name of the part.
        node: that it follows.
        corners: (n, 3) [m].
    """

    part: str
    node: int
    corners: Array


def solids_of(
    name: str, members: Members, recorder: Recorder, skins: Sequence[PlacedSolid] | None = None
) -> list[PlacedSolid]:
    """Returns the solids of a performer; a skin has one for each node that it follows.

    Args:
        name: of the performer.
        members: of the cast, at the row.
        recorder: the take.
        skins: the result of `skin_solids`, if it is known.
    """
    row = members.row
    solids = [PlacedSolid(s.name, s.node, corners) for s, corners in members.solids(name)]
    for part, node, rest in skin_solids(name, recorder) if skins is None else skins:
        R = matrix(recorder.quaternions[row, node])
        solids.append(PlacedSolid(part, node, recorder.positions[row, node] + rest @ R.T))
    return solids


def skin_solids(name: str, recorder: Recorder) -> list[PlacedSolid]:
    """Returns the solids of a performer's skins, relative to the nodes that they follow."""
    solids = []
    for part in recorder.parts_by_performer.get(name, ()):
        mesh = recorder.meshes[part.mesh]
        if _is_rigid(mesh):
            continue
        nearest = np.take_along_axis(mesh.nodes, mesh.weights.argmax(axis=1)[:, None], axis=1)
        for node in np.unique(nearest).tolist():
            rest = mesh.vertices[nearest[:, 0] == node].astype(float) - recorder.nodes[node].rest
            solids.append(PlacedSolid(part.name, node, outermost(rest)))
    return solids


def _is_rigid(mesh: Mesh) -> bool:
    return bool((mesh.nodes == mesh.nodes[0, 0]).all())


def assemblies(cast: Sequence[Member]) -> dict[str, str]:
    """Returns, by name, one member of all those that parents and hands connect."""
    root = {member.name: member.name for member in cast}

    def find(name: str) -> str:
        while root[name] != name:
            name = root[name]
        return name

    for member in cast:
        holders = [hold.by for hold in getattr(member, "held", ())]
        for holder in [*holders, *([member.parent] if member.parent else [])]:
            root[find(member.name)] = find(holder.partition(".")[0])
    return {name: find(name) for name in root}


def bent_parts(recorder: Recorder) -> Callable[[str], bool]:
    """Returns a function that tells whether a part, by its name, is not convex."""
    meshes = {part.name: recorder.meshes[part.mesh] for part in recorder.parts}
    # Herds have many parts of one shape.
    shapes: dict[tuple[bytes, bytes, bool], bool] = {}

    @cache
    def is_bent(name: str) -> bool:
        if name not in meshes:
            return False
        mesh = meshes[name]
        shape = mesh.vertices.tobytes(), mesh.faces.tobytes(), _is_rigid(mesh)
        if shape not in shapes:
            shapes[shape] = _is_bent(mesh)
        return shapes[shape]

    return is_bent


def deepest_overlap(
    one: Sequence[PlacedSolid],
    other: Sequence[PlacedSolid],
    is_bent: Callable[[str], bool],
    boxes: tuple[Array, Array] | None = None,
    least: float = 0.0,
) -> float:
    """Returns the largest depth of the solids of two performers, 0 if they only touch [m].

    Args:
        one: solids of the first.
        other: solids of the second.
        is_bent: whether a part is not convex.
        boxes: of the solids of both, see `boxes_of`, if they are known.
        least: depth that counts; 0 is returned for less [m].
    """
    if boxes is None:
        boxes = boxes_of([s.corners for s in one]), boxes_of([s.corners for s in other])
    own, others = boxes
    return _deepest(((one[i], other[j]) for i, j in overlapping(own, others)), is_bent, least)


def boxes_of(points: Sequence[Array]) -> Array:
    """Returns the lowest and highest corners (n, 2, 3) of sets of points [m]."""
    if not len(points):
        return np.zeros((0, 2, 3))
    every = np.concatenate(points)
    first = np.concatenate([[0], np.cumsum([len(p) for p in points])[:-1]])
    return np.stack([np.minimum.reduceat(every, first), np.maximum.reduceat(every, first)], axis=1)


def overlapping(one: Array, other: Array) -> list[tuple[int, int]]:
    """Returns the pairs of boxes (n, 2, 3) and (m, 2, 3) that overlap."""
    apart = np.maximum(one[:, None, 0] - other[None, :, 1], other[None, :, 0] - one[:, None, 1])
    return [(int(i), int(j)) for i, j in np.argwhere(apart.max(axis=-1, initial=-np.inf) < 0.0)]


def _deepest(
    pairs: Iterable[tuple[PlacedSolid, PlacedSolid]],
    is_bent: Callable[[str], bool],
    floor: float = 0.0,
) -> float:
    """Returns the largest depth of pairs of solids, 0 if they only touch or up to `floor` [m]."""
    bounds = [(depth_bound(a.corners, b.corners), a, b) for a, b in pairs]
    deepest = 0.0
    for bound, (one, _, a), (other, _, b) in sorted(bounds, key=lambda pair: -pair[0]):
        if bound <= max(deepest, floor):
            break
        thinnest = min(float(np.ptp(points, axis=0).min()) for points in (a, b))
        least = max(min(TOLERANCE, THIN * thinnest), deepest)
        if bound > least and not is_bent(one) and not is_bent(other):
            depth = convex_depth(a, b)
            deepest = depth if depth > least else deepest
    return deepest if deepest > floor else 0.0


def depth_bound(a: Array, b: Array) -> float:
    """Returns an upper bound on the depth of two convex hulls: along a few directions [m]."""
    ways = directions().T
    reach = (a @ ways).max(axis=0) - (b @ ways).min(axis=0)
    return float(reach.min())


def convex_depth(a: Array, b: Array) -> float:
    """Returns the least motion that parts the hulls of points (n, 3) and (m, 3) [m].

    That is the distance of the origin from the surface of their Minkowski difference.
    """
    differences = (a[:, None] - b[None]).reshape(-1, 3)
    if len(differences) > len(SUPPORT):
        # Inner points take most of the time. Those that are outermost in many directions are the
        # hull but for less than a hundredth of its width.
        ahead, behind = (a @ SUPPORT.T).argmax(axis=0), (b @ SUPPORT.T).argmin(axis=0)
        differences = differences[np.unique(ahead * len(b) + behind)]
    # Joggled, so that points in one plane are no error.
    return max(0.0, float(-ConvexHull(differences, qhull_options="QJ").equations[:, 3].max()))


def _is_bent(mesh: Mesh) -> bool:
    """Returns whether a rigid part lies on both sides of one of its faces."""
    if not _is_rigid(mesh):
        return False
    a, b, c = mesh.vertices.astype(float)[mesh.faces.astype(np.int64)].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    corners = outermost(mesh.vertices.astype(float))
    above = normals @ corners.T - (normals * a[lengths > 0.0]).sum(axis=1)[:, None]
    return bool(above.max() > BULGE * np.ptp(corners, axis=0).max())
