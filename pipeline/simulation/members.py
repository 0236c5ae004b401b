"""Members: where the members of the cast are, for whatever goes to, looks at or reaches for them.

A member is known by its name, a part of it as `bug.head`, and a place of the scene by its name.
States are those of the last row that was written, one row before the step that reads them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.simulation.group_places import GroupPlace, moving_group
from pipeline.simulation.member_state import MemberState
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.obstacles import Obstacle
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array, matrix
from pipeline.spec.model_base import Goal
from pipeline.spec.partial_scene import value_at
from pipeline.spec.script import Instruction
from pipeline.spec.verbs import VERBS, key_of_order, targets_of

__all__ = ["MemberState", "Members", "goal_place", "members_named"]

HEAD_PARTS = ("head",)
"""Parts that are looked at, in the order of preference."""


class Members:
    """The states of all members in the last written row, computed where they are asked for.

    Args:
        recorder: the take under construction.
        names: of all nodes and parts.
        obstacles: computes the solids of all troupes.
        places: named places (3,) of the scene [m].
        groups: places of the groups that stand or are carried.
    """

    def __init__(
        self,
        recorder: Recorder,
        names: NodeNames,
        obstacles: Callable[[], Sequence[Obstacle]],
        places: Mapping[str, Array],
        groups: Mapping[str, GroupPlace],
    ) -> None:
        self._recorder, self._names, self._obstacles = recorder, names, obstacles
        self._groups = groups
        self._places = {name: MemberState.of_place(place) for name, place in places.items()}
        self._row = 0
        self._states: dict[str, MemberState] = {}
        self._solids: dict[int, list[Obstacle]] | None = None
        self._nodes: dict[str, list[int]] = {}

    def update(self, row: int) -> None:
        """Moves on to a written row."""
        if row != self._row:
            self._row = row
            self._states.clear()

    @property
    def row(self) -> int:
        """The written row whose states these are."""
        return self._row

    def state(self, name: str) -> MemberState:
        """Returns the state of a member, a part of one as `bug.head`, or a place."""
        if name in self._places:
            return self._places[name]
        if name not in self._states:
            self._states[name] = self._measured(name)
        return self._states[name]

    def problems(self, instruction: Instruction, path: str) -> list[Problem]:
        """Returns the problems of an instruction that names parts which members do not have.

        Args:
            instruction: the instruction.
            path: its path in error messages.
        """
        do, when = instruction.do, instruction.when
        key = key_of_order(do)
        targets = VERBS[key].targets if key is not None else ()
        named = {f"{path}.do.{target}": value_at(do, target) for target in targets}
        if when is not None and when.near is not None:
            named |= {f"{path}.when.near[{k}]": name for k, name in enumerate(when.near)}
        return [
            Problem(place, message)
            for place, name in named.items()
            if isinstance(name, str) and "." in name
            if isinstance(message := self._names.find(name), str)
        ]

    def node(self, name: str) -> int:
        """Returns the number of the root node of a member, or of the node of a part."""
        found = self._names.find(name)
        if isinstance(found, int):
            return found
        return self._nodes_of(name)[0]

    def solids(self, name: str) -> list[tuple[Obstacle, Array]]:
        """Returns the solids of a member that exist now, with their corners (n, 3) [m]."""
        recorder, row = self._recorder, self._row
        nodes, of_node = self._nodes_of(name), self._solids_by_node()
        solid = [node for node in nodes if node in of_node and recorder.alive[row, node]]
        rotations = matrix(recorder.quaternions[row, solid])
        return [
            (obstacle, recorder.positions[row, node] + self._scaled_corners(obstacle) @ R.T)
            for node, R in zip(solid, rotations, strict=True)
            for obstacle in of_node[node]
        ]

    def all_solids(self, name: str) -> list[Obstacle]:
        """Returns the solids of a member, whether they exist now or not."""
        of_node = self._solids_by_node()
        return [solid for node in self._nodes_of(name) for solid in of_node.get(node, ())]

    def _measured(self, name: str) -> MemberState:
        recorder, row = self._recorder, self._row
        if name in self._groups:
            return self._groups[name].state(recorder, row, self._row_time)
        nodes = self._nodes_of(name)
        if isinstance(self._names.find(name), str):
            # Without a root: a flock, a school or a swarm.
            return moving_group(recorder, row, self._row_time, nodes)
        root = self.node(name)
        solids = tuple(corners for _, corners in self.solids(name))
        loose = [node for node in nodes if node not in self._solids_by_node()]
        points = np.concatenate(solids) if solids else recorder.positions[row, nodes]
        low, high = points.min(axis=0), points.max(axis=0)
        centre = 0.5 * (low + high)
        offset = points[:, [0, 2]] - centre[[0, 2]]
        return MemberState(
            centre=centre,
            face=self._face(name, centre),
            v=self._velocity(root),
            low=low,
            high=high,
            radius=float(np.hypot(offset[:, 0], offset[:, 1]).max()),
            solids=solids,
            loose=recorder.positions[row, loose],
            is_present=bool(recorder.alive[row, nodes].any()),
        )

    def _face(self, name: str, centre: Array) -> Array:
        for part in HEAD_PARTS:
            found = self._names.find(f"{name}.{part}") if "." not in name else ""
            if isinstance(found, int):
                return self._recorder.positions[self._row, found]
        return centre

    def _velocity(self, node: int) -> Array:
        recorder, row = self._recorder, self._row
        if row == 0:
            return np.zeros(3)
        moved = recorder.positions[row, node] - recorder.positions[row - 1, node]
        return moved / self._row_time

    @property
    def _row_time(self) -> float:
        """Time between two rows [s]."""
        clock = self._recorder.clock
        return clock.dt * (clock.steps // clock.samples)

    def _nodes_of(self, name: str) -> list[int]:
        """Returns the nodes of a member, or the one node of a part or of one of many bodies."""
        if name not in self._nodes:
            nodes = self._recorder.nodes_by_performer.get(name)
            self._nodes[name] = [*nodes] if nodes else [self._own_node(name)]
        return self._nodes[name]

    def _own_node(self, name: str) -> int:
        """Returns the node of this very name, which `problems` has checked."""
        found = self._names.find(name)
        assert isinstance(found, int), found
        return found

    def _solids_by_node(self) -> dict[int, list[Obstacle]]:
        if self._solids is None:
            self._solids = {}
            for obstacle in self._obstacles():
                self._solids.setdefault(obstacle.node, []).append(obstacle)
        return self._solids

    def _scaled_corners(self, obstacle: Obstacle) -> Array:
        recorder, node = self._recorder, obstacle.node
        if node not in recorder.scaled:
            return obstacle.corners
        return obstacle.corners * recorder.scales[self._row, recorder.scaled.index(node)]


def members_named(names: Collection[str], orders: Orders) -> set[str]:
    """Returns the members that the orders to some performers name."""
    return {
        target for name in names for order in orders.get(name, ()) for target in targets_of(order)
    }


def goal_place(goal: Goal, members: Mapping[str, MemberState]) -> tuple[float, float]:
    """Returns the place (x, z) of a goal on the ground [m]."""
    if not isinstance(goal, str):
        return goal
    x, _, z = members[goal].centre.tolist()
    return x, z
