"""Recorder: collects rows, contacts and events until they are a take.

Rows come in batches. A batch is written as positions and matrices, in which performers can be
attached to one another; a finished batch is stored as the take has it, in arrays that lie on disk
where they are long. Only the lists of contacts and sound events grow in memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.attachment import Attachment
from pipeline.simulation.clock import Clock
from pipeline.simulation.face_units import COLUMNS
from pipeline.simulation.inventory import Inventory, join_inventories, shifted_look
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.row_storage import allocate_rows, release_rows
from pipeline.simulation.spatial import Array, continuous, matrix, quaternion
from pipeline.simulation.take import (
    Contact,
    Header,
    Part,
    SoundEvent,
    Take,
    TakeNote,
    TerrainRecord,
)
from pipeline.simulation.terrain import Ground


class NoteLog:
    """Notes of one simulation: of one kind on one part the earliest is kept.

    Those about keys are all kept: each tells of another.
    """

    def __init__(self) -> None:
        self._notes: dict[tuple[str, str, str], TakeNote] = {}

    def add(self, notes: Iterable[TakeNote]) -> None:
        """Adds notes in any order of time: some are known only when their rows are written."""
        for note in notes:
            key = note.kind, note.part, note.text if note.kind == "missed_key" else ""
            if key not in self._notes or note.step < self._notes[key].step:
                self._notes[key] = note

    @property
    def notes(self) -> list[TakeNote]:
        """Notes so far, in the order of time."""
        return sorted(self._notes.values(), key=lambda note: (note.step, note.part, note.kind))


class Recorder:
    """The take under construction."""

    def __init__(
        self, header: Header, clock: Clock, ground: Ground, inventories: Sequence[Inventory]
    ) -> None:
        self.header = header
        self.clock = clock
        self.ground = ground
        own = join_inventories(inventories)
        self.nodes, self.meshes, self.parts = own.nodes, own.meshes, own.parts
        self.channels, self.scaled, self._looks = own.channels, own.scaled, own.looks
        self._slices = _slices(inventories)
        rows, nodes = clock.rows, len(self.nodes)
        self.positions = allocate_rows((rows, nodes, 3), float)
        self.quaternions = allocate_rows((rows, nodes, 4), float)
        self.alive = allocate_rows((rows, nodes), bool)
        self.values = allocate_rows((rows, len(self.channels)), float)
        self.scales = allocate_rows((rows, len(self.scaled), 3), float)
        self.faces = own.faces
        self.expressions = allocate_rows((rows, len(self.faces), len(COLUMNS)), np.float32)
        # Matrices of the rows that are not stored yet, from row `_first` on.
        self._R = np.zeros((0, nodes, 3, 3))
        self._first = 0
        self.contacts: list[Contact] = []
        self.events: list[SoundEvent] = []
        self._notes = NoteLog()

    def attach(self, attachments: Iterable[Attachment]) -> None:
        """Sets the parents of attached nodes that have none."""
        nodes = list(self.nodes)
        for attachment in attachments:
            for i in attachment.nodes:
                if nodes[i].parent < 0:
                    nodes[i] = replace(nodes[i], parent=attachment.parent)
        self.nodes = tuple(nodes)

    @cached_property
    def parts_by_performer(self) -> Mapping[str, Sequence[Part]]:
        """The parts of each performer, in their order."""
        found = dict[str, list[Part]]()
        for part in self.parts:
            found.setdefault(part.performer, []).append(part)
        return found

    @cached_property
    def nodes_by_performer(self) -> Mapping[str, Sequence[int]]:
        """Numbers of the nodes of each performer, in their order."""
        found = dict[str, list[int]]()
        for number, node in enumerate(self.nodes):
            found.setdefault(node.performer, []).append(number)
        return found

    @property
    def rotations(self) -> Array:
        """Matrices (K, J, 3, 3) of the nodes in all rows, computed anew."""
        return matrix(self.quaternions)

    def rows(self, which: slice, first: int = -1) -> list[Rows]:
        """Returns each troupe's writable slice of some rows.

        Args:
            which: the rows.
            first: first row of the batch that they are stored with; their own first by default.
        """
        if first < 0 or first != self._first:
            self._first = which.start if first < 0 else first
            self._R[:] = 0.0
        count = which.stop - self._first
        if len(self._R) < count:
            more = np.zeros((count - len(self._R), *self._R.shape[1:]))
            self._R = np.concatenate([self._R, more])
        R = self._matrices(which)
        return [
            Rows(
                self.positions[which, nodes],
                R[:, nodes],
                self.alive[which, nodes],
                self.values[which, channels],
                self.scales[which, scales],
                self.expressions[which, faces],
            )
            for nodes, channels, scales, faces in self._slices
        ]

    def _matrices(self, which: slice) -> Array:
        """Returns the rotations (n, J, 3, 3) of rows that are not stored yet."""
        return self._R[which.start - self._first : which.stop - self._first]

    def show(self, which: slice, nodes: NDArray[np.int64]) -> None:
        """Stores the rotations of nodes in rows that are not stored yet, for `Members` to read."""
        self.quaternions[which, nodes] = quaternion(self._matrices(which)[:, nodes])

    def attached(self, which: slice, attachments: Iterable[Attachment]) -> tuple[Array, Array]:
        """Transforms attached nodes of some rows to the world.

        Args:
            which: the rows after those that were stored.
            attachments: parents first.

        Returns:
            Rotations (n, J, 3, 3) and positions (n, J, 3) of all nodes [m], writable.
        """
        R, p = self._matrices(which), self.positions[which]
        for attachment in attachments:
            attachment.apply(R, p, which.start)
        return R, p

    def store(self, which: slice) -> tuple[int, str] | None:
        """Stores rows in which all nodes are in the world frame.

        Returns:
            The first row and node whose pose is not finite, None if all are.
        """
        R, p = self._matrices(which), self.positions[which]
        if not (np.isfinite(p).all() and np.isfinite(R).all()):
            row, node = np.argwhere(~np.isfinite(p.sum(axis=-1) + R.sum(axis=(-1, -2))))[0]
            return which.start + int(row), self.nodes[int(node)].name
        # Signs continue those of the last row before.
        last = self.quaternions[max(which.start - 1, 0) : which.start]
        run = continuous(np.concatenate([last, quaternion(R)]))
        self.quaternions[which] = run[len(last) :]
        moving = self.positions, self.quaternions, self.alive, self.values, self.scales
        for rows in (*moving, self.expressions):
            release_rows(rows)
        return None

    def add_facts(
        self,
        contacts: Iterable[Contact],
        events: Iterable[SoundEvent],
        notes: Iterable[TakeNote],
    ) -> None:
        """Adds facts of one step; of notes, those that `NoteLog` keeps."""
        self.contacts.extend(contacts)
        self.events.extend(events)
        self._notes.add(notes)

    @property
    def notes(self) -> list[TakeNote]:
        """Notes so far, in the order of time."""
        return self._notes.notes

    def take(self) -> Take:
        """Returns the finished take."""
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
            # Looks follow the meshes.
            parts=tuple(
                replace(part, look=shifted_look(part, len(self.meshes))) for part in self.parts
            ),
            terrain=TerrainRecord(
                field.vertices,
                field.faces,
                field.cells,
                self.ground.forbidden,
                self.ground.material,
            ),
            # Contacts that last are reported when they end.
            contacts=tuple(sorted(self.contacts, key=lambda c: (c.step, c.fraction))),
            events=tuple(sorted(self.events, key=lambda e: (e.step, e.fraction))),
            notes=tuple(self.notes),
            faces=self.faces,
            expressions=self.expressions,
        )


def _slices(inventories: Sequence[Inventory]) -> list[tuple[slice, slice, slice, slice]]:
    """Returns the slices of each troupe's nodes, channels, scales and faces."""
    slices, before = [], (0, 0, 0, 0)
    for inventory in inventories:
        own = inventory.nodes, inventory.channels, inventory.scaled, inventory.faces
        a, b, c, d = (first + len(new) for first, new in zip(before, own, strict=True))
        nodes, channels, scales, faces = map(slice, before, (a, b, c, d))
        slices.append((nodes, channels, scales, faces))
        before = a, b, c, d
    return slices
