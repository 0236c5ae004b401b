"""Rain: drops that fall at constant speed and end as splashes on the ground.

A drop is a function of time: the n-th of a slot falls on a random place that depends on n. So the
rain is the same whatever the frame rate, and strikes at exact times.

Source: Sims 1987, 3.2; Reeves 1983.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.bodies.groups import member_meshes
from pipeline.simulation.bodies.groups.counter_random import CounterRandom
from pipeline.simulation.bodies.groups.group_rule import (
    CastIndex,
    CastPoses,
    GroupContext,
    GroupRule,
)
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.spatial import Array, from_directions
from pipeline.simulation.take import Contact
from pipeline.spec.group import Rain

SPLASH_DURATION = 0.12
"""Duration of a splash [s]."""

SLOT_PAUSE = 0.03
"""Pause of a slot after it [s]."""

SPLASH_HEIGHT, SPLASH_WIDTH = 0.06, 9.0
"""Initial height and final width of a splash, relative to the drop."""

WATER_DIAMETER = 0.05
"""Diameter of the water in a drop, relative to its visible length."""

WATER_DENSITY = 1000.0
"""Density of water [kg/m³]."""


class RainRule(GroupRule):
    """Rain."""

    default_material = "water"

    def __init__(self, setting: GroupContext, config: Rain) -> None:
        self.setting = setting
        self.config = config
        self.chance = CounterRandom(setting.world.seed, setting.name)
        self.fall = config.height / config.speed
        self.period = self.fall + SPLASH_DURATION + SLOT_PAUSE
        self.slots = np.arange(config.count)
        # Evenly spaced, so that equally many strike in every second.
        self.phase = self.chance.uniform(self.slots, 0, 0) + self.slots
        self.phase = self.phase / config.count
        drift = np.array([config.wind[0], -config.speed, config.wind[1]])
        self.drift = drift
        up = -drift / math.sqrt(float((drift * drift).sum()))
        self.leaning = from_directions(np.array([up[1], -up[0], 0.0]), up)
        solid = member_meshes.drop(config.size)
        rows = setting.world.clock.rows
        self.inventory = member_meshes.inventory(
            setting.name, setting.material, rows, config.count, [("", solid)], config.size, True
        )
        self._time = 0.0

    def bind(self, cast: CastIndex) -> None:
        """See `Rule`; rain knows nobody."""

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """See `Rule`; rain falls where it falls."""

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """See `Rule`."""
        contacts = list[Contact]()
        for k, time in enumerate(times):
            turns = float(time) / self.period + self.phase
            life = np.floor(turns).astype(np.int64)
            age = (turns - life) * self.period
            ends = self.ends(life)
            falling = age < self.fall
            rows.positions[k] = np.where(
                falling[:, None], ends - (self.fall - age)[:, None] * self.drift, ends
            )
            rows.rotations[k] = np.where(falling[:, None, None], self.leaning, np.eye(3))
            grown = np.clip((age - self.fall) / SPLASH_DURATION, 0.0, 1.0)
            wide = 2.0 + (SPLASH_WIDTH - 2.0) * np.sqrt(grown)
            splash = np.stack([wide, SPLASH_HEIGHT * (1.0 - grown) + 1e-3, wide], axis=-1)
            rows.scales[k] = np.where(falling[:, None], 1.0, splash)
            rows.alive[k] = age < self.fall + SPLASH_DURATION
            if self.config.splash and time > self._time:
                contacts += self._struck(self._time, float(time))
            self._time = float(time)
        return contacts

    def ends(self, life: NDArray[np.int64]) -> Array:
        """Returns the positions (N, 3) at which drops of these lives strike the ground [m]."""
        x, z = (self.chance.uniform(self.slots, life, draw) - 0.5 for draw in (1, 2))
        ends = np.tile(self.setting.place, (len(life), 1))
        ends[:, 0] += self.config.area[0] * x
        ends[:, 2] += self.config.area[1] * z
        ends[:, 1] = self.setting.height(ends)
        return ends

    def _struck(self, before: float, now: float) -> list[Contact]:
        """Returns the contacts of drops that struck after `before` and not after `now` [s]."""
        clock, config = self.setting.world.clock, self.config
        struck = []
        share = self.fall / self.period
        # A drop strikes when its turns pass `share` beyond a whole number.
        first = np.floor(before / self.period + self.phase - share).astype(np.int64) + 1
        last = np.floor(now / self.period + self.phase - share).astype(np.int64)
        ends = self.ends(first)
        mass = WATER_DENSITY * math.pi / 6.0 * (WATER_DIAMETER * config.size) ** 3
        for i in np.flatnonzero(last >= first).tolist():
            time = (int(first[i]) + share - float(self.phase[i])) * self.period
            step = min(int(time / clock.dt), clock.last_step)
            x, y, z = (float(c) for c in ends[i])
            normal = self.setting.world.ground.normal(np.array(x), np.array(z))
            a, b, c = (float(part) for part in normal)
            speed = float(-(self.drift * normal).sum())
            struck.append(
                Contact(
                    step=step,
                    fraction=min(max(time / clock.dt - step, 0.0), math.nextafter(1.0, 0.0)),
                    performer=self.setting.name,
                    part=str(i),
                    other="terrain",
                    place=(x, y, z),
                    normal=(a, b, c),
                    speed=speed,
                    energy=0.5 * mass * speed * speed,
                    material=self.setting.material,
                    surface=self.setting.world.ground.material,
                    size=WATER_DIAMETER * config.size,
                    kind="hit",
                )
            )
        return sorted(struck, key=lambda contact: (contact.step, contact.fraction))
