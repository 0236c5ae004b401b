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
"""How long before it would be at a place of its path it makes for the next [s]."""


class GoalSelector:
    """What one group makes for."""

    def __init__(self, setting: GroupContext, words: Flock | School) -> None:
        self.setting = setting
        self.words = words
        self._followed: int | None = None
        self._next = 0
        self._sent: list[tuple[float, Array]] = []

    def meet(self, cast: CastIndex) -> None:
        """Find whom it follows.

        Raises:
            SceneError: nobody is called so.
        """
        if self.words.follow is not None:
            path = f"{self.setting.path}.group.follow"
            self._followed = cast.number(self.words.follow, path)

    def send(self, time: float, goal: tuple[float, float], above: float) -> None:
        """Make for a place (x, z), `above` the ground [m], from `time` [s] on."""
        place = position_on_ground(goal, self.setting.world) + np.array([0.0, above, 0.0])
        self._sent.append((time, place))

    def goals(self, times: Array, others: CastPoses) -> Callable[[int, Array], Array]:
        """Return what says the goal (3,) of the k-th of `times`, given the places (N, 3)."""

        def goal(k: int, p: Array) -> Array:
            sent = [place for time, place in self._sent if time <= times[k]]
            if sent:
                return sent[-1]
            if self._followed is not None:
                up = np.array([0.0, self.words.above, 0.0])
                followed: Array = others.p[k, self._followed] + up
                return followed
            return self._of_path(p) if self.words.path else self.setting.place

        return goal

    def _of_path(self, p: Array) -> Array:
        path = self.words.path
        place = np.array(path[self._next])
        away = place - p.mean(axis=0)
        if (away * away).sum() < (WAYPOINT_LEAD_TIME * self.words.speed) ** 2:
            self._next = (self._next + 1) % len(path)
        return np.array(path[self._next])


NEIGHBOUR_COUNT = 7

LOOKUP_RATE = 12.0
"""Looks at the neighbours [1/s]."""

MIN_STEP_RATE = 60.0
"""Least steps of the rule [1/s]."""

SEPARATION_GAIN, COHESION_GAIN, ALIGNMENT_GAIN, GOAL_GAIN, SPEED_GAIN = 1.0, 0.8, 1.8, 0.7, 1.2
"""Gains of separation (of the largest acceleration), cohesion [1/s²], alignment, the goal and
the own speed [1/s]."""

SEPARATION_DISTANCE = 1.7
"""Distance at which a neighbour is too near, in sizes."""

VELOCITY_NOISE = 0.16
"""How much each goes its own way, as a part of its speed in the root of a second."""

MIN_SPEED, MAX_SPEED = 0.6, 1.5
"""Bounds of the speed, as parts of the one they like."""

DISTANCE_BLOCK = 256
"""Members whose distances are looked at together."""

Evade = Callable[[Array, Array], Array]
"""Places and velocities (N, 3) -> accelerations (N, 3) away from what is in the way, as parts
of the largest."""


@dataclass(eq=False)
class Steering:
    """N members, and the rule that they go by.

    Attributes:
        words: weights of the rule.
        size: of a member [m].
        speed: that they like [m/s].
        agility: largest acceleration [m/s²].
        steepest: largest climb, as a part of the speed.
        p: (N, 3) places [m].
        v: (N, 3) velocities [m/s].
        a: (N, 3) accelerations, smoothed [m/s²].
        chance: of the group.
    """

    words: Steered
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
        words: Steered,
        size: float,
        speed: float,
        agility: float,
        steepest: float,
        places: Array,
        seed: tuple[int, str],
    ) -> Steering:
        """Return members that begin at `places` (N, 3), all of them in about one direction."""
        chance = generator(*seed)
        spread = 0.4 * chance.standard_normal(places.shape) * np.array([1.0, 0.2, 1.0])
        ahead = np.array([1.0, 0.0, 0.0]) + spread
        v = speed * ahead / np.sqrt((ahead * ahead).sum(axis=-1, keepdims=True))
        still = np.zeros_like(places)
        return Steering(words, size, speed, agility, steepest, places, v, still, chance)

    def advance(self, time: float, span: float, goal: Array, evade: Evade) -> None:
        """Go on by `span` [s] from `time`, towards `goal` (3,)."""
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
        self.v = self._flyable(v)
        self.p = self.p + h * self.v
        self.a = self.a + (a - self.a) * (1.0 - math.exp(-h / 0.2))

    def _wish(self, goal: Array) -> Array:
        """Return the accelerations (N, 3) that the rule asks for [m/s²]."""
        words, p, v = self.words, self.p, self.v
        away = goal - p
        towards = self.speed * away / np.maximum(_length(away), 1e-9)[:, None]
        own = _length(v)
        wish = words.goal * GOAL_GAIN * (towards - v)
        wish += SPEED_GAIN * ((self.speed - own) / np.maximum(own, 1e-9))[:, None] * v
        if self._near is None or self._near.shape[1] == 0:
            return wish
        to = p[self._near] - p[:, None]
        far = np.sqrt((to * to).sum(axis=-1))
        room = SEPARATION_DISTANCE * self.size
        close = np.clip(1.0 - far / room, 0.0, 1.0) / np.maximum(far, 1e-9)
        apart = -(to * close[..., None]).sum(axis=1)
        wish += words.separation * SEPARATION_GAIN * self.agility * apart
        wish += words.alignment * ALIGNMENT_GAIN * (v[self._near].mean(axis=1) - v)
        # Who has its neighbours about it at a good distance is drawn nowhere.
        drawn = np.clip(far / room - 1.0, 0.0, 4.0) / np.maximum(far, 1e-9)
        wish += words.cohesion * COHESION_GAIN * room * (to * drawn[..., None]).mean(axis=1)
        return wish

    def _flyable(self, v: Array) -> Array:
        """Return velocities (N, 3) that are neither too slow nor too fast nor too steep."""
        own = _length(v)
        limit = self.steepest * own
        v[:, 1] = np.clip(v[:, 1], -limit, limit)
        own = _length(v)
        bounded = np.clip(own, MIN_SPEED * self.speed, MAX_SPEED * self.speed)
        result: Array = v * (bounded / np.maximum(own, 1e-9))[:, None]
        return result


def nearest_members(p: Array, count: int) -> NDArray[np.int64]:
    """Return the numbers (N, count) of the nearest of each of the places `p` (N, 3)."""
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
    # In the order of their numbers, so that sums are added up in one order.
    found.sort(axis=1)
    return found


def _length(v: Array) -> Array:
    result: Array = np.sqrt((v * v).sum(axis=-1))
    return result


def _limit_factors(v: Array, most: Array) -> Array:
    """Return factors (N, 1) that make vectors (N, 3) no longer than `most` (N,)."""
    result: Array = np.minimum(1.0, most / np.maximum(_length(v), 1e-9))[:, None]
    return result
