"""Fire streaks: where the sparks and embers of fires are at a time.

Sparks leave a fire with its gas, slow down as they cool, wander and are drawn as the streaks that
an eye sees. Embers lie at its foot and breathe. Where a spark is follows from the seed of the fire
and the time alone, so that any frame can be drawn by itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from render.plume import Plume

Floats = NDArray[np.float64]

SPARK_SEEN = 1 / 30
"""Time over which one sees a spark at once [s]."""

_SPARKS, _EMBERS, _COUNT_POWER = 90.0, 110.0, 0.7
"""Sparks and embers of a fire whose outline is one square metre, and their growth with it."""
_LIFE = 1.0, 3.2
"""Of sparks, in the time in which gas rises to the tips of the flames."""
_SLOWING = 3.0
"""Time in which a spark loses most of its speed, in the same."""
_RADIUS = 0.0016, 0.0042
"""Of sparks [m]."""
_EMBER_RADIUS = 0.02, 0.09
"""Of embers, in the radius of the fire's foot."""
_HOT, _COOL = (1.0, 0.46, 0.12), (1.0, 0.16, 0.02)
"""Colours of young and of old sparks, linear."""
_SPARK_GLOW, _EMBER_GLOW = 2.6, 1.3
"""Radiance in that of the flames."""


@dataclass(frozen=True, eq=False)
class Streaks:
    """Glowing streaks at one moment.

    Attributes:
        tail, head: (N, 3) ends in the world [m].
        radius: (N,) [m].
        radiance: (N, 3) linear.
    """

    tail: Floats
    head: Floats
    radius: Floats
    radiance: Floats


def streak_spheres(streaks: Streaks) -> Floats:
    """Return the middles in the world and the radii (N, 4) of spheres around streaks [m]."""
    half = 0.5 * np.linalg.norm(streaks.head - streaks.tail, axis=-1) + streaks.radius
    return np.column_stack([0.5 * (streaks.head + streaks.tail), half])


def fire_streaks(plume: Plume, time: float) -> Streaks:
    """Return the sparks and embers of a fire at a time since the film began [s]."""
    size = (plume.radius * plume.height) ** _COUNT_POWER
    sparks, embers = (max(math.ceil(count * size), 1) for count in (_SPARKS, _EMBERS))
    flying, lying = _sparks(plume, time, sparks), _embers(plume, time, embers)
    return Streaks(
        np.concatenate([flying.tail, lying.tail]),
        np.concatenate([flying.head, lying.head]),
        np.concatenate([flying.radius, lying.radius]),
        np.concatenate([flying.radiance, lying.radiance]),
    )


def _sparks(plume: Plume, time: float, count: int) -> Streaks:
    rise_time = plume.height / max(plume.speed, 0.05)
    number = np.arange(count)
    own = _draws(number, plume.seed, 2)
    life = rise_time * (_LIFE[0] + (_LIFE[1] - _LIFE[0]) * own[:, 0])
    turn = np.floor(time / life + own[:, 1])
    age = (time / life + own[:, 1] - turn) * life
    draws = _draws(number + 4099 * turn.astype(np.int64), plume.seed + 1, 8)
    head, tail = (
        _spark_places(plume, draws, np.maximum(age - ago, 0.0)) for ago in (0.0, SPARK_SEEN)
    )
    spent = age / life
    # They flare up as they leave the flames, and are out before they fall.
    bright = np.clip(8.0 * spent, 0.0, 1.0) * (1.0 - spent) ** 1.3 * (0.4 + 0.9 * draws[:, 6])
    tone = np.array(_HOT) + spent[:, None] * (np.array(_COOL) - np.array(_HOT))
    radius = _RADIUS[0] + (_RADIUS[1] - _RADIUS[0]) * draws[:, 7] ** 2
    return Streaks(tail, head, radius, _SPARK_GLOW * plume.glow * bright[:, None] * tone)


def _spark_places(plume: Plume, draws: Floats, age: Floats) -> Floats:
    """Return places (N, 3) of sparks at an age [m]."""
    slowing = _SLOWING * plume.height / max(plume.speed, 0.05)
    way = slowing * (1.0 - np.exp(-age / slowing))
    turn, out = 2.0 * np.pi * draws[:, 0], plume.radius * np.sqrt(draws[:, 1])
    # Those from the rim are thrown aside, those from the middle go up with the gas.
    aside = 0.22 * plume.speed * draws[:, 2] * way
    sway = 0.11 * plume.height * np.minimum(age / slowing, 1.0)
    beat = 2.0 * np.pi * (1.2 + 1.8 * draws[:, 4]) * age
    x = (0.6 * out + aside) * np.cos(turn) + sway * np.sin(beat + 6.0 * draws[:, 5])
    z = (0.6 * out + aside) * np.sin(turn) + sway * np.sin(0.8 * beat + 6.0 * draws[:, 3])
    y = 0.12 * plume.height + plume.speed * (0.45 + 0.55 * draws[:, 3]) * way
    drift = age - 0.5 * way
    place = np.stack([x + plume.wind[0] * drift, y, z + plume.wind[1] * drift], axis=-1)
    return np.asarray(place + np.array(plume.p_WP))


def _embers(plume: Plume, time: float, count: int) -> Streaks:
    draws = _draws(np.arange(count), plume.seed + 2, 6)
    turn, out = 2.0 * np.pi * draws[:, 0], 0.95 * plume.radius * np.sqrt(draws[:, 1])
    up = plume.radius * (0.4 * draws[:, 2] - 0.28)
    place = np.stack([out * np.cos(turn), up, out * np.sin(turn)], axis=-1) + np.array(plume.p_WP)
    radius = plume.radius * (
        _EMBER_RADIUS[0] + (_EMBER_RADIUS[1] - _EMBER_RADIUS[0]) * draws[:, 3] ** 3
    )
    breath = 0.65 + 0.35 * np.sin(2.0 * np.pi * (0.5 + draws[:, 4]) * time + 6.3 * draws[:, 5])
    # Those at the rim have the least heat.
    bright = breath * (1.0 - 0.7 * out / plume.radius)
    tone = 0.4 * np.array(_HOT) + 0.6 * np.array(_COOL)
    return Streaks(place, place, radius, _EMBER_GLOW * plume.glow * bright[:, None] * tone)


def _draws(number: NDArray[np.int64], seed: int, count: int) -> Floats:
    """Return random numbers (N, count) of each number and seed, 0 to 1."""
    n = number.astype(np.uint64)[:, None] * np.uint64(0x9E3779B97F4A7C15)
    k = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F)
    h = n ^ k ^ np.uint64(seed * 0x165667B19E3779F9 & 0xFFFF_FFFF_FFFF_FFFF)
    # Source: the finalizer of splitmix64, G. Steele et al., 2014.
    h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    h = h ^ (h >> np.uint64(31))
    return np.asarray((h >> np.uint64(11)).astype(float) / float(1 << 53))
