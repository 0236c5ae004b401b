"""Fire: flames that rise from a place, sway, shrink and die; also smoke.

Where the place moves, as a torch in a hand, each flame leaves it where it was born.

Source: Sims 1987, 3.2; Reeves 1983.
"""

from __future__ import annotations

import math

import numpy as np

from pipeline.simulation.bodies.groups import member_meshes
from pipeline.simulation.bodies.groups.counter_random import CounterRandom
from pipeline.simulation.bodies.groups.group_rule import (
    CastIndex,
    CastPoses,
    GroupContext,
    GroupRule,
)
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.spatial import UP, Array, rotation
from pipeline.simulation.take import Contact
from pipeline.spec.group import Fire

SWAY_AMPLITUDE = 0.12
"""Amplitude of swaying, in heights."""

SWAY_CYCLES = 1.7
"""Cycles of swaying in a life."""

GROWTH_FRACTION = 0.08
"""Fraction of its life after which a flame is largest."""

MIN_SCALE = 0.03
"""Scale below which a flame is dead."""


class FireRule(GroupRule):
    """A fire."""

    default_material = "flame"

    def __init__(self, setting: GroupContext, config: Fire) -> None:
        self.setting = setting
        self.config = config
        self.chance = CounterRandom(setting.world.seed, setting.name)
        self.slots = np.arange(config.count)
        # Lives differ, so that the fire does not pulse.
        self.span = config.life * (0.7 + 0.6 * self.chance.uniform(self.slots, 0, 0))
        self.phase = self.chance.uniform(self.slots, 0, 1)
        self.life = np.full(config.count, -1, dtype=np.int64)
        self.source = np.zeros((config.count, 3))
        rows = setting.world.clock.rows
        solid = member_meshes.flame(config.size)
        self.inventory = member_meshes.inventory(
            setting.name, setting.material, rows, config.count, [("", solid)], config.size, True
        )
        self._parent: int | None = None

    def bind(self, cast: CastIndex) -> None:
        """See `Rule`."""
        if self.setting.parent is not None:
            self._parent = cast.number(self.setting.parent, f"{self.setting.path}.parent")

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """See `Rule`; a fire burns where it burns."""

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """See `Rule`."""
        for k, time in enumerate(times):
            turns = float(time) / self.span + self.phase
            life = np.floor(turns).astype(np.int64)
            born = life > self.life
            self.source[born] = self._place(others, k)
            self.life = life
            self._pose(rows, k, turns - life)
        return []

    def _place(self, others: CastPoses, k: int) -> Array:
        """Returns the source of the flames (3,) [m]."""
        if self._parent is None:
            return self.setting.place
        R, p = others.R[k, self._parent], others.p[k, self._parent]
        return p + R @ self.setting.place

    def _pose(self, rows: Rows, k: int, aged: Array) -> None:
        """Writes a row of flames that have lived fractions `aged` (N,) of their lives."""
        config = self.config
        draws = [self.chance.uniform(self.slots, self.life, draw) for draw in range(2, 6)]
        angle, out = 2.0 * math.pi * draws[0], config.radius * np.sqrt(draws[1])
        # Flames in the middle rise highest, where the air is hottest.
        rise = config.height * (1.0 - 0.45 * draws[1]) * (0.75 + 0.25 * draws[2]) * aged
        out = out * (1.0 - 0.75 * aged)
        sway = SWAY_AMPLITUDE * config.height * aged
        turns = 2.0 * math.pi * (SWAY_CYCLES * aged + draws[3])
        seconds = aged * self.span
        offset = np.stack(
            [
                out * np.cos(angle) + sway * np.sin(turns) + config.wind[0] * seconds * aged,
                rise,
                out * np.sin(angle) + sway * np.cos(1.3 * turns) + config.wind[1] * seconds * aged,
            ],
            axis=-1,
        )
        rows.positions[k] = self.source + offset
        rows.rotations[k] = rotation(UP, turns)
        full = np.minimum(aged / GROWTH_FRACTION, 1.0) * (1.0 - aged) ** 0.8
        full = full * (0.6 + 0.4 * draws[2])
        rows.scales[k] = np.maximum(full, MIN_SCALE)[:, None] * np.stack(
            [np.ones_like(aged), 1.0 + 0.9 * (1.0 - aged), np.ones_like(aged)], axis=-1
        )
        rows.alive[k] = full > MIN_SCALE
