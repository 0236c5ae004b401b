"""Potential field."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.registry import MotorCommand
from pipeline.simulation.characters.body_arrays import IntArray
from pipeline.simulation.characters.visibility_route import WITHIN, Route, are_free
from pipeline.simulation.spatial import Array

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind


REPELS = 0.26
"""The constant c: at so wide a gap an obstacle pushes as hard as the target pulls [m]."""

LEAST = 0.16
"""The gap below which it pushes no harder, d_min [m]."""

CUT_OFF = 2.6
"""Obstacles with a wider gap are ignored [m]."""

EDGE = 0.9
"""How near the edge of the terrain nobody goes [m]."""

STUCK, TRIES = 1.6, 3.5
"""How long somebody gets no farther before it tries another way, and for how long [s]."""


def walk_vector(to: Array, away: Array, gaps: Array, senses: Array, pace: float) -> Array:
    """Return the velocity (2,) to walk with, along x and z [m/s].

    Args:
        to: (2,) the way to the target, stop distance taken off [m].
        away: (n, 2) unit vectors from obstacles to who walks.
        gaps: (n,) between them [m].
        senses: (n,) way round each, 1 or -1: the sign of the curl.
        pace: of the walk [m/s].
    """
    size = math.hypot(to[0], to[1])
    if size < 1e-9:
        return np.zeros(2)
    pull = to * (pace / max(size, 1e-9) * min(size / 0.3, 1.0))
    # Only what is in the way: behind somebody nothing pushes.
    ahead = np.clip(0.35 - (away @ to) / size, 0.0, 1.0)
    push = pace * REPELS * ahead / np.maximum(gaps, LEAST)
    curl = np.stack([-away[:, 1], away[:, 0]], axis=1)
    result: Array = pull + (push[:, None] * (away + senses[:, None] * curl)).sum(axis=0)
    return result


@dataclass
class DetourState:
    """Somebody's way around things: which way round each, and whether it gets on."""

    senses: dict[int, float] = field(default_factory=dict)
    nearest: float = math.inf
    since: float = 0.0
    forced: float = 0.0
    until: float = -1.0
    route: Route = field(default_factory=Route)

    def note(self, left: float, now: float) -> None:
        """Note how far it still is [m], and try the other way round if that gets no less."""
        if left < self.nearest - 0.1 or left > self.nearest + 3.0:
            self.nearest, self.since = left, now
        if now - self.since > STUCK and now > self.until:
            self.forced = -self.forced if self.forced else 1.0
            self.until, self.since, self.nearest = now + TRIES, now + TRIES, math.inf

    def sense(self, which: int, side: float, now: float) -> float:
        """Return the way round an obstacle on one side of the way to the target."""
        if now < self.until:
            return self.forced
        return self.senses.setdefault(which, 1.0 if side >= 0.0 else -1.0)


def steer(
    mind: Mind,
    place: Array,
    near: float = 0.0,
    pace: float | None = None,
    target: int = -1,
    touching: bool = False,
) -> MotorCommand:
    """Return the motor vector of one who goes to a place.

    Args:
        mind: whose.
        place: x and z [m].
        near: how far from it to stop [m].
        pace: of the walk, the usual one if left out [m/s].
        target: number of who is there.
        touching: whether it is gone up to, and nobody steps aside for it.
    """
    pace = mind.pace if pace is None else pace
    me, surroundings = mind.at, mind.surroundings
    place = np.clip(place, surroundings.low + EDGE, surroundings.high - EDGE)
    to = place - me
    size = math.hypot(to[0], to[1])
    left = max(size - near, 0.0)
    if left < 0.1:
        return MotorCommand(facing=mind.heading_to(place), target=target)
    standing = _in_the_way(mind, target)
    within = np.stack([surroundings.low + 0.5 * EDGE, surroundings.high - 0.5 * EDGE])
    first, length = mind.way.route.next(me, place, standing.middles, standing.reaches, within)
    to = first - me
    size = max(math.hypot(to[0], to[1]), 1e-9)
    left = max(length - near, 0.0)
    away, gaps, senses = _obstacles(mind, standing, to, size)
    mind.way.note(left, mind.now)
    w = walk_vector(to * (left / size), away, gaps, senses, pace)
    w = _inside(w, me, surroundings.low + 0.5 * EDGE, surroundings.high - 0.5 * EDGE)
    speed = math.hypot(w[0], w[1])
    if speed < 1e-6:
        return MotorCommand(facing=mind.heading_to(place), target=target)
    goal = me + w * (max(left, 0.35) if len(gaps) else left) / speed
    return MotorCommand(
        goal=(float(goal[0]), float(goal[1])),
        pace=min(max(speed, 0.35 * pace), pace),
        target=target,
        touching=touching,
    )


@dataclass(frozen=True, slots=True)
class _Standing:
    """What one goes round, as circles.

    Attributes:
        keys: (n,) numbers: of characters, and after these of barriers.
        middles: (n, 2) [m].
        reaches: (n,) how near to them the middle of who goes can be [m].
        away: (n,) how far off they are [m].
        wholes: (n,) circles of one thing have one number.
    """

    keys: IntArray
    middles: Array
    reaches: Array
    away: Array
    wholes: IntArray


def _in_the_way(mind: Mind, target: int) -> _Standing:
    """Return all that one who goes to a target goes round."""
    surroundings, memory = mind.surroundings, mind.memory
    # People are stepped aside for by those who walk, before they come near.
    walking = surroundings.people & mind.acting
    mask = ~walking & (memory.away > 1e-6) & mind.solid
    mask[mind.me] = False
    if target >= 0:
        mask[target] = False
    keys = np.flatnonzero(mask)
    middles, away = memory.places[keys][:, [0, 2]], memory.away[keys]
    reaches = surroundings.radius[keys] + mind.slim
    barriers = surroundings.view.obstacle_circles
    if not barriers.look():
        return _Standing(keys, middles, reaches, away, keys)
    off = barriers.middles - mind.at
    others = np.sqrt((off * off).sum(axis=1))
    return _Standing(
        np.concatenate([keys, len(mask) + barriers.keys]),
        np.concatenate([middles, barriers.middles]),
        np.concatenate([reaches, barriers.radii + mind.slim]),
        np.concatenate([away, np.maximum(others, 1e-6)]),
        np.concatenate([keys, len(mask) + barriers.wholes]),
    )


def has_room(mind: Mind, place: Array) -> bool:
    """Tell whether there is room for somebody at a place (2,), as far as it remembers."""
    standing = _in_the_way(mind, -1)
    off = standing.middles - place
    return bool(((off * off).sum(axis=1) > standing.reaches**2).all())


def leads_free(mind: Mind, place: Array) -> bool:
    """Tell whether nothing stands on the straight way to a place (2,), nor there.

    Whoever is in the circle around something may go out of that, and not farther in.
    """
    standing = _in_the_way(mind, -1)
    reaches = np.minimum(standing.reaches, WITHIN * standing.away)
    return bool(are_free(mind.at, place[None], standing.middles, reaches)[0])


def _obstacles(
    mind: Mind, standing: _Standing, to: Array, size: float
) -> tuple[Array, Array, Array]:
    """Return unit vectors (n, 2) from obstacles that are near, gaps [m] and ways round."""
    gaps = standing.away - standing.reaches
    near = np.flatnonzero((gaps < CUT_OFF) & (gaps + mind.slim < size + 0.1))
    if len(np.unique(standing.wholes[near])) < len(near):
        # What is long pushes once, from where it is nearest.
        order = near[np.argsort(gaps[near], kind="stable")]
        near = np.sort(order[np.unique(standing.wholes[order], return_index=True)[1]])
    keys, gaps = standing.keys[near], gaps[near]
    offset = standing.middles[near] - mind.at
    away = -offset / standing.away[near][:, None]
    side = to[0] * offset[:, 1] - to[1] * offset[:, 0]
    senses = [mind.way.sense(int(k), float(s), mind.now) for k, s in zip(keys, side, strict=True)]
    for gone in set(mind.way.senses) - {int(k) for k in keys}:
        del mind.way.senses[gone]
    return away, gaps, np.array(senses)


def _inside(w: Array, me: Array, low: Array, high: Array) -> Array:
    """Take out of a velocity what leads off the terrain."""
    w = np.where((me < low) & (w < 0.0), 0.2, w)
    result: Array = np.where((me > high) & (w > 0.0), -0.2, w)
    return result
