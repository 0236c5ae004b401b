"""Pass-through: creatures and people that go through things which do not stop them.

Creatures follow their routes and go round nothing by themselves; they push bodies with
`collide: all` and people, and pass through the rest. People pass through bodies that collide with
the terrain only. Rows of the take are looked at in intervals.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.clock import Clock
from pipeline.simulation.members import Members
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.solid_overlaps import (
    PlacedSolid,
    assemblies,
    bent_parts,
    boxes_of,
    deepest_overlap,
    skin_solids,
    solids_of,
)
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TakeNote
from pipeline.spec.body import Body
from pipeline.spec.cast import Member
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.dancer import Dancer
from pipeline.spec.prop import Prop


@dataclass(frozen=True, slots=True)
class PassThroughLimits:
    """When somebody goes through something.

    Attributes:
        interval: between the rows that are looked at [s].
        depth: from which it does, in its height at the start.
        least_depth, most_depth: bounds on that depth [m]; a rug or a stalk is stepped on.
        speed: from which it goes at all [m/s].
    """

    interval: float = 0.25
    depth: float = 0.2
    least_depth: float = 0.005
    most_depth: float = 0.05
    speed: float = 0.05


LIMITS = PassThroughLimits()


def pass_through_notes(
    cast: Sequence[Member],
    members: Members,
    recorder: Recorder,
    clock: Clock,
    meeting: Collection[str],
) -> list[TakeNote]:
    """Returns a note on each performer that goes through another, where it first does.

    Args:
        cast: of the scene.
        members: of the cast; they are left at another row.
        recorder: the take, whose rows are all written.
        clock: of the scene.
        meeting: names of the bodies and props that meet all others.
    """
    per_row = clock.steps // clock.samples
    apart = max(round(LIMITS.interval / (clock.dt * per_row)), 1)
    rows = np.arange(0, len(recorder.positions), apart)
    pairs = _pairs(cast, meeting)
    passages = _Passages(members, recorder, rows)
    notes = [
        TakeNote("passes_through", row * per_row, mover.name, _text(depth, other))
        for mover, other in pairs
        if (found := passages.first(mover.name, other.name, apart * per_row * clock.dt)) is not None
        for row, depth in [found]
    ]
    return sorted(notes, key=lambda note: note.step)


def _pairs(cast: Sequence[Member], meeting: Collection[str]) -> list[tuple[Member, Member]]:
    """Returns who may go through what: both do not meet, and nothing connects them."""
    assembly = assemblies(cast)
    things = [m for m in cast if isinstance(m, Prop | Body) and m.name not in meeting]
    creatures = [m for m in cast if isinstance(m, Creature)]
    going = [m for m in creatures if m.walk is not None or m.pronk is not None]
    people = [m for m in cast if isinstance(m, Character) and m.acts]
    dancers = [m for m in cast if isinstance(m, Dancer)]
    bodies = [m for m in things if isinstance(m, Body)]
    pairs: list[tuple[Member, Member]] = [(one, body) for one in people for body in bodies]
    for k, creature in enumerate(going):
        # Of two creatures that go, the first is told.
        told = {one.name for one in going[: k + 1]}
        others = [other for other in creatures if other.name not in told]
        pairs += [(creature, other) for other in (*things, *dancers, *others)]
    return [(one, other) for one, other in pairs if assembly[one.name] != assembly[other.name]]


def _text(depth: float, other: Member) -> str:
    deep = f"goes {depth:.2g} m deep into '{other.name}', which"
    if isinstance(other, Body):
        return f"{deep} collides with the ground alone; give it `collide: all`"
    return f"{deep} no creature avoids by itself; lead its way around it"


class _Passages:
    """Finds where performers go through one another.

    Args:
        members: of the cast.
        recorder: the take.
        rows: (S,) that are looked at, in order.
    """

    def __init__(self, members: Members, recorder: Recorder, rows: NDArray[np.int64]) -> None:
        self._members, self._recorder, self._rows = members, recorder, rows
        self._is_bent = bent_parts(recorder)
        self._boxes: dict[str, tuple[Array, Array]] = {}
        self._balls: dict[str, tuple[Array, Array]] = {}
        self._skins: dict[str, list[PlacedSolid]] = {}
        self._solids: dict[tuple[int, str], tuple[list[PlacedSolid], Array]] = {}
        self._least: dict[str, float] = {}

    def first(self, mover: str, other: str, interval: float) -> tuple[int, float] | None:
        """Returns row and depth [m] of the first passage; None without, or if they begin so.

        Args:
            mover: name of the performer that goes.
            other: name of the other one.
            interval: between the rows [s].
        """
        (low, high), (other_low, other_high) = self._box(mover), self._box(other)
        near = np.asarray(((low < other_high) & (other_low < high)).all(axis=-1), dtype=bool)
        if near.any():
            near[near] = self._balls_meet(mover, other, near)
        if not near.any():
            return None
        place = 0.5 * (low + high)[:, [0, 2]]
        speed = np.linalg.norm(np.diff(place, axis=0, prepend=place[:1]), axis=-1) / interval
        least = self._least_depth(mover)
        for sample in np.flatnonzero(near & ((speed > LIMITS.speed) | (self._rows == 0))).tolist():
            row = int(self._rows[sample])
            own, own_boxes = self._solids_at(row, mover)
            others, other_boxes = self._solids_at(row, other)
            depth = deepest_overlap(own, others, self._is_bent, (own_boxes, other_boxes), least)
            if depth > least:
                return None if row == 0 else (row, depth)
        return None

    def _least_depth(self, name: str) -> float:
        if name not in self._least:
            self._members.update(0)
            state = self._members.state(name)
            height = float(state.high[1] - state.low[1])
            least = max(LIMITS.depth * height, LIMITS.least_depth)
            self._least[name] = min(least, LIMITS.most_depth)
        return self._least[name]

    def _solids_at(self, row: int, name: str) -> tuple[list[PlacedSolid], Array]:
        """Returns the solids of a performer in a row, and their boxes (n, 2, 3) [m]."""
        if (row, name) not in self._solids:
            if name not in self._skins:
                self._skins[name] = skin_solids(name, self._recorder)
            self._members.update(row)
            solids = solids_of(name, self._members, self._recorder, self._skins[name])
            self._solids[row, name] = solids, boxes_of([solid.corners for solid in solids])
        return self._solids[row, name]

    def _balls_of(self, name: str) -> tuple[Array, Array]:
        """Returns centres (S, n, 3) and radii (n,) of balls around a performer's solids [m]."""
        if name not in self._balls:
            recorder, radii = self._recorder, dict[int, float]()
            for solid in self._solids_at(0, name)[0]:
                radii[solid.node] = max(radii.get(solid.node, 0.0), _reach(solid, recorder))
            nodes = sorted(radii)
            reach = np.array([radii[node] for node in nodes])
            reach *= float(recorder.scales.max(initial=1.0))
            self._balls[name] = recorder.positions[self._rows][:, nodes], reach
        return self._balls[name]

    def _balls_meet(self, mover: str, other: str, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Returns whether balls around solids of two performers meet in chosen rows (S,)."""
        (p, r), (p_other, r_other) = self._balls_of(mover), self._balls_of(other)
        apart = p[chosen][:, :, None] - p_other[chosen][:, None]
        reach = r[:, None] + r_other
        meets: NDArray[np.bool_] = ((apart * apart).sum(axis=-1) < reach * reach).any(axis=(1, 2))
        return meets

    def _box(self, name: str) -> tuple[Array, Array]:
        """Returns lowest and highest corners (S, 3) around a performer in each row [m]."""
        if name not in self._boxes:
            centres, radii = self._balls_of(name)
            reach = radii[:, None]
            low, high = (centres - reach).min(axis=1), (centres + reach).max(axis=1)
            self._boxes[name] = low, high
        return self._boxes[name]


def _reach(solid: PlacedSolid, recorder: Recorder) -> float:
    """Returns how far a solid reaches from the node that it follows, in the first row [m]."""
    return float(np.linalg.norm(solid.corners - recorder.positions[0, solid.node], axis=-1).max())
