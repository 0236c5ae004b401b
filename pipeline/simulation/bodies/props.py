"""Props: things that move only as their author says.

Here along their keyframes, relative to their parents; what goes along with a parent or is
held in a hand is put in its place when everybody has moved (see `attaching.py`).

Source: Sims 1987, 3.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.bodies.shapes import bottom, solid_of
from pipeline.simulation.script import Orders
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Mesh, Node, Part
from pipeline.simulation.tracks import Key, Track, turned
from pipeline.simulation.troupe import Facts, Inventory, Rows, World
from pipeline.spec.cast import Prop


@dataclass(frozen=True, eq=False)
class Path:
    """Where one prop is, relative to its parent or the world.

    Attributes:
        position: (3,) [m] over time.
        angles: (3,) [rad] over time, see `turned`.
    """

    position: Track
    angles: Track


class Props:
    """All props of a scene."""

    def __init__(self, cast: Sequence[Prop], world: World, materials: Sequence[str]) -> None:
        self.world = world
        self.paths = [_path(member, world) for member in cast]
        self.inventory = _inventory(cast, materials, world.clock.rows)
        self._steps: list[int] = []
        self._step = 0

    def read(self, orders: Orders) -> None:
        """Take in nothing: no script moves a prop."""

    def advance(self, step: int) -> None:
        """Go from `step` to the next."""
        self._step = step + 1

    def keep(self) -> None:
        """Keep the present step as the next row."""
        self._steps.append(self._step)

    def write(self, rows: Rows) -> None:
        """Write all rows kept."""
        times = np.array(self._steps) * self.world.clock.dt
        for i, path in enumerate(self.paths):
            rows.positions[:, i] = path.position(times)
            rows.rotations[:, i] = turned(path.angles(times))
        rows.alive[:] = True
        self._steps.clear()

    def facts(self) -> Facts:
        """Return nothing: props meet nobody."""
        return Facts()


def _path(member: Prop, world: World) -> Path:
    start: list[Key] = [(0.0, tuple(_start(member, world)), "linear")]
    look: list[Key] = [(0.0, (0.0, math.radians(member.heading_deg), 0.0), "linear")]
    places: list[Key] = [
        (k.at, k.position, k.ease) for k in member.keyframes if k.position is not None
    ]
    angles: list[Key] = [
        (k.at, tuple(math.radians(a) for a in k.rotation_deg), k.ease)
        for k in member.keyframes
        if k.rotation_deg is not None
    ]
    return Path(Track.of(places or start), Track.of(angles or look))


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
