"""Sound sources: the nodes and rigid parts that detectors of motion observe."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from audio.acoustic_materials import family_name
from pipeline.simulation.clock import Clock
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Channel, Mesh, Node, Part


@dataclass(frozen=True, eq=False)
class SoundingPart:
    """A part that sounds where one node is.

    Attributes:
        node: index of the node.
        performer: its owner.
        part: name.
        material: name.
        size: characteristic length [m].
    """

    node: int
    performer: str
    part: str
    material: str
    size: float


@dataclass(frozen=True, eq=False)
class RigidPart(SoundingPart):
    """A visible part that moves with one node.

    Attributes:
        mesh: surface.
    """

    mesh: Mesh

    @cached_property
    def principal_axes(self) -> Array:
        """Axes of the vertices' covariance as columns, the longest last: (3, 3)."""
        spread = self._spread
        _, axes = np.linalg.eigh((spread[:, :, None] * spread[:, None, :]).sum(axis=0))
        return np.asarray(axes)

    @property
    def thickness(self) -> float:
        """Least extent along the principal axes [m]."""
        along = (self._spread[:, :, None] * self.principal_axes).sum(axis=1)
        return float(np.ptp(along, axis=0).min())

    @property
    def _spread(self) -> Array:
        corners = self.mesh.vertices.astype(float)
        return corners - corners.mean(axis=0)


def garments(parts: Sequence[Part], nodes: Sequence[Node]) -> dict[str, SoundingPart]:
    """Return the largest garment of each performer that wears any, at its first node."""
    roots = dict[str, int]()
    for i, node in enumerate(nodes):
        roots.setdefault(node.performer, i)
    worn = dict[str, SoundingPart]()
    for part in parts:
        if part.performer not in roots or family_name(part.material) != "cloth":
            continue
        if part.performer not in worn or part.size > worn[part.performer].size:
            worn[part.performer] = SoundingPart(
                roots[part.performer], part.performer, part.name, part.material, part.size
            )
    return worn


def rigid_parts(parts: Sequence[Part], meshes: Sequence[Mesh]) -> dict[int, RigidPart]:
    """Return the first rigid part of each node, by the node's index."""
    by_node = dict[int, RigidPart]()
    for part in parts:
        mesh = meshes[part.mesh]
        node = int(mesh.nodes[0, 0])
        if node not in by_node and (mesh.nodes == node).all():
            by_node[node] = RigidPart(
                node, part.performer, part.name, part.material, part.size, mesh
            )
    return by_node


@dataclass(frozen=True, eq=False)
class SoundSources:
    """Constants of a scene that detectors read.

    Attributes:
        clock: grid of steps, rows and frames.
        nodes: of all performers.
        parts: rigid parts by the index of their node.
        channels: of all performers.
        figures: of the creatures, by name.
        groups: names of groups.
        people: names of people, who have a head, a chest and limbs.
        garments: the largest one of each performer that wears any.
        wings: length of a wing of the members of each group that flies [m].
        moods: of creatures, each with the time from which it holds [s], in the order of time.
        seed: of the scene.
    """

    clock: Clock
    nodes: Sequence[Node]
    parts: Mapping[int, RigidPart]
    channels: Sequence[Channel]
    figures: Mapping[str, Figure]
    groups: frozenset[str]
    people: frozenset[str] = frozenset()
    garments: Mapping[str, SoundingPart] = field(default_factory=dict)
    wings: Mapping[str, float] = field(default_factory=dict)
    moods: Mapping[str, Sequence[tuple[float, str]]] = field(default_factory=dict)
    seed: int = 0

    @property
    def dt(self) -> float:
        """Time from row to row [s]."""
        return float(1 / (self.clock.rate * self.clock.samples))

    def channel(self, name: str) -> int | None:
        """Return the index of a channel, None if there is none."""
        return self._channel_numbers.get(name)

    def root(self, performer: str) -> int:
        """Return the index of the first node of a performer."""
        return self.nodes_by_performer[performer][0]

    @cached_property
    def node_numbers(self) -> Mapping[str, int]:
        """Indices of the nodes by name."""
        return {node.name: i for i, node in enumerate(self.nodes)}

    @cached_property
    def nodes_by_performer(self) -> Mapping[str, Sequence[int]]:
        """Indices of the nodes of each performer, in their order."""
        found = dict[str, list[int]]()
        for i, node in enumerate(self.nodes):
            found.setdefault(node.performer, []).append(i)
        return found

    @cached_property
    def _channel_numbers(self) -> Mapping[str, int]:
        # Of channels with one name the first counts.
        return {self.channels[i].name: i for i in reversed(range(len(self.channels)))}

    @cached_property
    def flying(self) -> tuple[RigidPart, ...]:
        """Parts that may fly on their own: of props and bodies, not of creatures and groups."""
        excluded = self.groups.union(self.figures)
        return tuple(part for part in self.parts.values() if part.performer not in excluded)


@dataclass(frozen=True, eq=False)
class RowBatch:
    """Consecutive rows, with neighbours of those that are new.

    Attributes:
        first: index of the first row.
        new: rows that are new and whose neighbours are known.
        p: (n, J, 3) positions of the nodes [m].
        R: (n, J, 3, 3) rotations.
        alive: (n, J).
        values: (n, C) of the channels.
        is_final: whether no row follows.
        lifts: performer -> times at which its feet left the ground, in rows, as far as known.
    """

    first: int
    new: slice
    p: Array
    R: Array
    alive: NDArray[np.bool_]
    values: Array
    is_final: bool
    lifts: Mapping[str, Sequence[float]] = field(default_factory=dict)

    @property
    def first_new(self) -> int:
        """Index of the first new row."""
        return self.first + self.new.start

    def at_rows(self, between: Array) -> Array:
        """Return values at the new rows (m, ...) from values between rows (n - 1, ...).

        A row has the mean of the values before and after it; the error is of second order.
        """
        if not len(between):
            return np.zeros((self.new.stop - self.new.start, *between.shape[1:]))
        whole = np.concatenate([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])
        return whole[self.new]
