"""Looks: what is seen of dancers: a clothed person on its frames, and the drums before it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.dancers.torso import LINKS, Torso
from pipeline.simulation.figures.solids import Solid, lofted
from pipeline.simulation.people.clothes import Clothes
from pipeline.simulation.people.flesh import dressed, worn
from pipeline.simulation.people.frames import FRAMES, frame_origins
from pipeline.simulation.people.proportions import Proportions
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel, Mesh, Node, Part
from pipeline.simulation.troupe import Inventory
from pipeline.spec.dance import Drum

AROUND, RIM = 48, 0.006
"""Sides of a drum, and how much its rims are rounded [m]."""

FIXED = "pelvis"
"""The link that frames go with which no link moves: the legs stand still."""


@dataclass(frozen=True, eq=False)
class Look:
    """A dancer as it is seen.

    Attributes:
        name: its.
        proportions: its.
        clothes: that it wears.
        drums: that stand before it, by name.
    """

    name: str
    proportions: Proportions
    clothes: Clothes
    drums: dict[str, Drum]

    @property
    def count(self) -> int:
        """Number of its nodes: frames, then drums."""
        return len(FRAMES) + len(self.drums)

    def rest(self) -> Array:
        """Return (count, 3) where its nodes are at rest [m]."""
        tops = [np.array(drum.at) for drum in self.drums.values()]
        return np.concatenate([frame_origins(self.proportions), *[top[None] for top in tops]])


def links_of_frames() -> list[int]:
    """Return the link that each frame of a person goes with."""
    return [LINKS.index(frame if frame in LINKS else FIXED) for frame in FRAMES]


def inventory_of(looks: Sequence[Look], torsos: Sequence[Torso], rows: int) -> Inventory:
    """Return what dancers add to a take."""
    nodes, channels = list[Node](), list[Channel]()
    meshes, parts = list[Mesh](), list[Part]()
    for look, torso in zip(looks, torsos, strict=True):
        first, rest = len(nodes), look.rest().tolist()
        for name, place in zip((*FRAMES, *look.drums), rest, strict=True):
            nodes.append(Node(f"{look.name}.{name}", look.name, -1, (place[0], place[1], place[2])))
        layers = dressed(look.proportions, look.clothes)
        own, seen = worn(look.name, layers, first, len(meshes), rows)
        meshes += own
        parts += seen
        for k, (name, drum) in enumerate(look.drums.items()):
            meshes.append(_drum_mesh(drum, first + len(FRAMES) + k))
            size = 2.0 * drum.radius
            whole = f"{look.name}.{name}"
            parts.append(Part(whole, look.name, len(meshes) - 1, drum.material, size, (0, rows)))
        channels += [Channel(f"{look.name}.{joint}", "rad") for joint in torso.names]
        channels += [Channel(f"{look.name}.{joint}.torque", "N m") for joint in torso.names]
    return Inventory(tuple(nodes), tuple(channels), tuple(meshes), tuple(parts))


def _drum_mesh(drum: Drum, node: int) -> Mesh:
    solid = _drum(drum)
    count = len(solid.vertices)
    return Mesh(
        solid.vertices.astype(np.float32),
        solid.faces,
        np.full((count, 2), node, dtype=np.int32),
        np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1)),
    )


def _drum(drum: Drum) -> Solid:
    """Return an upright cylinder below the middle of its top, its rims rounded."""
    angle = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    ring = np.stack([np.sin(angle), np.zeros(AROUND), np.cos(angle)], axis=-1)
    low, outer, inner = -drum.height, drum.radius, drum.radius - RIM
    levels = ((inner, low), (outer, low + RIM), (outer, -RIM), (inner, 0.0))
    rings = np.stack([radius * ring + [0.0, y, 0.0] for radius, y in levels])
    solid = lofted(rings, rings[[0, -1]].mean(axis=1))
    return Solid(solid.vertices + np.array(drum.at), solid.faces)
