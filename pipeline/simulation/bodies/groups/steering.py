"""Steering: boids, whose members each react to their nearest neighbours, and their common goal.

Each member keeps away from those too near (separation), matches their velocity (alignment), stays
with them (cohesion), and makes for the goal. Its limited acceleration is spent first on avoiding
obstacles, then on these, so none turns faster than it can.

Neighbours are the nearest few, however far away, so a flock that is drawn apart closes again. They
are looked up a dozen times a second, about as fast as birds notice.

Source: Reynolds 1987; Ballerini et al. 2008 for the number of neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.bodies.groups.group_rule import (
    CastIndex,
    CastPoses,
    GroupContext,
    position_on_ground,
)
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.spec.group import Flock, School, Steered

WAYPOINT_LEAD_TIME = 1.2
"""Time before arrival at a point of the path at which the next one becomes the goal [s]."""


class GoalSelector:
    """The goal of a flock or a school.

    It is the place of the last order, else the performer to follow, else the points of the path
    in turn, else the start.
    """

    def __init__(self, setting: GroupContext, config: Flock | School) -> None:
        self.setting = setting
        self.config = config
        self._followed: int | None = None
        self._next = 0
        self._sent: list[tuple[float, Array]] = []

    def bind(self, cast: CastIndex) -> None:
        """Resolves the performer to follow.

        Raises:
            SceneError: if there is none of this name.
        """
        if self.config.follow is not None:
            path = f"{self.setting.path}.group.follow"
            self._followed = cast.number(self.config.follow, path)

    def send(self, time: float, goal: tuple[float, float], above: float) -> None:
        """Makes for a place (x, z), `above` the ground [m], from `time` [s] on."""
        place = position_on_ground(goal, self.setting.world) + np.array([0.0, above, 0.0])
        self._sent.append((time, place))

    def functions(self, times: Array, others: CastPoses) -> Callable[[int, Array], Array]:
        """Returns a function of k and positions (N, 3) that gives the goal (3,) at `times[k]`."""

        def goal(k: int, p: Array) -> Array:
            sent = [place for time, place in self._sent if time <= times[k]]
            if sent:
                return sent[-1]
            if self._followed is not None:
                return others.p[k, self._followed] + np.array([0.0, self.config.above, 0.0])
            return self._of_path(p) if self.config.path else self.setting.place

        return goal

    def _of_path(self, p: Array) -> Array:
        path = self.config.path
        away = np.array(path[self._next]) - p.mean(axis=0)
        if (away * away).sum() < (WAYPOINT_LEAD_TIME * self.config.speed) ** 2:
            self._next = (self._next + 1) % len(path)
        return np.array(path[self._next])


NEIGHBOUR_COUNT = 7
"""Neighbours that a member reacts to."""

LOOKUP_RATE = 12.0
"""Rate at which neighbours are looked up [1/s]."""

MIN_STEP_RATE = 60.0
"""Least rate of integration steps [1/s]."""

SEPARATION_GAIN = 1.0
"""Gain of separation, relative to the largest acceleration."""

COHESION_GAIN = 0.8
"""Gain of cohesion [1/s²]."""

ALIGNMENT_GAIN = 1.8
"""Gain of alignment [1/s]."""

GOAL_GAIN = 0.7
"""Gain of the velocity towards the goal [1/s]."""

SPEED_GAIN = 1.2
"""Gain of the preferred speed [1/s]."""

SEPARATION_DISTANCE = 1.7
"""Distance below which a neighbour is too near, in sizes."""

VELOCITY_NOISE = 0.16
"""Random walk of the velocity, relative to the speed, per root of a second."""

MIN_SPEED, MAX_SPEED = 0.6, 1.5
"""Bounds of the speed, relative to the preferred one."""

DISTANCE_BLOCK = 256
"""Members whose distances are computed together."""

Evade = Callable[[Array, Array], Array]
"""Maps positions and velocities (N, 3) to evasive accelerations (N, 3), relative to the largest."""


@dataclass(eq=False)
class Steering:
    """N members and their steering rule.

    Attributes:
        config: weights of the rule.
        size: of a member [m].
        speed: preferred speed [m/s].
        agility: largest acceleration [m/s²].
        steepest: largest climb, relative to the speed.
        p: (N, 3) positions [m].
        v: (N, 3) velocities [m/s].
        a: (N, 3) smoothed accelerations [m/s²].
        chance: random generator of the group.
    """

    config: Steered
    size: float
    speed: float
    agility: float
    steepest: float
    p: Array
    v: Array
    a: Array
    chance: np.random.Generator
    _near: NDArray[np.int64] | None = None
    _noticed: float = -1.0

    @staticmethod
    def of(
        config: Steered,
        size: float,
        speed: float,
        agility: float,
        steepest: float,
        places: Array,
        seed: tuple[int, str],
    ) -> Steering:
        """Returns members that begin at `places` (N, 3), all in about one direction."""
        chance = generator(*seed)
        spread = 0.4 * chance.standard_normal(places.shape) * np.array([1.0, 0.2, 1.0])
        ahead = np.array([1.0, 0.0, 0.0]) + spread
        v = speed * ahead / np.sqrt((ahead * ahead).sum(axis=-1, keepdims=True))
        still = np.zeros_like(places)
        return Steering(config, size, speed, agility, steepest, places, v, still, chance)

    def advance(self, time: float, span: float, goal: Array, evade: Evade) -> None:
        """Advances by `span` [s] from `time`, towards `goal` (3,)."""
        count = max(math.ceil(span * MIN_STEP_RATE - 1e-9), 1)
        h = span / count
        for k in range(count):
            now = time + k * h
            if self._near is None or math.floor(now * LOOKUP_RATE + 1e-9) > self._noticed:
                self._noticed = math.floor(now * LOOKUP_RATE + 1e-9)
                self._near = nearest_members(self.p, min(NEIGHBOUR_COUNT, len(self.p) - 1))
            self._step(h, goal, evade)

    def _step(self, h: float, goal: Array, evade: Evade) -> None:
        must = self.agility * evade(self.p, self.v)
        must *= _limit_factors(must, np.full(len(must), self.agility))
        left = self.agility - _length(must)
        wish = self._wish(goal)
        a = must + wish * _limit_factors(wish, left)
        unrest = self.chance.standard_normal(self.p.shape)
        v = self.v + h * a + VELOCITY_NOISE * self.speed * math.sqrt(h) * unrest
        own = _length(v)
        limit = self.steepest * own
        v[:, 1] = np.clip(v[:, 1], -limit, limit)
        own = _length(v)
        bounded = np.clip(own, MIN_SPEED * self.speed, MAX_SPEED * self.speed)
        self.v = v * (bounded / np.maximum(own, 1e-9))[:, None]
        self.p = self.p + h * self.v
        self.a = self.a + (a - self.a) * (1.0 - math.exp(-h / 0.2))

    def _wish(self, goal: Array) -> Array:
        """Returns the accelerations (N, 3) that the rule asks for [m/s²]."""
        config, p, v = self.config, self.p, self.v
        away = goal - p
        towards = self.speed * away / np.maximum(_length(away), 1e-9)[:, None]
        own = _length(v)
        wish = config.goal * GOAL_GAIN * (towards - v)
        wish += SPEED_GAIN * ((self.speed - own) / np.maximum(own, 1e-9))[:, None] * v
        if self._near is None or self._near.shape[1] == 0:
            return wish
        to = p[self._near] - p[:, None]
        far = np.sqrt((to * to).sum(axis=-1))
        room = SEPARATION_DISTANCE * self.size
        close = np.clip(1.0 - far / room, 0.0, 1.0) / np.maximum(far, 1e-9)
        apart = -(to * close[..., None]).sum(axis=1)
        wish += config.separation * SEPARATION_GAIN * self.agility * apart
        wish += config.alignment * ALIGNMENT_GAIN * (v[self._near].mean(axis=1) - v)
        # Neighbours at a good distance do not attract.
        drawn = np.clip(far / room - 1.0, 0.0, 4.0) / np.maximum(far, 1e-9)
        wish += config.cohesion * COHESION_GAIN * room * (to * drawn[..., None]).mean(axis=1)
        return wish


def nearest_members(p: Array, count: int) -> NDArray[np.int64]:
    """Returns the numbers (N, count) of the nearest neighbours of positions `p` (N, 3)."""
    if count < 1:
        return np.zeros((len(p), 0), dtype=np.int64)
    found = np.empty((len(p), count), dtype=np.int64)
    for first in range(0, len(p), DISTANCE_BLOCK):
        some = p[first : first + DISTANCE_BLOCK]
        square = np.zeros((len(some), len(p)))
        for k in range(3):
            square += (some[:, None, k] - p[None, :, k]) ** 2
        square[np.arange(len(some)), first + np.arange(len(some))] = np.inf
        found[first : first + DISTANCE_BLOCK] = np.argpartition(square, count - 1, axis=1)[
            :, :count
        ]
    # Sorted, so that sums have one order.
    found.sort(axis=1)
    return found


def _length(v: Array) -> Array:
    return np.sqrt((v * v).sum(axis=-1))


def _limit_factors(v: Array, most: Array) -> Array:
    """Returns factors (N, 1) that limit the length of vectors (N, 3) to `most` (N,)."""
    return np.minimum(1.0, most / np.maximum(_length(v), 1e-9))[:, None]
