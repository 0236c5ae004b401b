"""School: fish that stay in a volume of water and wag their tails.

Source: Sims 1987, 3.2; Reynolds 1987.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.bodies.groups import member_meshes
from pipeline.simulation.bodies.groups.group_rule import (
    CastIndex,
    CastPoses,
    GroupContext,
    GroupRule,
    Outline,
)
from pipeline.simulation.bodies.groups.steering import GoalSelector, Steering
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import UP, Array, from_directions, rotation, turn
from pipeline.simulation.take import Contact
from pipeline.spec.group import School

MAX_CLIMB = 0.35
"""Largest climb, relative to the speed."""

EVASION_TIME = 0.8
"""Distance in which it turns at the edge of its water, in seconds of its speed."""

WAG_ANGLE = 0.55
"""Amplitude of the tail [rad]."""

WAGS_PER_LENGTH = 1.1
"""Wags of the tail per body length swum."""


class SchoolRule(GroupRule):
    """A school."""

    default_material = "steel"

    def __init__(self, setting: GroupContext, config: School) -> None:
        self.setting = setting
        self.config = config
        chance = generator(setting.world.seed, f"{setting.name} begins")
        half = 0.5 * np.array(config.volume)
        self.low, self.high = setting.place - half, setting.place + half
        places = setting.place + 0.5 * half * (2.0 * chance.random((config.count, 3)) - 1.0)
        self.steering = Steering.of(
            config, config.size, config.speed, config.agility, MAX_CLIMB, places, setting.seed
        )
        self.goals = GoalSelector(setting, config)
        self.phase = 2.0 * math.pi * chance.random(config.count)
        pieces = [("", member_meshes.fish(config.size)), (".tail", member_meshes.fin(config.size))]
        rows = setting.world.clock.rows
        self.inventory = member_meshes.inventory(
            setting.name, setting.material, rows, config.count, pieces, config.size
        )
        self._avoided: Sequence[Outline] = ()
        self._time = 0.0

    def bind(self, cast: CastIndex) -> None:
        """See `Rule`."""
        self.goals.bind(cast)
        self._avoided = [cast.outline(name) for name in self.config.avoid]

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """See `Rule`."""
        self.goals.send(time, goal, self.config.above)

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """See `Rule`."""
        goals = self.goals.functions(times, others)
        middles, radii = others.balls(self._avoided)
        for k, time in enumerate(times):
            span = float(time) - self._time
            if span > 0.0:
                self._advance(span, goals(k, self.steering.p), middles[k], radii[k])
            self._time = float(time)
            self._pose(rows, k)
        return []

    def _advance(self, span: float, goal: Array, middles: Array, radii: Array) -> None:
        margin = EVASION_TIME * self.config.speed

        def evade(p: Array, v: Array) -> Array:
            must = np.clip((self.low + margin - p) / margin, 0.0, 1.0)
            must -= np.clip((p - self.high + margin) / margin, 0.0, 1.0)
            for middle, radius in zip(middles, radii, strict=True):
                away = p + 0.5 * v - middle
                far = np.sqrt((away * away).sum(axis=-1))
                near = np.clip(1.0 - (far - radius - self.config.size) / margin, 0.0, 1.0)
                must += (near / np.maximum(far, 1e-9))[:, None] * away
            return must

        self.steering.advance(self._time, span, goal, evade)
        p, v = self.steering.p, self.steering.v
        # The edge of its water is a wall.
        low = np.tile(self.low, (len(p), 1))
        low[:, 1] = np.maximum(low[:, 1], self.setting.height(p) + 0.3 * self.config.size)
        high = np.maximum(self.high, low)
        v[(p < low) & (v < 0.0)] *= -0.2
        v[(p > high) & (v > 0.0)] *= -0.2
        np.clip(p, low, high, out=p)
        pace = np.sqrt((v * v).sum(axis=-1))
        self.phase += 2.0 * math.pi * WAGS_PER_LENGTH * pace * span / self.config.size

    def _pose(self, rows: Rows, k: int) -> None:
        n, steering = self.config.count, self.steering
        # A fish does not turn on the spot.
        along = steering.v / np.maximum(np.sqrt((steering.v**2).sum(axis=-1, keepdims=True)), 1e-9)
        R = from_directions(along, np.broadcast_to(UP, along.shape))
        rows.positions[k, :n] = steering.p
        rows.rotations[k, :n] = R @ rotation(UP, -0.15 * WAG_ANGLE * np.sin(self.phase))
        hinge = np.array([-0.28 * self.config.size, 0.0, 0.0])
        rows.positions[k, n:] = steering.p + turn(rows.rotations[k, :n], hinge)
        rows.rotations[k, n:] = R @ rotation(UP, WAG_ANGLE * np.sin(self.phase - 0.9))
