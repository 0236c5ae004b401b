"""Props: performers that move only as their author says; those that fall are bodies.

They follow keyframes, a velocity or a force, relative to their parents; attachment to a parent or
a hand comes after all have moved (see `attachment.py`).

Source: Sims 1987, 3.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.bodies.prop_paths import path_of_prop, prop_scale
from pipeline.simulation.bodies.prop_shapes import prop_solid
from pipeline.simulation.inventory import Inventory, rigid_mesh
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.take import Mesh, Node, Part
from pipeline.simulation.troupe import Troupe, World
from pipeline.spec.prop import Prop


class PropTroupe(Troupe):
    """All props of a scene."""

    def __init__(self, cast: Sequence[Prop], world: World, materials: Sequence[str]) -> None:
        self.world = world
        self.paths = [path_of_prop(member, world) for member in cast]
        scales = [prop_scale(member) for member in cast]
        self.scales = [track for track in scales if track is not None]
        scaled = tuple(i for i, track in enumerate(scales) if track is not None)
        self.inventory = replace(_inventory(cast, materials, world.clock.rows), scaled=scaled)
        self._steps: list[int] = []
        self._step = 0

    def advance(self, step: int) -> None:
        """See `Troupe`."""
        self._step = step + 1

    def buffer_row(self) -> None:
        """See `Troupe`."""
        self._steps.append(self._step)

    def write(self, rows: Rows) -> None:
        """See `Troupe`."""
        times = np.array(self._steps) * self.world.clock.dt
        for i, path in enumerate(self.paths):
            rows.positions[:, i], rows.rotations[:, i] = path.at(times)
        for n, track in enumerate(self.scales):
            rows.scales[:, n] = track(times)
        rows.alive[:] = True
        self._steps.clear()


def _inventory(cast: Sequence[Prop], materials: Sequence[str], rows: int) -> Inventory:
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    for i, (member, material) in enumerate(zip(cast, materials, strict=True)):
        solid = prop_solid(member.prop)
        nodes.append(Node(member.name, member.name, -1, (0.0, 0.0, 0.0)))
        meshes.append(rigid_mesh(solid, i))
        size = float(np.ptp(solid.vertices, axis=0).max())
        parts.append(Part(member.name, member.name, i, material, size, (0, rows)))
    return Inventory(tuple(nodes), (), tuple(meshes), tuple(parts))
