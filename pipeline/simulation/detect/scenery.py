"""Scenery: who there is to be heard, as detectors look at it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.clock import Clock
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel, Mesh, Node, Part


@dataclass(frozen=True, eq=False)
class Solid:
    """What is seen of one node.

    Attributes:
        node: its number.
        performer: whose it is.
        part: name of the part.
        material: its.
        size: characteristic length [m].
        mesh: its surface.
    """

    node: int
    performer: str
    part: str
    material: str
    size: float
    mesh: Mesh

    @cached_property
    def thickness(self) -> float:
        """Its least extent, along the axes of its own shape [m]."""
        corners = self.mesh.vertices.astype(float)
        spread = corners - corners.mean(axis=0)
        _, axes = np.linalg.eigh((spread[:, :, None] * spread[:, None, :]).sum(axis=0))
        along = (spread[:, :, None] * axes).sum(axis=1)
        return float(np.ptp(along, axis=0).min())


@dataclass(frozen=True, eq=False)
class Scenery:
    """All that does not change.

    Attributes:
        clock: the grid of steps, rows and frames.
        nodes: of all performers.
        solids: those that move as one node, by its number; of several its first.
        channels: of all performers.
        figures: of the creatures, by name.
        groups: names of those who are many and small.
    """

    clock: Clock
    nodes: Sequence[Node]
    solids: Mapping[int, Solid]
    channels: Sequence[Channel]
    figures: Mapping[str, Figure]
    groups: frozenset[str]

    @property
    def dt(self) -> float:
        """Time from row to row [s]."""
        return float(1 / (self.clock.rate * self.clock.samples))

    def channel(self, name: str) -> int | None:
        """Return the number of a channel, None if there is none."""
        found = [i for i, channel in enumerate(self.channels) if channel.name == name]
        return found[0] if found else None

    def root(self, performer: str) -> int:
        """Return the number of the first node of a performer."""
        return next(i for i, node in enumerate(self.nodes) if node.performer == performer)

    @cached_property
    def flying(self) -> tuple[Solid, ...]:
        """Solids that may fly on their own: of props and bodies, not limbs and no swarms."""
        grounded = self.groups.union(self.figures)
        return tuple(s for s in self.solids.values() if s.performer not in grounded)


def solids_of(parts: Sequence[Part], meshes: Sequence[Mesh]) -> dict[int, Solid]:
    """Return the solids that move as one node, by its number."""
    found = dict[int, Solid]()
    for part in parts:
        mesh = meshes[part.mesh]
        node = int(mesh.nodes[0, 0])
        if node not in found and (mesh.nodes == node).all():
            of = (part.performer, part.name, part.material, part.size, mesh)
            found[node] = Solid(node, *of)
    return found


@dataclass(frozen=True, eq=False)
class Seen:
    """Rows that follow one another, as everybody stood in them.

    Attributes:
        first: number of the first of these rows.
        told: which of these rows are new: all whose neighbours are here.
        p: (n, J, 3) positions of the nodes [m].
        R: (n, J, 3, 3) their rotations.
        alive: (n, J).
        values: (n, C) of the channels.
        final: whether no row follows.
        lifts: when feet left the ground, in rows, by performer; so far as it is known.
    """

    first: int
    told: slice
    p: Array
    R: Array
    alive: NDArray[np.bool_]
    values: Array
    final: bool
    lifts: Mapping[str, Sequence[float]] = field(default_factory=dict)

    def by_row(self, between: Array) -> Array:
        """Return values at the rows `told` (m, ...) of values between rows (n - 1, ...).

        A row has the mean of what is before and after it; an error of second order.
        """
        if not len(between):
            return np.zeros((self.told.stop - self.told.start, *between.shape[1:]))
        whole = np.concatenate([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])
        result: Array = whole[self.told]
        return result
