"""Start overlaps: performers that stand in one another in the first row.

Solids are convex; a part that is not, such as a ring or a room, is left out, since what stands in
its hull may well be outside of it. Parents and hands, with all that goes with them, may overlap.
So may different props, of which authors build things, and limbs that are posed on them.

Source: Ericson 2005, 3.11 (Minkowski differences).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache

import numpy as np
from scipy.spatial import ConvexHull

from pipeline.simulation.members import Members
from pipeline.simulation.obstacles import directions, outermost
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.take import Mesh, TakeNote
from pipeline.spec.cast import Member
from pipeline.spec.group import Group
from pipeline.spec.prop import Prop

TOLERANCE = 0.02
"""Depth that counts as touching [m]."""

THIN = 0.2
"""Depth that counts as touching, in the smallest extent of the thinner solid."""

BULGE = 0.05
"""Height of a convex part above the planes of its faces, in its extent."""

Placed = tuple[str, Array]
"""Name of a part and the corners (n, 3) of a solid of it in the world [m]."""


def overlap_notes(cast: Sequence[Member], members: Members, recorder: Recorder) -> list[TakeNote]:
    """Returns a note on each performer that begins inside of others.

    Args:
        cast: of the scene.
        members: of the cast, in the first row.
        recorder: the take, whose first row is written.
    """
    # The bodies of a group move by its rule.
    names = [member.name for member in cast if not isinstance(member, Group)]
    solids = {name: own for name in names if (own := _solids(name, members, recorder))}
    assembly = _assemblies(cast)
    props = {m.name: m.prop for m in cast if isinstance(m, Prop) and not m.may_fall}
    posed = {member.name for member in cast if getattr(member, "pose", ())}
    meshes = {part.name: recorder.meshes[part.mesh] for part in recorder.parts}
    is_bent = cache(lambda name: name in meshes and _is_bent(meshes[name]))
    found: dict[str, list[str]] = {}
    for one, other in _near_pairs(solids):
        joined = assembly.get(one, one) == assembly.get(other, other)
        is_placed = {one, other} <= props.keys() | posed and not {one, other} <= posed
        if joined or (is_placed and not _are_equal(props, solids, one, other)):
            continue
        depth = _deepest(_meeting(solids[one], solids[other]), is_bent)
        if depth > 0.0:
            # It is rather the prop that stands where its author wants it.
            inner, outer = (other, one) if one in props else (one, other)
            found.setdefault(inner, []).append(f"{depth:.2g} m deep in '{outer}'")
    return [
        TakeNote("overlaps", 0, name, f"begins {' and '.join(texts)}; move one of them")
        for name, texts in found.items()
    ]


def _are_equal(
    props: Mapping[str, object], solids: Mapping[str, Sequence[Placed]], one: str, other: str
) -> bool:
    """Returns whether two props of equal shape stand in the same place."""
    if one not in props or other not in props or props[one] != props[other]:
        return False
    boxes = [_boxes([corners for _, corners in solids[name]]) for name in (one, other)]
    return float(np.abs(boxes[0] - boxes[1]).max()) < TOLERANCE


def _solids(name: str, members: Members, recorder: Recorder) -> list[Placed]:
    """Returns the solids of a performer; a skin has one for each node that it follows."""
    solids = [(solid.name, corners) for solid, corners in members.solids(name)]
    for part in recorder.parts:
        mesh = recorder.meshes[part.mesh]
        if part.performer != name or _is_rigid(mesh):
            continue
        nearest = np.take_along_axis(mesh.nodes, mesh.weights.argmax(axis=1)[:, None], axis=1)
        for node in np.unique(nearest).tolist():
            rest = mesh.vertices[nearest[:, 0] == node].astype(float) - recorder.nodes[node].rest
            R = matrix(recorder.quaternions[0, node])
            solids.append((part.name, recorder.positions[0, node] + outermost(rest) @ R.T))
    return solids


def _is_rigid(mesh: Mesh) -> bool:
    return bool((mesh.nodes == mesh.nodes[0, 0]).all())


def _assemblies(cast: Sequence[Member]) -> dict[str, str]:
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


def _near_pairs(solids: Mapping[str, Sequence[Placed]]) -> Iterator[tuple[str, str]]:
    """Yields the performers whose bounding boxes overlap by more than the tolerance."""
    names = list(solids)
    boxes = _boxes([np.concatenate([corners for _, corners in own]) for own in solids.values()])
    for i, j in _overlapping(boxes, boxes):
        if i < j:
            yield names[i], names[j]


def _meeting(one: Sequence[Placed], other: Sequence[Placed]) -> Iterator[tuple[Placed, Placed]]:
    """Yields the pairs of solids of two performers whose bounding boxes overlap."""
    own, others = (_boxes([corners for _, corners in solids]) for solids in (one, other))
    for i, j in _overlapping(own, others):
        yield one[i], other[j]


def _boxes(points: Sequence[Array]) -> Array:
    """Returns the lowest and highest corners (n, 2, 3) of sets of points [m]."""
    return np.array([(p.min(axis=0), p.max(axis=0)) for p in points]).reshape(-1, 2, 3)


def _overlapping(one: Array, other: Array) -> list[tuple[int, int]]:
    """Returns the pairs of boxes (n, 2, 3) and (m, 2, 3) that overlap."""
    apart = np.maximum(one[:, None, 0] - other[None, :, 1], other[None, :, 0] - one[:, None, 1])
    return [(int(i), int(j)) for i, j in np.argwhere(apart.max(axis=-1, initial=-np.inf) < 0.0)]


def _deepest(pairs: Iterable[tuple[Placed, Placed]], is_bent: Callable[[str], bool]) -> float:
    """Returns the largest depth of pairs of solids, 0 if they only touch [m]."""
    bounds = [(depth_bound(a[1], b[1]), a, b) for a, b in pairs]
    deepest = 0.0
    for bound, (one, a), (other, b) in sorted(bounds, key=lambda pair: -pair[0]):
        if bound <= deepest:
            break
        thinnest = min(float(np.ptp(points, axis=0).min()) for points in (a, b))
        least = max(min(TOLERANCE, THIN * thinnest), deepest)
        if bound > least and not is_bent(one) and not is_bent(other):
            depth = convex_depth(a, b)
            deepest = depth if depth > least else deepest
    return deepest


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
