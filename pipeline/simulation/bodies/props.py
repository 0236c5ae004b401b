"""Props: things that move only as their author says.

Here along their keyframes, or by velocity or force, relative to their parents; what goes
along with a parent or is held in a hand is put in its place when everybody has moved (see
`attaching.py`).

Source: Sims 1987, 3.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.bodies.paths import path_of, scale_of
from pipeline.simulation.bodies.shapes import bottom, solid_of
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Node, Part
from pipeline.simulation.troupe import Inventory, Rows, Troupe, World
from pipeline.spec.cast import Prop


class Props(Troupe):
    """All props of a scene."""

    def __init__(self, cast: Sequence[Prop], world: World, materials: Sequence[str]) -> None:
        self.world = world
        self.paths = [path_of(member, _start(member, world)) for member in cast]
        scales = [scale_of(member) for member in cast]
        self.scales = [track for track in scales if track is not None]
        scaled = tuple(i for i, track in enumerate(scales) if track is not None)
        self.inventory = replace(_inventory(cast, materials, world.clock.rows), scaled=scaled)
        self._steps: list[int] = []
        self._step = 0

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        self._step = step + 1

    def buffer_row(self) -> None:
        """Keep the present step as the next row."""
        self._steps.append(self._step)

    def write(self, rows: Rows) -> None:
        """Write all rows kept."""
        times = np.array(self._steps) * self.world.clock.dt
        for i, path in enumerate(self.paths):
            rows.positions[:, i], rows.rotations[:, i] = path.at(times)
        for n, track in enumerate(self.scales):
            rows.scales[:, n] = track(times)
        rows.alive[:] = True
        self._steps.clear()


def _start(member: Prop, world: World) -> Array:
    """Return where a prop is without keyframes (3,) [m]."""
    if len(member.at) == 3:
        return np.array(member.at)
    x, z = member.at
    floor = 0.0
    if member.parent is None:
        floor = float(world.ground.height(np.array(x), np.array(z))) + bottom(member.prop)
    return np.array([x, floor, z])


def _inventory(cast: Sequence[Prop], materials: Sequence[str], rows: int) -> Inventory:
    nodes, meshes, parts = list[Node](), list[Mesh](), list[Part]()
    for i, (member, material) in enumerate(zip(cast, materials, strict=True)):
        solid = solid_of(member.prop)
        count = len(solid.vertices)
        nodes.append(Node(member.name, member.name, -1, (0.0, 0.0, 0.0)))
        meshes.append(
            Mesh(
                solid.vertices.astype(np.float32),
                solid.faces,
                np.full((count, 2), i, dtype=np.int32),
                np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1)),
            )
        )
        size = float(np.ptp(solid.vertices, axis=0).max())
        parts.append(Part(member.name, member.name, i, material, size, (0, rows)))
    return Inventory(tuple(nodes), (), tuple(meshes), tuple(parts))
