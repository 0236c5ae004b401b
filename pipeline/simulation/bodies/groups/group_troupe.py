"""Groups: the troupe of all groups of a scene.

They move when everybody else has and is in its place, row by row.

Source: Sims 1987, 3.2.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.simulation.bodies.groups.fire import FireRule
from pipeline.simulation.bodies.groups.flock import FlockRule
from pipeline.simulation.bodies.groups.grass import GrassRule
from pipeline.simulation.bodies.groups.group_rule import (
    CastIndex,
    CastPoses,
    GroupContext,
    GroupRule,
    position_on_ground,
)
from pipeline.simulation.bodies.groups.rain import RainRule
from pipeline.simulation.bodies.groups.school import SchoolRule
from pipeline.simulation.bodies.groups.swarm import SwarmRule
from pipeline.simulation.inventory import join_inventories
from pipeline.simulation.members import MemberState, goal_place, members_named
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, Mesh, Node
from pipeline.simulation.troupe import Troupe, World, WriteStage
from pipeline.spec.group import Fire, Flock, Grass, Group, Rain, School, Swarm
from pipeline.spec.script import GoTo

GROUP_RULES: dict[type[Any], type[Any]] = {
    Flock: FlockRule,
    School: SchoolRule,
    Swarm: SwarmRule,
    Rain: RainRule,
    Fire: FireRule,
    Grass: GrassRule,
}
"""Rule of each model of a group; a new rule is a model, a module and a line here."""


class GroupTroupe(Troupe):
    """All groups of a scene."""

    write_stage = WriteStage.LAST

    def __init__(self, cast: Sequence[tuple[int, Group]], world: World) -> None:
        self.world = world
        self.rules = {member.name: _build_rule(i, member, world) for i, member in cast}
        self.inventory = join_inventories(rule.inventory for rule in self.rules.values())
        self._step = 0
        self._steps: list[int] = []
        self._rows: Rows | None = None
        self._members: Mapping[str, MemberState] = {}

    def bind(self, nodes: Sequence[Node], meshes: Sequence[Mesh], names: NodeNames) -> None:
        """See `Troupe`."""
        for rule in self.rules.values():
            rule.bind(CastIndex(nodes, meshes, names))

    def members_needed(self, orders: Orders) -> Collection[str]:
        """See `Troupe`."""
        return members_named(self.rules, orders)

    def see_members(self, members: Mapping[str, MemberState]) -> None:
        """See `Troupe`."""
        self._members = members

    def read(self, orders: Orders) -> None:
        """See `Troupe`."""
        time = self._step * self.world.clock.dt
        for name, rule in self.rules.items():
            for do in orders.get(name, ()):
                if isinstance(do, GoTo):
                    rule.send(time, goal_place(do.go_to, self._members))

    def advance(self, step: int) -> None:
        """See `Troupe`; members move in `write_last`."""
        self._step = step + 1

    def buffer_row(self) -> None:
        """See `Troupe`."""
        self._steps.append(self._step)

    def write(self, rows: Rows) -> None:
        """Takes rows that `write_last` fills."""
        rows.alive[:] = True
        self._rows = rows

    def write_last(self, R: Array, p: Array) -> list[Contact]:
        """See `Troupe`."""
        assert self._rows is not None
        times = np.array(self._steps) * self.world.clock.dt
        contacts, node, scale = list[Contact](), 0, 0
        for rule in self.rules.values():
            nodes = slice(node, node := node + len(rule.inventory.nodes))
            scales = slice(scale, scale := scale + len(rule.inventory.scaled))
            rows = self._rows
            own = replace(
                rows,
                positions=rows.positions[:, nodes],
                rotations=rows.rotations[:, nodes],
                alive=rows.alive[:, nodes],
                scales=rows.scales[:, scales],
            )
            contacts += rule.write(own, times, CastPoses(R, p))
        self._steps.clear()
        return contacts


def _build_rule(i: int, member: Group, world: World) -> GroupRule:
    rule = GROUP_RULES[type(member.group)]
    place = np.array(member.at if len(member.at) == 3 else (member.at[0], 0.0, member.at[1]))
    if member.parent is None:
        place = position_on_ground(member.at, world)
    material = member.material or rule.default_material
    setting = GroupContext(member.name, f"cast[{i}]", place, member.parent, material, world)
    return rule(setting, member.group)
