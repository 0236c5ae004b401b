"""Group places: where a whole group is, for whatever goes to it or looks at it.

Flames, drops and blades come and go or are many, so their group is where its author put it, as
large as it is given. A flock is where its members are.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.member_state import MemberState
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.spatial import UP, Array, matrix
from pipeline.simulation.terrain import Ground
from pipeline.spec.group import Fire, Grass, Group, Rain
from pipeline.spec.scene import Scene

_CORNERS: Array = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
"""Corners of a box, relative to its middle, the lowest first and the highest last."""


@dataclass(frozen=True, eq=False)
class GroupPlace:
    """Where a group stands that does not move by itself.

    Attributes:
        foot: (3,) middle of its lowest face, in the world or relative to `parent` [m].
        half: (3,) half of its extent along the world's axes [m].
        parent: number of the node that carries it, -1 for none.
    """

    foot: Array
    half: Array
    parent: int = -1

    def state(self, recorder: Recorder, row: int, row_time: float) -> MemberState:
        """Returns its state in a written row; rows are `row_time` apart [s]."""
        foot = self._foot(recorder, row)
        v = (foot - self._foot(recorder, row - 1)) / row_time if row else np.zeros(3)
        centre = foot + self.half[1] * UP
        radius = float(max(self.half[0], self.half[2]))
        box = centre + self.half * _CORNERS
        low, high = box[0], box[-1]
        return MemberState(centre, centre, v, low, high, radius, solids=(box,))

    def _foot(self, recorder: Recorder, row: int) -> Array:
        if self.parent < 0:
            return self.foot
        R = matrix(recorder.quaternions[row, self.parent])
        place: Array = recorder.positions[row, self.parent] + R @ self.foot
        return place


def group_places(scene: Scene, ground: Ground, names: NodeNames) -> dict[str, GroupPlace]:
    """Returns the places of the groups of a scene that stand or are carried, by name."""
    places = {}
    for member in scene.cast:
        half = _half_extent(member) if isinstance(member, Group) else None
        if half is None:
            continue
        parent = names.find(member.parent) if member.parent is not None else -1
        x, z = member.at[0], member.at[-1]
        on_ground = len(member.at) == 2 and member.parent is None
        y = float(ground.height(np.array(x), np.array(z))) if on_ground else 0.0
        foot = np.array(member.at if len(member.at) == 3 else (x, y, z))
        # A parent without that part is refused where the group is bound to it.
        places[member.name] = GroupPlace(foot, half, parent if isinstance(parent, int) else -1)
    return places


def _half_extent(member: Group) -> Array | None:
    """Returns half of the extent (3,) of a group that stands, None of one that moves [m]."""
    match member.group:
        case Fire(radius=radius, height=height):
            return 0.5 * np.array([2.0 * radius, height, 2.0 * radius])
        case Rain(area=(x, z), height=height) | Grass(area=(x, z), size=height):
            return 0.5 * np.array([x, height, z])
    return None


def moving_group(
    recorder: Recorder, row: int, row_time: float, nodes: Sequence[int]
) -> MemberState:
    """Returns the state of a group by its members, which are `nodes`, in a written row."""
    points = recorder.positions[row, nodes]
    v = np.zeros(3)
    if row:
        v = (points - recorder.positions[row - 1, nodes]).mean(axis=0) / row_time
    centre = points.mean(axis=0)
    offset = points[:, [0, 2]] - centre[[0, 2]]
    radius = float(np.hypot(offset[:, 0], offset[:, 1]).max())
    low, high = points.min(axis=0), points.max(axis=0)
    return MemberState(centre, centre, v, low, high, radius, loose=points)
