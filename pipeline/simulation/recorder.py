"""Recorder: collects rows and facts until they are a take.

Rows come in batches. A batch is written as positions and matrices, in which performers can
be hung on one another; once whole it is kept as the take has it, in reels that lie on disk
where they are long. What grows in memory with the length of a film is the list of contacts
and sound events alone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.attachment import Attachment
from pipeline.simulation.clock import Clock
from pipeline.simulation.row_storage import allocate_rows, release_rows
from pipeline.simulation.script import Orders
from pipeline.simulation.solid import Obstacle
from pipeline.simulation.spatial import Array, continuous, matrix, quaternion
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
    Told,
)
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import Inventory, Rows
from pipeline.spec.script import order_text


class Recorder:
    """The take while it grows."""

    def __init__(
        self, header: Header, clock: Clock, ground: Ground, inventories: Sequence[Inventory]
    ) -> None:
        self.header = header
        self.clock = clock
        self.ground = ground
        self.nodes, self.meshes, self.parts = _joined(inventories)
        self._looks = _looks(inventories)
        self.channels = tuple(c for inventory in inventories for c in inventory.channels)
        self._slices = _slices(inventories)
        self.scaled = _scaled(inventories)
        rows, nodes = clock.rows, len(self.nodes)
        self.positions = allocate_rows((rows, nodes, 3), float)
        self.quaternions = allocate_rows((rows, nodes, 4), float)
        self.alive = allocate_rows((rows, nodes), bool)
        self.values = allocate_rows((rows, len(self.channels)), float)
        self.scales = allocate_rows((rows, len(self.scaled), 3), float)
        self._R = np.zeros((0, nodes, 3, 3))
        self._first = 0
        self.contacts: list[Contact] = []
        self.events: list[SoundEvent] = []
        self._notes: dict[tuple[str, str], Note] = {}
        self.orders: list[Told] = []

    def attach(self, bonds: Iterable[Attachment]) -> None:
        """Let performers hang on the nodes that they go along with."""
        nodes = list(self.nodes)
        for bond in bonds:
            for i in bond.nodes:
                if nodes[i].parent < 0:
                    nodes[i] = replace(nodes[i], parent=bond.parent)
        self.nodes = tuple(nodes)

    @property
    def rotations(self) -> Array:
        """Matrices (K, J, 3, 3) of the nodes in all rows, worked out anew."""
        return matrix(self.quaternions)

    def rows(self, which: slice, first: int = -1) -> list[Rows]:
        """Return each troupe's slice of the rows `which`, to be written into.

        Args:
            which: the rows.
            first: of those that are kept together with them, which may be written one after the
                other; of `which` unless told.
        """
        if first < 0:
            self._first = which.start
            self._R[:] = 0.0
        elif first != self._first:
            self._first = first
            self._R[:] = 0.0
        room = which.stop - self._first
        if len(self._R) < room:
            more = np.zeros((room - len(self._R), *self._R.shape[1:]))
            self._R = np.concatenate([self._R, more])
        R = self._turned(which)
        return [
            Rows(
                self.positions[which, nodes],
                R[:, nodes],
                self.alive[which, nodes],
                self.values[which, channels],
                self.scales[which, scales],
            )
            for nodes, channels, scales in self._slices
        ]

    def _turned(self, which: slice) -> Array:
        """Return the rotations (n, J, 3, 3) of rows that are not kept yet."""
        R: Array = self._R[which.start - self._first : which.stop - self._first]
        return R

    def show(self, which: slice, nodes: NDArray[np.int64]) -> None:
        """Let nodes be seen in rows that are not kept yet, but in which they are in the world."""
        self.quaternions[which, nodes] = quaternion(self._turned(which)[:, nodes])

    def attached(self, which: slice, bonds: Iterable[Attachment]) -> tuple[Array, Array]:
        """Bring all nodes of the rows `which` into the world, all troupes having written theirs.

        Args:
            which: the rows after those that were kept before.
            bonds: what goes along with what, parents first.

        Returns:
            Rotations (n, J, 3, 3) and positions (n, J, 3) [m], which may still be written into.
        """
        R, p = self._turned(which), self.positions[which]
        for bond in bonds:
            bond.apply(R, p, which.start)
        return R, p

    def keep(self, which: slice) -> tuple[int, str] | None:
        """Keep the rows `which`, all nodes being in the world.

        Returns:
            The first row with a pose that is not finite, and its node; None if all are.
        """
        R, p = self._turned(which), self.positions[which]
        if not (np.isfinite(p).all() and np.isfinite(R).all()):
            row, node = np.argwhere(~np.isfinite(p.sum(axis=-1) + R.sum(axis=(-1, -2))))[0]
            return which.start + int(row), self.nodes[int(node)].name
        # The sign goes on from the last row before.
        last = self.quaternions[max(which.start - 1, 0) : which.start]
        run = continuous(np.concatenate([last, quaternion(R)]))
        self.quaternions[which] = run[len(last) :]
        for rows in (self.positions, self.quaternions, self.alive, self.values, self.scales):
            release_rows(rows)
        return None

    def solids(
        self, obstacles: Iterable[Obstacle], names: Collection[str], row: int
    ) -> dict[str, list[Array]]:
        """Return the corners (n, 3) of the solids of performers in a row that is kept [m]."""
        found: dict[str, list[Array]] = {name: [] for name in names}
        for one in obstacles:
            if one.performer in found and self.alive[row, one.node]:
                corners = one.corners
                if one.node in self.scaled:
                    corners = corners * self.scales[row, self.scaled.index(one.node)]
                R = matrix(self.quaternions[row, one.node])
                found[one.performer].append(self.positions[row, one.node] + corners @ R.T)
        return found

    def happened(
        self,
        contacts: Iterable[Contact],
        events: Iterable[SoundEvent],
        notes: Iterable[Note],
    ) -> None:
        """Keep what happened in one step; of notes of a kind on a part the first is kept."""
        self.contacts.extend(contacts)
        self.events.extend(events)
        for note in notes:
            of = note.kind, note.part
            # Some are known only when their rows are written.
            if of not in self._notes or note.step < self._notes[of].step:
                self._notes[of] = note

    @property
    def notes(self) -> list[Note]:
        """What the author should know so far, in the order of time."""
        return sorted(self._notes.values(), key=lambda note: (note.step, note.part, note.kind))

    def told(self, step: int, orders: Orders) -> None:
        """Keep what the script asks of whom from `step` on."""
        for who, given in orders.items():
            self.orders.extend(Told(step, who, order_text(do)) for do in given)

    def take(self) -> Take:
        """Return the finished take."""
        field = self.ground.field
        return Take(
            header=self.header,
            nodes=self.nodes,
            positions=self.positions,
            rotations=self.quaternions,
            alive=self.alive,
            scales=self.scales,
            scaled=self.scaled,
            channels=self.channels,
            values=self.values,
            meshes=self.meshes + self._looks,
            parts=_seen(self.parts, len(self.meshes)),
            terrain=TerrainRecord(
                field.vertices,
                field.faces,
                field.cells,
                self.ground.forbidden,
                self.ground.material,
            ),
            # Some are told of later than they happen: what rolls, when it has ended.
            contacts=tuple(sorted(self.contacts, key=lambda c: (c.step, c.fraction))),
            events=tuple(sorted(self.events, key=lambda e: (e.step, e.fraction))),
            notes=tuple(self.notes),
            told=tuple(self.orders),
        )


def _joined(
    inventories: Sequence[Inventory],
) -> tuple[tuple[Node, ...], tuple[Mesh, ...], tuple[Part, ...]]:
    """Put inventories one after the other, their numbers counted on."""
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    first_look = 0
    for inventory in inventories:
        first_node, first_mesh = len(nodes), len(meshes)
        for node in inventory.nodes:
            parent = node.parent + first_node if node.parent >= 0 else -1
            nodes.append(replace(node, parent=parent))
        meshes.extend(
            replace(mesh, nodes=(mesh.nodes + first_node).astype(np.int32))
            for mesh in inventory.meshes
        )
        parts.extend(
            replace(part, mesh=part.mesh + first_mesh, look=_counted(part.look, first_look))
            for part in inventory.parts
        )
        first_look += len(inventory.looks)
    return tuple(nodes), tuple(meshes), tuple(parts)


def _looks(inventories: Sequence[Inventory]) -> tuple[Mesh, ...]:
    """Put the looks of inventories one after the other."""
    looks, first = list[Mesh](), 0
    for inventory in inventories:
        looks.extend(
            replace(mesh, nodes=(mesh.nodes + first).astype(np.int32)) for mesh in inventory.looks
        )
        first += len(inventory.nodes)
    return tuple(looks)


def _seen(parts: Sequence[Part], first: int) -> tuple[Part, ...]:
    """Return parts whose looks stand after the `first` meshes of a take."""
    return tuple(replace(part, look=_counted(part.look, first)) for part in parts)


def _counted(look: int, first: int) -> int:
    """Return the number of a look that is counted from `first` on."""
    return look + first if look >= 0 else look


def _scaled(inventories: Sequence[Inventory]) -> tuple[int, ...]:
    scaled, first = list[int](), 0
    for inventory in inventories:
        scaled += [first + node for node in inventory.scaled]
        first += len(inventory.nodes)
    return tuple(scaled)


def _slices(inventories: Sequence[Inventory]) -> list[tuple[slice, slice, slice]]:
    """Return where each one's nodes, channels and scales are."""
    slices, before = [], (0, 0, 0)
    for inventory in inventories:
        counts = len(inventory.nodes), len(inventory.channels), len(inventory.scaled)
        after = before[0] + counts[0], before[1] + counts[1], before[2] + counts[2]
        nodes, channels, scales = map(slice, before, after)
        slices.append((nodes, channels, scales))
        before = after
    return slices
