"""Inventories: nodes, channels, meshes and parts that troupes add to the take."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.obstacles import Obstacle, outermost
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel, Face, Mesh, Node, Part

MIN_EXTENT = 1e-4
"""Extent below which a part is no obstacle [m]."""


@dataclass(frozen=True, slots=True)
class Inventory:
    """Nodes, channels, meshes and parts of one troupe; node numbers start at 0 in each troupe.

    Attributes:
        nodes: moving frames.
        channels: scalar time series.
        meshes: collision geometry that follows the nodes.
        parts: visible solids.
        scaled: numbers of the nodes that have a scale.
        looks: render meshes that replace meshes of parts; `Part.look` indexes them.
        solids: obstacles that replace the convex hulls of parts on the same nodes.
        faces: performers whose faces move.
    """

    nodes: tuple[Node, ...]
    channels: tuple[Channel, ...]
    meshes: tuple[Mesh, ...]
    parts: tuple[Part, ...]
    scaled: tuple[int, ...] = ()
    looks: tuple[Mesh, ...] = ()
    solids: tuple[Obstacle, ...] = ()
    faces: tuple[Face, ...] = ()


def join_inventories(inventories: Iterable[Inventory]) -> Inventory:
    """Returns one inventory of all, with continuous numbers of nodes, meshes and looks."""
    nodes, meshes, looks = list[Node](), list[Mesh](), list[Mesh]()
    channels, parts, scaled, solids = list[Channel](), list[Part](), list[int](), list[Obstacle]()
    faces = list[Face]()
    for own in inventories:
        first = len(nodes)
        faces += own.faces
        if not (nodes or meshes or looks):
            # Those of the first keep their numbers, and there may be 100,000 of them.
            nodes, meshes, looks = [*own.nodes], [*own.meshes], [*own.looks]
            channels, parts, scaled = [*own.channels], [*own.parts], [*own.scaled]
            solids = [*own.solids]
            continue
        parts += [
            replace(part, mesh=part.mesh + len(meshes), look=shifted_look(part, len(looks)))
            for part in own.parts
        ]
        meshes += [_on_nodes_from(mesh, first) for mesh in own.meshes]
        looks += [_on_nodes_from(mesh, first) for mesh in own.looks]
        nodes += [
            replace(node, parent=node.parent + first if node.parent >= 0 else -1)
            for node in own.nodes
        ]
        channels += own.channels
        scaled += [first + node for node in own.scaled]
        solids += [replace(solid, node=first + solid.node) for solid in own.solids]
    return Inventory(
        *(tuple(nodes), tuple(channels), tuple(meshes), tuple(parts)),
        *(tuple(scaled), tuple(looks), tuple(solids), tuple(faces)),
    )


def shifted_look(part: Part, first: int) -> int:
    """Returns the number of a part's look among looks that start at number `first`."""
    return part.look + first if part.look >= 0 else part.look


def _on_nodes_from(mesh: Mesh, first: int) -> Mesh:
    return replace(mesh, nodes=(mesh.nodes + first).astype(np.int32))


def rigid_mesh(solid: Solid, node: int) -> Mesh:
    """Returns the mesh of a solid that follows one node."""
    count = len(solid.vertices)
    return Mesh(
        solid.vertices.astype(np.float32),
        solid.faces,
        np.full((count, 2), node, dtype=np.int32),
        np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1)),
    )


def obstacles_of(inventories: Sequence[Inventory]) -> list[Obstacle]:
    """Returns the obstacles of troupes, whose nodes stand in the take in this order."""
    found, first = list[Obstacle](), 0
    hulls: dict[tuple[int, tuple[float, ...]], Array] = {}
    for inventory in inventories:
        own = [replace(solid, node=first + solid.node) for solid in inventory.solids]
        replaced = {solid.node for solid in own}
        for part in inventory.parts:
            hull = _hull_of_part(inventory, part, inventory.meshes[part.mesh], first, hulls)
            if hull is not None and hull.node not in replaced:
                own.append(hull)
        found += own
        first += len(inventory.nodes)
    return found


def _hull_of_part(
    inventory: Inventory,
    part: Part,
    mesh: Mesh,
    first: int,
    hulls: dict[tuple[int, tuple[float, ...]], Array],
) -> Obstacle | None:
    """Returns the obstacle of a rigid part; `hulls` holds the corners of those before."""
    node = int(mesh.nodes[0, 0])
    if not (mesh.nodes == node).all():
        return None
    # Creatures of one figure share the arrays of their meshes, which live as long as these.
    key = id(mesh.vertices), inventory.nodes[node].rest
    if key not in hulls:
        hulls[key] = outermost(mesh.vertices.astype(float) - inventory.nodes[node].rest)
    corners = hulls[key]
    if float(np.ptp(corners, axis=0).min()) < MIN_EXTENT:
        return None
    return Obstacle(first + node, part.name, part.performer, part.material, corners)
