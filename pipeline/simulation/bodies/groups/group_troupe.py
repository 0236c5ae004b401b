"""Groups: the troupe of all groups of a scene.

They move when everybody else has and is in its place, row by row.

Source: Sims 1987, 3.2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.inventory import join_inventories
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, Mesh, Node
from pipeline.simulation.troupe import Rows, Troupe, World, WriteStage
from pipeline.spec.group import Fire, Flock, Grass, Group, Rain, School, Swarm
from pipeline.spec.script import GoTo

RULES: dict[type[Any], Callable[[GroupContext, Any], GroupRule]] = {
    Flock: FlockRule,
    School: SchoolRule,
    Swarm: SwarmRule,
    Rain: RainRule,
    Fire: FireRule,
    Grass: GrassRule,
}

MATERIALS: dict[type[Any], str] = {
    Flock: "feathers",
    School: "steel",
    Swarm: "black chitin",
    Rain: "water",
    Fire: "flame",
    Grass: "leaf",
}
"""Of groups that name none."""

Member = tuple[int, Group]
"""Place in the cast, and words."""


class GroupTroupe(Troupe):
    """All groups of a scene."""

    write_stage = WriteStage.LAST

    def __init__(self, cast: Sequence[Member], world: World) -> None:
        self.world = world
        self.rules = {member.name: _rule(i, member, world) for i, member in cast}
        self.inventory = join_inventories(rule.inventory for rule in self.rules.values())
        self._step = 0
        self._steps: list[int] = []
        self._rows: Rows | None = None

    def bind(
        self, nodes: Sequence[Node], meshes: Sequence[Mesh], figures: Mapping[str, Figure]
    ) -> None:
        """Find those whom groups follow, avoid or go along with.

        Args:
            nodes: of all performers.
            meshes: of all performers.
            figures: of the creatures, by name.

        Raises:
            SceneError: somebody has no such part.
        """
        for rule in self.rules.values():
            rule.meet(CastIndex(nodes, meshes, figures))

    def read(self, orders: Orders) -> None:
        """Take in where the script sends groups."""
        time = self._step * self.world.clock.dt
        for name, rule in self.rules.items():
            for do in orders.get(name, ()):
                if isinstance(do, GoTo):
                    rule.send(time, do.go_to)

    def advance(self, step: int) -> None:
        """Go from `step` to the next; what has moved by then is seen in `write_last`."""
        self._step = step + 1

    def buffer_row(self) -> None:
        """Keep the present step as the next row."""
        self._steps.append(self._step)

    def write(self, rows: Rows) -> None:
        """Take rows that are to be written when everybody is in its place."""
        rows.alive[:] = True
        self._rows = rows

    def write_last(self, R: Array, p: Array) -> list[Contact]:
        """Write all rows kept, and return the contacts that began in them.

        Args:
            R: (n, J, 3, 3) rotations of all nodes in these rows.
            p: (n, J, 3) their positions [m].
        """
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


def _rule(i: int, member: Group, world: World) -> GroupRule:
    kind = type(member.group)
    place = np.array(member.at if len(member.at) == 3 else (member.at[0], 0.0, member.at[1]))
    if member.parent is None:
        place = position_on_ground(member.at, world)
    material = member.material or MATERIALS[kind]
    setting = GroupContext(member.name, f"cast[{i}]", place, member.parent, material, world)
    return RULES[kind](setting, member.group)
