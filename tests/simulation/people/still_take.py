"""Still take: a take of nodes that stay at rest for two rows, for tests of meshes."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np

from pipeline.simulation.spatial import Array, quaternion
from pipeline.simulation.take import Face, Mesh, Node, Part


def still_take(
    nodes: tuple[Node, ...],
    meshes: list[Mesh],
    parts: tuple[Part, ...],
    faces: tuple[Face, ...],
    expressions: Array,
) -> Any:
    """Return what skinning reads of a take."""
    count = len(nodes)
    return SimpleNamespace(
        nodes=nodes,
        meshes=meshes,
        parts=parts,
        faces=faces,
        expressions=expressions,
        rotations=quaternion(np.tile(np.eye(3), (2, count, 1, 1))),
        positions=np.tile(np.array([node.rest for node in nodes]), (2, 1, 1)),
        scales=np.zeros((2, 0, 3)),
        scaled=(),
        alive=np.ones((2, count), bool),
        header=SimpleNamespace(rate=Fraction(24), samples=4),
    )
