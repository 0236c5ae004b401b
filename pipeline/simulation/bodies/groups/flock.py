"""Flock: birds that bank where they turn and beat their wings where they climb.

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
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.row_slice import Rows
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import UP, Array, from_directions, rotation, turn
from pipeline.simulation.take import Contact
from pipeline.spec.group import Flock

MAX_CLIMB = 0.55
"""Largest climb, relative to the speed."""

LOOKAHEAD_TIMES = (0.0, 0.4, 0.9)
"""Times ahead at which the ground and obstacles are checked [s]."""

EVASION_TIME = 0.3
"""Distance in which it evades, in seconds of its speed."""

WING_HINGE = np.array([0.05, 0.02, 0.035])
"""Hinge of the right wing, in spans."""

BEAT_RATE = 3.2
"""Wing beats per second for a span of one metre; smaller wings beat faster."""

MAX_BEAT_RATE = 7.0
"""Largest beat rate: more would flicker at film rates [1/s]."""

GLIDE_ANGLE = 0.16
"""Angle of gliding wings [rad]."""

STROKE_ANGLE = 0.75
"""Amplitude of a full beat [rad]."""


class FlockRule(GroupRule):
    """A flock."""

    default_material = "feathers"

    def __init__(self, setting: GroupContext, config: Flock) -> None:
        self.setting = setting
        self.config = config
        chance = generator(setting.world.seed, f"{setting.name} begins")
        away = chance.standard_normal((config.count, 3)) * np.array([1.0, 0.4, 1.0])
        places = setting.place + config.spread / math.sqrt(3.0) * away
        places[:, 1] = np.maximum(places[:, 1], setting.height(places) + config.height)
        self.steering = Steering.of(
            config, config.size, config.speed, config.agility, MAX_CLIMB, places, setting.seed
        )
        self.goals = GoalSelector(setting, config)
        self.phase = 2.0 * math.pi * chance.random(config.count)
        self.effort = np.full(config.count, 0.5)
        span = config.size
        pieces = [
            ("", member_meshes.bird(span)),
            (".right", member_meshes.wing(span, 1.0)),
            (".left", member_meshes.wing(span, -1.0)),
        ]
        self.inventory = member_meshes.inventory(
            setting.name, setting.material, setting.world.clock.rows, config.count, pieces, span
        )
        self._avoided: Sequence[Outline] = ()
        self._time = 0.0

    def bind(self, cast: CastIndex) -> None:
        """See `Rule`."""
        self.goals.bind(cast)
        self._avoided = [cast.outline(name) for name in self.config.avoid]

    def send(self, time: float, goal: tuple[float, float]) -> None:
        """See `Rule`."""
        self.goals.send(time, goal, self.config.height + self.config.above)

    def write(self, rows: Rows, times: Array, others: CastPoses) -> list[Contact]:
        """See `Rule`."""
        goals = self.goals.functions(times, others)
        middles, radii = others.balls(self._avoided)
        for k, time in enumerate(times):
            span = float(time) - self._time
            if span > 0.0:
                self._advance(span, goals(k, self.steering.p), middles[k], radii[k])
                climb = self.steering.v[:, 1] / self.config.speed + 0.05 * self.steering.a[:, 1]
                wanted = np.clip(0.55 + 1.6 * climb, 0.0, 1.0)
                self.effort += (wanted - self.effort) * (1.0 - math.exp(-span / 0.3))
                rate = min(BEAT_RATE / self.config.size**0.75, MAX_BEAT_RATE)
                self.phase += 2.0 * math.pi * rate * span * (0.8 + 0.4 * self.effort)
            self._time = float(time)
            self._pose(rows, k)
        return []

    def _advance(self, span: float, goal: Array, middles: Array, radii: Array) -> None:
        def evade(p: Array, v: Array) -> Array:
            return self._from_ground(p, v) + self._from_others(p, v, middles, radii)

        self.steering.advance(self._time, span, goal, evade)
        p, v = self.steering.p, self.steering.v
        # Hard limits after steering: none is in the ground or in a performer.
        for middle, radius in zip(middles, radii + 0.5 * self.config.size, strict=True):
            _push_out(p, v, middle, float(radius))
        low = self.setting.height(p) + 0.5 * self.config.size
        v[:, 1] = np.where(p[:, 1] < low, np.maximum(v[:, 1], 0.0), v[:, 1])
        p[:, 1] = np.maximum(p[:, 1], low)

    def _from_ground(self, p: Array, v: Array) -> Array:
        """Returns the climb that each needs (N, 3)."""
        room = max(self.config.height, self.config.size)
        must = np.zeros(len(p))
        for ahead in LOOKAHEAD_TIMES:
            q = p + ahead * v
            must = np.maximum(must, (self.setting.height(q) + room - q[:, 1]) / room)
        return np.clip(1.5 * must, 0.0, 1.0)[:, None] * UP

    def _from_others(self, p: Array, v: Array, middles: Array, radii: Array) -> Array:
        """Returns how each must turn away from obstacles (N, 3)."""
        must = np.zeros_like(p)
        margin = EVASION_TIME * self.config.speed
        for middle, radius in zip(middles, radii, strict=True):
            for ahead in LOOKAHEAD_TIMES:
                away = p + ahead * v - middle
                far = np.sqrt((away * away).sum(axis=-1))
                near = np.clip(1.0 - (far - radius - self.config.size) / margin, 0.0, 1.0)
                must += (near / np.maximum(far, 1e-9))[:, None] * away
        return must

    def _pose(self, rows: Rows, k: int) -> None:
        n, steering = self.config.count, self.steering
        along = steering.v / np.sqrt((steering.v**2).sum(axis=-1, keepdims=True))
        # It banks: its up is that of gravity plus acceleration.
        sideways = steering.a - (steering.a * along).sum(axis=-1, keepdims=True) * along
        sideways[:, 1] = 0.0
        R = from_directions(along, sideways + np.array([0.0, GRAVITY, 0.0]))
        rows.positions[k, :n], rows.rotations[k, :n] = steering.p, R
        angle = GLIDE_ANGLE + STROKE_ANGLE * self.effort * np.sin(self.phase)
        for side, first in ((1.0, n), (-1.0, 2 * n)):
            hinge = self.config.size * WING_HINGE * np.array([1.0, 1.0, side])
            here = slice(first, first + n)
            rows.positions[k, here] = steering.p + turn(R, hinge)
            rows.rotations[k, here] = R @ rotation(np.array([1.0, 0.0, 0.0]), -side * angle)


def _push_out(p: Array, v: Array, middle: Array, radius: float) -> None:
    """Moves positions (N, 3) in a ball to its surface, and removes their inward velocity."""
    away = p - middle
    far = np.sqrt((away * away).sum(axis=-1))
    inside = np.flatnonzero(far < radius)
    if len(inside):
        out = away[inside] / np.maximum(far[inside], 1e-9)[:, None]
        p[inside] = middle + radius * out
        v[inside] -= np.minimum((v[inside] * out).sum(axis=-1, keepdims=True), 0.0) * out
