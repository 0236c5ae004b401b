"""Sunk notes: creatures of which something is in the ground.

Feet keep out of the ground, and free limbs give way to it. A thigh, a fetlock or a posed arm may
still cut a corner of it, and a limb that is drawn into it cannot get out, which is told where it
happens. Rows of the take are looked at in intervals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.clock import Clock
from pipeline.simulation.members import Members
from pipeline.simulation.obstacles import outermost
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.solid_overlaps import skin_solids
from pipeline.simulation.spatial import Array, matrix, turn
from pipeline.simulation.take import TakeNote
from pipeline.simulation.terrain import Ground
from pipeline.spec.cast import Member
from pipeline.spec.creature import Creature

INTERVAL = 0.125
"""Time between the rows that are looked at [s]."""

DEPTH = 0.01
"""Depth that is told, in the size of the creature."""

CORNERS = 24
"""Outermost corners of each solid that are looked at."""


@dataclass(frozen=True, eq=False)
class Corners:
    """Outermost corners of all solids of a creature.

    Attributes:
        nodes: (P,) that they follow.
        places: (P, 3) in the frames of the nodes [m].
        names: (P,) of their parts.
    """

    nodes: NDArray[np.int64]
    places: Array
    names: Sequence[str]


def sunk_notes(
    cast: Sequence[Member], members: Members, recorder: Recorder, clock: Clock, ground: Ground
) -> list[TakeNote]:
    """Returns a note on each creature of which something is in the ground, where it first is.

    Args:
        cast: of the scene.
        members: of the cast; they are left at the first row.
        recorder: the take, whose rows are all written.
        clock: of the scene.
        ground: the terrain.
    """
    members.update(0)
    per_row = clock.steps // clock.samples
    rows = np.arange(0, len(recorder.positions), max(round(INTERVAL / (clock.dt * per_row)), 1))
    notes = []
    for member in cast:
        if not isinstance(member, Creature):
            continue
        corners = corners_of(member.name, members, recorder)
        if corners is None:
            continue
        depth = _depths(corners, recorder, rows, ground)
        state = members.state(member.name)
        deep = depth > DEPTH * float(np.linalg.norm(state.high - state.low))
        if deep.any():
            k = int(deep.any(axis=1).argmax())
            worst = int(depth[k].argmax())
            text = f"is {float(depth[k, worst]):.2g} m deep in the ground"
            part = corners.names[worst]
            notes.append(TakeNote("passes_through", int(rows[k]) * per_row, part, text))
    return notes


def corners_of(name: str, members: Members, recorder: Recorder) -> Corners | None:
    """Returns the outermost corners of a creature's solids; None if it has no solids."""
    solids = [(s.name, s.node, s.corners) for s, _ in members.solids(name)]
    # A skin covers the whole body: the node says where.
    skins = skin_solids(name, recorder)
    solids += [(recorder.nodes[s.node].name, s.node, s.corners) for s in skins]
    if not solids:
        return None
    corners = [outermost(corners, CORNERS) for _, _, corners in solids]
    counts = [len(some) for some in corners]
    nodes = np.repeat([node for _, node, _ in solids], counts)
    names = np.repeat([part for part, _, _ in solids], counts).tolist()
    return Corners(nodes, np.concatenate(corners), names)


def _depths(corners: Corners, recorder: Recorder, rows: NDArray[np.int64], ground: Ground) -> Array:
    """Returns how deep corners are in the ground (K, P), at right angles to it; 0 outside [m]."""
    nodes, own = np.unique(corners.nodes, return_inverse=True)
    p = recorder.positions[rows][:, nodes]
    reach = np.zeros(len(nodes))
    np.maximum.at(reach, own, np.linalg.norm(corners.places, axis=-1))
    height, normal = ground.surface(p[..., 0], p[..., 2])
    # Balls around what follows a node: most of them are above the ground.
    near = (p[..., 1] - height) * normal[..., 1] < reach
    result = np.zeros((len(rows), len(own)))
    row, corner = np.nonzero(near[:, own])
    if len(row):
        R = matrix(recorder.quaternions[rows][:, nodes])
        there = p[row, own[corner]] + turn(R[row, own[corner]], corners.places[corner])
        height, normal = ground.surface(there[:, 0], there[:, 2])
        result[row, corner] = np.maximum((height - there[:, 1]) * normal[:, 1], 0.0)
    return result
