"""Face motions: what the faces of a take do to the vertices of its meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.face_units import EYE_TURN
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Take


@dataclass(frozen=True, eq=False)
class FaceMotions:
    """The moves of the vertices of some meshes by the faces of their performers.

    Attributes:
        vertices: (n,) moved vertices.
        faces: (n,) numbers of the faces that move them.
        units: (n,) units that move them.
        offsets: (n, 3) their moves at the full action [m].
        eyes: (m,) vertices of eyeballs.
        owners: (m,) their faces.
        spokes: (m, 3) their offsets from the middle of the eye [m].
    """

    vertices: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    faces: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    units: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    offsets: Array = field(default_factory=lambda: np.zeros((0, 3)))
    eyes: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    owners: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    spokes: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @staticmethod
    def of(take: Take, meshes: Sequence[Mesh], starts: NDArray[np.int64]) -> FaceMotions:
        """Return the motions of meshes of a take, whose vertices are numbered from `starts`."""
        numbers = {face.performer: k for k, face in enumerate(take.faces)}
        if not numbers:
            return FaceMotions()
        by_node = [numbers.get(node.performer, -1) for node in take.nodes]
        targets, offsets, owners = [], [], []
        for mesh, start in zip(meshes, starts, strict=False):
            face = by_node[mesh.nodes[0, 0]] if len(mesh.targets) else -1
            if face >= 0:
                targets.append(mesh.targets.astype(np.int64) + np.array([start, 0]))
                offsets.append(mesh.offsets.astype(float))
                owners.append(np.full(len(mesh.targets), face))
        if not targets:
            return FaceMotions()
        rows, moves, face_of = map(np.concatenate, (targets, offsets, owners))
        turns = rows[:, 1] == EYE_TURN
        return FaceMotions(
            *(rows[~turns, 0], face_of[~turns], rows[~turns, 1], moves[~turns]),
            *(rows[turns, 0], face_of[turns], moves[turns]),
        )

    def moved(self, vertices: Array, take: Take, at: float) -> Array:
        """Return vertices (2, V, 3) in the rest frame as the faces move them, or these themselves.

        Args:
            vertices: relative to each of their two nodes, whose frames are alike at rest [m].
            take: of the faces.
            at: row of the take, or between two.
        """
        if not (len(self.vertices) or len(self.eyes)):
            return vertices
        now = _expressions(take, at)
        share = now[self.faces, self.units]
        acts = share != 0.0
        moves = np.zeros(vertices.shape[1:])
        np.add.at(moves, self.vertices[acts], share[acts, None] * self.offsets[acts])
        left, up = now[self.owners, EYE_TURN], now[self.owners, EYE_TURN + 1]
        moves[self.eyes] += _eye_turned(self.spokes, left, up) - self.spokes
        return vertices + moves


def _expressions(take: Take, at: float) -> Array:
    """Return the units and gaze (F, n) of the faces, linear between two rows."""
    row = int(at)
    after = min(row + 1, len(take.expressions) - 1)
    here, there = (take.expressions[k].astype(float) for k in (row, after))
    return here + (at - row) * (there - here)


def _eye_turned(spokes: Array, left: Array, up: Array) -> Array:
    """Return offsets (m, 3) that an eye turns up, about Z, and then left, about Y."""
    x, y, z = spokes.T
    c, s = np.cos(up), np.sin(up)
    x, y = c * x - s * y, s * x + c * y
    c, s = np.cos(left), np.sin(left)
    return np.stack([c * x + s * z, y, c * z - s * x], axis=-1)
