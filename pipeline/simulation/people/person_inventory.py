"""Person inventory: the frames, meshes and parts of a person in a take, whatever room moves it."""

from __future__ import annotations

from pipeline.simulation.people.body_frames import FRAMES, PARENTS, frame_origins
from pipeline.simulation.people.person_mesh import layer_parts, person_layers
from pipeline.simulation.people.proportions import Proportions
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.simulation.take import Mesh, Node, Part


def person_record(
    name: str, proportions: Proportions, clothes: Clothes, first: int, mesh: int, rows: int
) -> tuple[list[Node], list[Mesh], list[Part]]:
    """Return the fifteen nodes of a person, in the order of `FRAMES`, its meshes and its parts.

    Args:
        name: of the person.
        proportions: of the person.
        clothes: that it wears.
        first: number of its first node.
        mesh: number of its first mesh.
        rows: number of rows of the take, for which parts live.
    """
    nodes = [
        Node(
            f"{name}.{frame}",
            name,
            first + parent if parent >= 0 else -1,
            (float(x), float(y), float(z)),
        )
        for frame, parent, (x, y, z) in zip(
            FRAMES, PARENTS, frame_origins(proportions), strict=True
        )
    ]
    meshes, parts = layer_parts(name, person_layers(proportions, clothes), first, mesh, rows)
    return nodes, meshes, parts
