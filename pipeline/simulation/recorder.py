"""Recorder: collects rows and facts until they are a take."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.attaching import Bond
from pipeline.simulation.clock import Clock
from pipeline.simulation.spatial import continuous, quaternion
from pipeline.simulation.take import (
    Contact,
    Header,
    Mesh,
    Node,
    Note,
    Part,
    SoundEvent,
    Take,
    TerrainRecord,
)
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import Inventory, Rows


class Recorder:
    """The take while it grows."""

    def __init__(
        self, header: Header, clock: Clock, ground: Ground, inventories: Sequence[Inventory]
    ) -> None:
        self.header = header
        self.clock = clock
        self.ground = ground
        self.nodes, self.meshes, self.parts = _joined(inventories)
        self.channels = tuple(c for inventory in inventories for c in inventory.channels)
        self._slices = _slices(inventories)
        rows, nodes = clock.rows, len(self.nodes)
        self.positions = np.zeros((rows, nodes, 3))
        self.rotations = np.zeros((rows, nodes, 3, 3))
        self.alive = np.zeros((rows, nodes), dtype=bool)
        self.values = np.zeros((rows, len(self.channels)))
        self.contacts: list[Contact] = []
        self.events: list[SoundEvent] = []
        self._notes: dict[tuple[str, str], Note] = {}

    def hang(self, bonds: Iterable[Bond]) -> None:
        """Let performers hang on the nodes that they go along with."""
        nodes = list(self.nodes)
        for bond in bonds:
            for i in bond.nodes:
                if nodes[i].parent < 0:
                    nodes[i] = replace(nodes[i], parent=bond.parent)
        self.nodes = tuple(nodes)

    def rows(self, which: slice) -> list[Rows]:
        """Return each troupe's slice of the rows `which`, to be written into."""
        return [
            Rows(
                self.positions[which, nodes],
                self.rotations[which, nodes],
                self.alive[which, nodes],
                self.values[which, channels],
            )
            for nodes, channels in self._slices
        ]

    def not_finite(self, which: slice) -> tuple[int, str] | None:
        """Return the first of the rows `which` with a pose that is not finite, and its node."""
        poses = self.positions[which].sum(axis=-1) + self.rotations[which].sum(axis=(-1, -2))
        wrong = np.argwhere(~np.isfinite(poses))
        if not len(wrong):
            return None
        row, node = wrong[0]
        return which.start + int(row), self.nodes[int(node)].name

    def happened(
        self,
        contacts: Iterable[Contact],
        events: Iterable[SoundEvent],
        notes: Iterable[Note],
    ) -> None:
        """Keep what happened in one step; a note is kept once for each part and kind."""
        self.contacts.extend(contacts)
        self.events.extend(events)
        for note in notes:
            self._notes.setdefault((note.kind, note.part), note)

    def take(self) -> Take:
        """Return the finished take."""
        rotations = continuous(quaternion(self.rotations))
        field = self.ground.field
        return Take(
            header=self.header,
            nodes=self.nodes,
            positions=self.positions,
            rotations=rotations,
            alive=self.alive,
            scales=np.zeros((len(rotations), 0, 3)),
            scaled=(),
            channels=self.channels,
            values=self.values,
            meshes=self.meshes,
            parts=self.parts,
            terrain=TerrainRecord(
                field.vertices,
                field.faces,
                field.cells,
                self.ground.forbidden,
                self.ground.material,
            ),
            contacts=tuple(self.contacts),
            events=tuple(self.events),
            notes=tuple(self._notes.values()),
        )


def _joined(
    inventories: Sequence[Inventory],
) -> tuple[tuple[Node, ...], tuple[Mesh, ...], tuple[Part, ...]]:
    """Put inventories one after the other, their numbers counted on."""
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    for inventory in inventories:
        first_node, first_mesh = len(nodes), len(meshes)
        for node in inventory.nodes:
            parent = node.parent + first_node if node.parent >= 0 else -1
            nodes.append(replace(node, parent=parent))
        meshes.extend(
            replace(mesh, nodes=(mesh.nodes + first_node).astype(np.int32))
            for mesh in inventory.meshes
        )
        parts.extend(replace(part, mesh=part.mesh + first_mesh) for part in inventory.parts)
    return tuple(nodes), tuple(meshes), tuple(parts)


def _slices(inventories: Sequence[Inventory]) -> list[tuple[slice, slice]]:
    slices, node, channel = [], 0, 0
    for inventory in inventories:
        after = node + len(inventory.nodes), channel + len(inventory.channels)
        slices.append((slice(node, after[0]), slice(channel, after[1])))
        node, channel = after
    return slices
