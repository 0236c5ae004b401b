"""Thing notes: creatures of which something is in a prop or a body.

Limbs keep clear of things, but hands that grip press into what they hold, feet into what they
kick, and a posed arm may cut the edge of a table. It is told where it first happens. Things that a
creature begins in, such as its seat, are its author's own. What is not convex is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from pipeline.simulation.clock import Clock
from pipeline.simulation.members import Members
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.solid_overlaps import bent_parts
from pipeline.simulation.spatial import Array, matrix, turn, turn_inverse
from pipeline.simulation.sunk_notes import DEPTH, Corners, corners_of
from pipeline.simulation.take import TakeNote
from pipeline.spec.body import Body, Many
from pipeline.spec.cast import Member
from pipeline.spec.creature import Creature
from pipeline.spec.prop import Prop

INTERVAL = 0.04
"""Time between the rows that are looked at: a kick takes no longer [s]."""


@dataclass(frozen=True, eq=False)
class _Hull:
    """A convex solid of a thing.

    Attributes:
        node: that it follows.
        name: of the part.
        planes: (F, 4) outward normals and offsets, in the frame of the node [m].
        reach: how far it goes from the node [m].
    """

    node: int
    name: str
    planes: Array
    reach: float

    def depths(self, places: Array) -> Array:
        """Returns how deep places (n, 3) in the frame of its node are; below 0 outside [m]."""
        depths: Array = -(places @ self.planes[:, :3].T + self.planes[:, 3]).max(axis=-1)
        return depths


def thing_notes(
    cast: Sequence[Member],
    members: Members,
    recorder: Recorder,
    clock: Clock,
    told: Collection[TakeNote],
) -> list[TakeNote]:
    """Returns a note on each creature and thing of which one is in the other, where it first is.

    Args:
        cast: of the scene.
        members: of the cast; they are left at the first row.
        recorder: the take, whose rows are all written.
        clock: of the scene.
        told: notes on what goes right through things; what they name is not told again.
    """
    members.update(0)
    creatures = [m.name for m in cast if isinstance(m, Creature)]
    things = [m.name for m in cast if isinstance(m, Prop | Body | Many)]
    if not creatures or not things:
        return []
    per_row = clock.steps // clock.samples
    rows = np.arange(0, len(recorder.positions), max(round(INTERVAL / (clock.dt * per_row)), 1))
    is_bent = bent_parts(recorder)
    hulls = {name: list(_hulls(name, members, recorder, is_bent)) for name in things}
    notes = []
    for name in creatures:
        corners = corners_of(name, members, recorder)
        if corners is None:
            continue
        state = members.state(name)
        least = DEPTH * float(np.linalg.norm(state.high - state.low))
        for thing in things:
            if any(note.part == name and f"'{thing}'" in note.text for note in told):
                continue
            found = _first(corners, hulls[thing], recorder, rows, least)
            if found is not None:
                row, part, depth, other = found
                text = f"is {depth:.2g} m deep in '{other}'"
                notes.append(TakeNote("passes_through", row * per_row, part, text))
    return notes


def _hulls(
    name: str, members: Members, recorder: Recorder, is_bent: Callable[[str], bool]
) -> Iterator[_Hull]:
    """Yields the convex solids of a thing, but not those whose size changes."""
    for solid in members.all_solids(name):
        if solid.node in recorder.scaled or is_bent(solid.name):
            continue
        try:
            planes = ConvexHull(solid.corners).equations
        except QhullError:
            continue  # A sheet has no inside.
        reach = float(np.linalg.norm(solid.corners, axis=-1).max())
        yield _Hull(solid.node, solid.name, np.unique(planes.round(9), axis=0), reach)


def _first(
    corners: Corners,
    hulls: Sequence[_Hull],
    recorder: Recorder,
    rows: NDArray[np.int64],
    least: float,
) -> tuple[int, str, float, str] | None:
    """Returns first row, part, greatest depth [m] there and part of the thing; None without."""
    nodes, own = np.unique(corners.nodes, return_inverse=True)
    reach = np.zeros(len(nodes))
    np.maximum.at(reach, own, np.linalg.norm(corners.places, axis=-1))
    p = recorder.positions[rows][:, nodes]
    first: tuple[int, str, float, str] | None = None
    for hull in hulls:
        there = recorder.positions[rows, hull.node]
        near = np.linalg.norm(p - there[:, None], axis=-1) < reach + hull.reach
        near &= (recorder.alive[rows, hull.node])[:, None]
        k, corner = np.nonzero(near[:, own])
        if not len(k):
            continue
        R = matrix(recorder.quaternions[rows[k], nodes[own[corner]]])
        world = p[k, own[corner]] + turn(R, corners.places[corner])
        R_WH = matrix(recorder.quaternions[rows[k], hull.node])
        depth = hull.depths(turn_inverse(R_WH, world - there[k]))
        if not (deep := depth > least).any():
            continue
        if (k[deep] == 0).any():
            return None
        row = int(k[deep].min())
        if first is None or rows[row] < first[0]:
            here = np.flatnonzero(deep & (k == row))
            worst = int(here[depth[here].argmax()])
            first = int(rows[row]), corners.names[corner[worst]], float(depth[worst]), hull.name
    return first
