"""Face motions: what the faces of a take do to the vertices of its meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.face_units import EYE_TURN
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Take

LEAST_ACTION = 1e-3
"""Action of a unit below which it moves nothing that shows."""


@dataclass(frozen=True, eq=False)
class UnitMove:
    """What one unit of one face, or of a hand, does at its full action.

    Attributes:
        face: its number.
        unit: number of the unit.
        vertices: (n,) moved vertices, each once.
        offsets: (n, 3) their moves [m].
    """

    face: int
    unit: int
    vertices: NDArray[np.int64]
    offsets: Array


@dataclass(frozen=True, eq=False)
class FaceMotions:
    """The moves of the vertices of some meshes by the faces of their performers.

    Attributes:
        moves: of all units of all faces.
        eyes: (m,) vertices of eyeballs.
        owners: (m,) their faces.
        spokes: (m, 3) their offsets from the middle of the eye [m].
    """

    moves: tuple[UnitMove, ...] = ()
    eyes: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    owners: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    spokes: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @staticmethod
    def of(take: Take, meshes: Sequence[Mesh], starts: NDArray[np.int64]) -> FaceMotions:
        """Return the motions of meshes of a take, whose vertices are numbered from `starts`."""
        numbers = {face.performer: k for k, face in enumerate(take.faces)}
        moves = list[UnitMove]()
        eyes, owners, spokes = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros((0, 3))]
        for mesh, start in zip(meshes, starts, strict=False) if numbers else ():
            performer = take.nodes[mesh.nodes[0, 0]].performer if len(mesh.targets) else ""
            if performer not in numbers:
                continue
            face, units = numbers[performer], mesh.targets[:, 1]
            vertices, offsets = mesh.targets[:, 0] + start, mesh.offsets.astype(float)
            # Takes of before may know fewer units.
            known = units[units < take.expressions.shape[-1]]
            for unit in np.unique(known).tolist():
                own = units == unit
                if unit == EYE_TURN:
                    eyes.append(vertices[own])
                    owners.append(np.full(len(eyes[-1]), face))
                    spokes.append(offsets[own])
                else:
                    moves.append(UnitMove(face, unit, vertices[own], offsets[own]))
        return FaceMotions(
            tuple(moves), np.concatenate(eyes), np.concatenate(owners), np.concatenate(spokes)
        )

    @cached_property
    def touched(self) -> NDArray[np.int64]:
        """Numbers of all vertices that a face may move."""
        return np.unique(np.concatenate([self.eyes, *(move.vertices for move in self.moves)]))

    def offsets(self, count: int, take: Take, at: float) -> Array:
        """Return by how much the faces move all vertices (V, 3) in the rest frame [m].

        Args:
            count: of the vertices. Most are in no face, and their zeros take up no memory.
            take: of the faces.
            at: row of the take, or between two.
        """
        now = _expressions(take, at)
        found = np.zeros((count, 3))
        for move in self.moves:
            share = now[move.face, move.unit]
            if share > LEAST_ACTION:
                found[move.vertices] += share * move.offsets
        gaze = now[self.owners, EYE_TURN], now[self.owners, EYE_TURN + 1]
        found[self.eyes] += _eye_turned(self.spokes, *gaze) - self.spokes
        return found


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
