"""Grass: blades that stand on the ground, sway in the wind and bend away from feet.

A blade follows two nodes, a fixed one at its root and one that is bent: the higher a point, the
more it follows the other. So one additional node makes a curve of it.

Source: Sims 1987, 3.2; Reeves and Blau 1985 for gusts that travel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.simulation.bodies.groups.counter_random import CounterRandom
from pipeline.simulation.bodies.groups.group_rule import (
    CastIndex,
    CastPoses,
    GroupContext,
    GroupRule,
    Outline,
)
from pipeline.simulation.figures.solids import Solid, join_solids, loft
from pipeline.simulation.inventory import Inventory
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.spatial import UP, Array, heading, rotation
from pipeline.simulation.take import Contact, Mesh, Node, Part
from pipeline.spec.group import Grass

RING_HEIGHTS = np.array([0.0, 0.3, 0.6, 0.85])
"""Heights of a blade's rings, relative to its own."""

HALF_WIDTH = 0.045
"""Half width of a blade at its root, relative to its height."""

WIND_BENDING = 0.11
"""Bending angle by wind [rad s/m]."""

GUST_LENGTH = 1.6
"""Length of gusts [m]."""

TREMBLE_ANGLE = 0.07
"""Individual sway of a blade [rad]."""

MAX_BENDING = 1.35
"""Largest bending angle [rad]."""

FOOT_REACH = 0.8
"""Distance at which a blade bends away from a foot, in its heights."""


class GrassRule(GroupRule):
    """Grass."""

    default_material = "leaf"

    def __init__(self, setting: GroupContext, config: Grass) -> None:
        self.setting = setting
        self.config = config
        chance = CounterRandom(setting.world.seed, setting.name)
        slots = np.arange(config.count)
        x, z, turned, tall, own = (chance.uniform(slots, 0, draw) for draw in range(5))
        roots = np.tile(setting.place, (config.count, 1))
        roots[:, 0] += config.area[0] * (x - 0.5)
        roots[:, 2] += config.area[1] * (z - 0.5)
        roots[:, 1] = setting.height(roots)
        self.roots = roots
        self.looks = heading(2.0 * math.pi * turned)
        self.tall = config.size * (0.65 + 0.5 * tall)
        self.own = 2.0 * math.pi * own
        self.inventory = self._inventory()
        self._avoided: Sequence[Outline] = ()

    def bind(self, cast: CastIndex) -> None:
        """See `Rule`."""
        self._avoided = [cast.outline(name) for name in self.config.avoid]

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """See `Rule`; grass stays where it stands."""

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """See `Rule`."""
        feet = others.points(self._avoided)
        rows.positions[:, 0], rows.rotations[:, 0] = 0.0, np.eye(3)
        rows.positions[:, 1:] = self.roots
        for k, time in enumerate(times):
            bent = self._blown(float(time)) + self._trodden(feet[k])
            angle = np.sqrt((bent * bent).sum(axis=-1))
            # Smoothly limited.
            angle = MAX_BENDING * np.tanh(angle / MAX_BENDING)
            across = np.stack([bent[:, 1], np.zeros(len(bent)), -bent[:, 0]], axis=-1)
            length = np.sqrt((across * across).sum(axis=-1, keepdims=True))
            axis = np.where(length > 1e-12, across / np.maximum(length, 1e-12), UP)
            rows.rotations[k, 1:] = rotation(axis, np.where(length[:, 0] > 1e-12, angle, 0.0))
        return []

    def _blown(self, time: float) -> Array:
        """Returns the bending by wind, along x and z (N, 2) [rad]."""
        wind = np.array(self.config.wind)
        speed = math.sqrt(float((wind * wind).sum()))
        along = wind / speed if speed > 0.0 else np.array([1.0, 0.0])
        # Gusts travel with the wind.
        where = self.roots[:, [0, 2]] @ along - speed * time
        across = self.roots[:, 0] * along[1] - self.roots[:, 2] * along[0]
        gust = 0.55 + 0.3 * np.sin(2.0 * math.pi * where / GUST_LENGTH + 0.8 * np.sin(1.1 * across))
        gust += 0.15 * np.sin(2.0 * math.pi * where / (0.37 * GUST_LENGTH) + self.own)
        blown: Array = (WIND_BENDING * speed * gust)[:, None] * along
        shaken = min(speed, 2.0) / 2.0 * TREMBLE_ANGLE
        blown[:, 0] += shaken * np.sin(5.1 * time + self.own)
        blown[:, 1] += shaken * np.sin(4.3 * time + 1.7 * self.own)
        return blown

    def _trodden(self, feet: Array) -> Array:
        """Returns the bending by points (m, 3) of performers, along x and z (N, 2) [rad]."""
        bent = np.zeros((len(self.roots), 2))
        reach = FOOT_REACH * self.config.size
        low = self.setting.place - np.array([self.config.area[0], 0.0, self.config.area[1]])
        high = self.setting.place + np.array([self.config.area[0], 0.0, self.config.area[1]])
        near = (feet >= low - reach)[:, [0, 2]].all(axis=1)
        near &= (feet <= high + reach)[:, [0, 2]].all(axis=1)
        near &= feet[:, 1] < self.setting.height(feet) + self.config.size if len(feet) else near
        for foot in feet[near]:
            away = (self.roots - foot)[:, [0, 2]]
            far = np.sqrt((away * away).sum(axis=-1))
            # A lifted foot lets the blade rise again.
            above = np.clip(1.0 - (foot[1] - self.roots[:, 1]) / self.tall, 0.0, 1.0)
            push = 1.6 * above * np.clip(1.0 - far / reach, 0.0, 1.0) ** 2
            bent += (push / np.maximum(far, 1e-3))[:, None] * away
        return bent

    def _inventory(self) -> Inventory:
        name, count = self.setting.name, self.config.count
        nodes = [Node(name, name, -1, (0.0, 0.0, 0.0))]
        solids = list[Solid]()
        for i in range(count):
            x, y, z = (float(c) for c in self.roots[i])
            nodes.append(Node(f"{name}.{i}", name, -1, (x, y, z)))
            blade = _blade(float(self.tall[i]))
            solids.append(replace(blade, vertices=blade.vertices @ self.looks[i].T + self.roots[i]))
        whole = join_solids(solids)
        each = len(solids[0].vertices)
        follows = np.zeros((len(whole.vertices), 2), dtype=np.int32)
        follows[:, 0] = 1 + np.repeat(np.arange(count), each)
        height = whole.vertices[:, 1] - np.repeat(self.roots[:, 1], each)
        bent = np.clip(height / np.repeat(self.tall, each), 0.0, 1.0)
        weights = np.stack([bent, 1.0 - bent], axis=-1).astype(np.float32)
        mesh = Mesh(whole.vertices.astype(np.float32), whole.faces, follows, weights)
        rows = self.setting.world.clock.rows
        part = Part(name, name, 0, self.setting.material, self.config.size, (0, rows))
        return Inventory(tuple(nodes), (), (mesh,), (part,))


def _blade(tall: float) -> Solid:
    """Returns a blade of a height [m] that stands on the origin."""
    wide = HALF_WIDTH * tall * np.array([1.0, 0.9, 0.6, 0.3])
    around = 2.0 * math.pi * np.arange(3) / 3.0
    rings = np.zeros((len(RING_HEIGHTS), 3, 3))
    rings[..., 0] = wide[:, None] * np.sin(around)
    rings[..., 1] = tall * RING_HEIGHTS[:, None]
    rings[..., 2] = 0.35 * wide[:, None] * np.cos(around)
    return loft(rings, np.array([[0.0, 0.0, 0.0], [0.0, tall, 0.0]]))
