"""Member meshes: the small solids that members of groups are made of, about their nodes.

X is ahead and Y up. Every member has the same few triangles, and a group is one part: a member
costs a node or three, not a mesh.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.simulation.figures.solids import Solid, join_solids, loft
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Node, Part

RING_SIDES = 6
"""Sides of round shapes."""


def spindle(places: Array, heights: Array, widths: Array) -> Solid:
    """Return a solid along X with elliptic rings: places, half heights and half widths [m]."""
    angle = np.arange(RING_SIDES) * (2.0 * np.pi / RING_SIDES)
    rings = np.zeros((len(places), RING_SIDES, 3))
    rings[..., 0] = places[:, None]
    rings[..., 1] = heights[:, None] * np.cos(angle)
    rings[..., 2] = widths[:, None] * np.sin(angle)
    return loft(rings, np.array([[places[0], 0.0, 0.0], [places[-1], 0.0, 0.0]]))


def plate(outline: Array, thickness: float) -> Solid:
    """Returns a thin plate over a convex outline (n, 2) of x and z, turning from z to x [m]."""
    n = len(outline)
    flat = np.stack([outline[:, 0], np.zeros(n), outline[:, 1]], axis=-1)
    middle = flat.mean(axis=0)
    up = np.array([0.0, 0.5 * thickness, 0.0])
    # A lens: its rim has no height, so one ring and two points suffice.
    faces = [(k, (k + 1) % n, n) for k in range(n)] + [((k + 1) % n, k, n + 1) for k in range(n)]
    vertices = np.concatenate([flat, [middle + up, middle - up]])
    return Solid(vertices, np.array(faces, dtype=np.uint32))


def bird(span: float) -> Solid:
    """Return the body of a bird."""
    x = np.array([-0.20, -0.10, 0.04, 0.16, 0.24, 0.30]) * span
    high = np.array([0.008, 0.035, 0.055, 0.042, 0.034, 0.004]) * span
    tail = np.array([[-0.16, -0.02], [-0.34, -0.07], [-0.36, 0.0], [-0.34, 0.07], [-0.16, 0.02]])
    return join_solids([spindle(x, high, 1.05 * high), plate(tail * span, 0.012 * span)])


def wing(span: float, side: float) -> Solid:
    """Returns a wing from its hinge outward; `side` is 1 on the right and -1 on the left."""
    right = np.array(
        [[0.11, 0.0], [-0.08, 0.0], [-0.07, 0.2], [-0.10, 0.47], [0.03, 0.34], [0.13, 0.18]]
    )
    outline = right * np.array([1.0, side]) * span
    return plate(outline if side > 0.0 else outline[::-1], 0.014 * span)


def fish(length: float) -> Solid:
    """Return the body of a fish up to its tail."""
    x = np.array([-0.30, -0.14, 0.06, 0.26, 0.40, 0.5]) * length
    high = np.array([0.035, 0.10, 0.15, 0.13, 0.075, 0.01]) * length
    return spindle(x, high, 0.42 * high)


def fin(length: float) -> Solid:
    """Returns the tail of a fish from its hinge backward."""
    x = np.array([-0.22, -0.16, -0.08, 0.02]) * length
    return spindle(x, np.array([0.15, 0.09, 0.045, 0.036]) * length, np.full(4, 0.012 * length))


def insect(length: float) -> Solid:
    """Return an insect with its wings."""
    body = spindle(
        np.array([-0.5, -0.2, 0.2, 0.5]) * length,
        np.array([0.05, 0.17, 0.17, 0.08]) * length,
        np.array([0.05, 0.17, 0.17, 0.08]) * length,
    )
    wings = [wing(1.3 * length, side) for side in (1.0, -1.0)]
    lift = np.array([0.0, 0.16 * length, 0.0])
    return join_solids([body, *(Solid(w.vertices + lift, w.faces) for w in wings)])


def drop(length: float) -> Solid:
    """Returns a drop, elongated along its fall."""
    y = np.array([-0.5, -0.42, -0.2, 0.5]) * length
    wide = np.array([0.02, 0.05, 0.06, 0.008]) * length
    solid = spindle(y, wide, wide)
    return Solid(solid.vertices[:, [2, 0, 1]], solid.faces)


def flame(size: float) -> Solid:
    """Return a flame, higher than wide."""
    y = np.array([-0.42, -0.25, 0.0, 0.3, 0.62]) * size
    wide = np.array([0.12, 0.34, 0.42, 0.22, 0.02]) * size
    solid = spindle(y, wide, wide)
    return Solid(solid.vertices[:, [2, 0, 1]], solid.faces)


def inventory(
    name: str,
    material: str,
    rows: int,
    count: int,
    pieces: Sequence[tuple[str, Solid]],
    size: float,
    scaled: bool = False,
) -> Inventory:
    """Return what `count` members add to a take: the nodes of all first pieces, then the next.

    Args:
        name: of the group.
        material: of all of it.
        rows: of the take.
        count: of members.
        pieces: what each is made of: ends of the nodes' names, and solids about them.
        size: of one member [m].
        scaled: whether its nodes have a scale.
    """
    nodes, solids, follows = list[Node](), list[Solid](), list[int]()
    for suffix, solid in pieces:
        for i in range(count):
            follows += [len(nodes)] * len(solid.vertices)
            nodes.append(Node(f"{name}.{i}{suffix}", name, -1, (0.0, 0.0, 0.0)))
            solids.append(solid)
    whole = join_solids(solids)
    mesh = Mesh(
        whole.vertices.astype(np.float32),
        whole.faces,
        np.repeat(np.array(follows, dtype=np.int32)[:, None], 2, axis=1),
        np.tile(np.array([1.0, 0.0], dtype=np.float32), (len(follows), 1)),
    )
    part = Part(name, name, 0, material, size, (0, rows))
    return Inventory(tuple(nodes), (), (mesh,), (part,), tuple(range(len(nodes))) if scaled else ())
