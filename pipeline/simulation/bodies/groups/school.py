"""School: fish that stay in a volume of water and wag their tails.

Source: Sims 1987, 3.2; Reynolds 1987.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pipeline.simulation.bodies.groups import member_meshes
from pipeline.simulation.bodies.groups.group_rule import CastIndex, CastPoses, GroupContext, Outline
from pipeline.simulation.bodies.groups.steering import GoalSelector, Steering
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import UP, Array, from_directions, rotation, turn
from pipeline.simulation.take import Contact
from pipeline.simulation.troupe import Rows
from pipeline.spec.group import School

STEEPEST = 0.35
"""Largest climb, as a part of the speed."""

MARGIN = 0.8
"""Way on which it turns at the edge of its water, in seconds of its speed."""

WAG, WAGS = 0.55, 1.1
"""Angle of the tail [rad], and wags for each length that it swims."""


class SchoolRule:
    """A school."""

    def __init__(self, setting: GroupContext, words: School) -> None:
        self.setting = setting
        self.words = words
        chance = generator(setting.world.seed, f"{setting.name} begins")
        half = 0.5 * np.array(words.volume)
        self.low, self.high = setting.place - half, setting.place + half
        places = setting.place + 0.5 * half * (2.0 * chance.random((words.count, 3)) - 1.0)
        self.steering = Steering.of(
            words, words.size, words.speed, words.agility, STEEPEST, places, setting.seed
        )
        self.making = GoalSelector(setting, words)
        self.phase = 2.0 * math.pi * chance.random(words.count)
        pieces = [("", member_meshes.fish(words.size)), (".tail", member_meshes.fin(words.size))]
        rows = setting.world.clock.rows
        self.inventory = member_meshes.inventory(
            setting.name, setting.material, rows, words.count, pieces, words.size
        )
        self._avoided: Sequence[Outline] = ()
        self._time = 0.0

    def meet(self, cast: CastIndex) -> None:
        """See `Rule`."""
        self.making.meet(cast)
        self._avoided = [cast.outline(name) for name in self.words.avoid]

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """See `Rule`."""
        self.making.send(time, goal, self.words.above)

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """See `Rule`."""
        goals = self.making.goals(times, others)
        middles, radii = others.balls(self._avoided)
        for k, time in enumerate(times):
            span = float(time) - self._time
            if span > 0.0:
                self._advance(span, goals(k, self.steering.p), middles[k], radii[k])
            self._time = float(time)
            self._pose(rows, k)
        return []

    def _advance(self, span: float, goal: Array, middles: Array, radii: Array) -> None:
        margin = MARGIN * self.words.speed

        def evade(p: Array, v: Array) -> Array:
            must = np.clip((self.low + margin - p) / margin, 0.0, 1.0)
            must -= np.clip((p - self.high + margin) / margin, 0.0, 1.0)
            for middle, radius in zip(middles, radii, strict=True):
                away = p + 0.5 * v - middle
                far = np.sqrt((away * away).sum(axis=-1))
                near = np.clip(1.0 - (far - radius - self.words.size) / margin, 0.0, 1.0)
                must += (near / np.maximum(far, 1e-9))[:, None] * away
            return must

        self.steering.advance(self._time, span, goal, evade)
        p, v = self.steering.p, self.steering.v
        # The last of its water is a wall.
        low = np.tile(self.low, (len(p), 1))
        low[:, 1] = np.maximum(low[:, 1], self.setting.height(p) + 0.3 * self.words.size)
        high = np.maximum(self.high, low)
        v[(p < low) & (v < 0.0)] *= -0.2
        v[(p > high) & (v > 0.0)] *= -0.2
        np.clip(p, low, high, out=p)
        pace = np.sqrt((v * v).sum(axis=-1))
        self.phase += 2.0 * math.pi * WAGS * pace * span / self.words.size

    def _pose(self, rows: Rows, k: int) -> None:
        n, steering = self.words.count, self.steering
        # Along the velocity of a while: a fish does not turn on the spot.
        along = steering.v / np.maximum(np.sqrt((steering.v**2).sum(axis=-1, keepdims=True)), 1e-9)
        R = from_directions(along, np.broadcast_to(UP, along.shape))
        rows.positions[k, :n] = steering.p
        rows.rotations[k, :n] = R @ rotation(UP, -0.15 * WAG * np.sin(self.phase))
        hinge = np.array([-0.28 * self.words.size, 0.0, 0.0])
        rows.positions[k, n:] = steering.p + turn(rows.rotations[k, :n], hinge)
        rows.rotations[k, n:] = R @ rotation(UP, WAG * np.sin(self.phase - 0.9))
