"""Steering: flocks and schools, of which each member goes by what its neighbours do.

Each keeps away from those too near (separation), goes where its neighbours go (alignment) and
keeps to them (cohesion), and makes for what all make for. What it may accelerate by goes first
to what it must not run into, and then to these; so none turns faster than it can.

Its neighbours are the nearest few, however far away: so a flock that is drawn apart closes
again. They are looked for a dozen times a second, which is as fast as birds notice.

Source: Reynolds 1987; Ballerini et al. 2008 for the number of neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array
from pipeline.spec.group import Steered

NEIGHBOURS = 7

NOTICING = 12.0
"""Looks at the neighbours [1/s]."""

PACE = 60.0
"""Least steps of the rule [1/s]."""

APART, TOGETHER, ALIKE, TOWARDS, CRUISE = 1.0, 0.8, 1.8, 0.7, 1.2
"""Gains of separation (of the largest acceleration), cohesion [1/s²], alignment, the goal and
the own speed [1/s]."""

LOOSE = 1.7
"""Distance at which a neighbour is too near, in sizes."""

UNREST = 0.16
"""How much each goes its own way, as a part of its speed in the root of a second."""

SLOWEST, FASTEST = 0.6, 1.5
"""Bounds of the speed, as parts of the one they like."""

BLOCK = 256
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
        count = max(math.ceil(span * PACE - 1e-9), 1)
        h = span / count
        for k in range(count):
            now = time + k * h
            if self._near is None or math.floor(now * NOTICING + 1e-9) > self._noticed:
                self._noticed = math.floor(now * NOTICING + 1e-9)
                self._near = nearest(self.p, min(NEIGHBOURS, len(self.p) - 1))
            self._step(h, goal, evade)

    def _step(self, h: float, goal: Array, evade: Evade) -> None:
        must = self.agility * evade(self.p, self.v)
        must *= _fraction(must, np.full(len(must), self.agility))
        left = self.agility - _length(must)
        wish = self._wish(goal)
        a = must + wish * _fraction(wish, left)
        unrest = self.chance.standard_normal(self.p.shape)
        v = self.v + h * a + UNREST * self.speed * math.sqrt(h) * unrest
        self.v = self._flyable(v)
        self.p = self.p + h * self.v
        self.a = self.a + (a - self.a) * (1.0 - math.exp(-h / 0.2))

    def _wish(self, goal: Array) -> Array:
        """Return the accelerations (N, 3) that the rule asks for [m/s²]."""
        words, p, v = self.words, self.p, self.v
        away = goal - p
        towards = self.speed * away / np.maximum(_length(away), 1e-9)[:, None]
        own = _length(v)
        wish = words.goal * TOWARDS * (towards - v)
        wish += CRUISE * ((self.speed - own) / np.maximum(own, 1e-9))[:, None] * v
        if self._near is None or self._near.shape[1] == 0:
            return wish
        to = p[self._near] - p[:, None]
        far = np.sqrt((to * to).sum(axis=-1))
        room = LOOSE * self.size
        close = np.clip(1.0 - far / room, 0.0, 1.0) / np.maximum(far, 1e-9)
        apart = -(to * close[..., None]).sum(axis=1)
        wish += words.separation * APART * self.agility * apart
        wish += words.alignment * ALIKE * (v[self._near].mean(axis=1) - v)
        # Who has its neighbours about it at a good distance is drawn nowhere.
        drawn = np.clip(far / room - 1.0, 0.0, 4.0) / np.maximum(far, 1e-9)
        wish += words.cohesion * TOGETHER * room * (to * drawn[..., None]).mean(axis=1)
        return wish

    def _flyable(self, v: Array) -> Array:
        """Return velocities (N, 3) that are neither too slow nor too fast nor too steep."""
        own = _length(v)
        limit = self.steepest * own
        v[:, 1] = np.clip(v[:, 1], -limit, limit)
        own = _length(v)
        bounded = np.clip(own, SLOWEST * self.speed, FASTEST * self.speed)
        result: Array = v * (bounded / np.maximum(own, 1e-9))[:, None]
        return result


def nearest(p: Array, count: int) -> NDArray[np.int64]:
    """Return the numbers (N, count) of the nearest of each of the places `p` (N, 3)."""
    if count < 1:
        return np.zeros((len(p), 0), dtype=np.int64)
    found = np.empty((len(p), count), dtype=np.int64)
    for first in range(0, len(p), BLOCK):
        some = p[first : first + BLOCK]
        square = np.zeros((len(some), len(p)))
        for k in range(3):
            square += (some[:, None, k] - p[None, :, k]) ** 2
        square[np.arange(len(some)), first + np.arange(len(some))] = np.inf
        found[first : first + BLOCK] = np.argpartition(square, count - 1, axis=1)[:, :count]
    # In the order of their numbers, so that sums are added up in one order.
    found.sort(axis=1)
    return found


def _length(v: Array) -> Array:
    result: Array = np.sqrt((v * v).sum(axis=-1))
    return result


def _fraction(v: Array, most: Array) -> Array:
    """Return factors (N, 1) that make vectors (N, 3) no longer than `most` (N,)."""
    result: Array = np.minimum(1.0, most / np.maximum(_length(v), 1e-9))[:, None]
    return result
