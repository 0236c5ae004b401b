"""Keeping away: run from a pursuer; stand off from strangers; stand still for fear.

Source: Horswill 2008, "High-level Control" (freeze); Reynolds 1999 (flee).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.approach import EDGE, steer
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Flee, Freeze, Shyness

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

SAFE = 7.0
"""Farther away nobody frightens [m]."""

FLIGHT = 4.0
"""How far ahead the place is that somebody runs to [m]."""

WALLS = 3.5
"""How near the edge of the terrain somebody turns who runs [m]."""

GAZED = 1.5
"""How much sooner one keeps away from whom it sees coming."""


def refuge(mind: Mind, push: Array, far: float) -> Array:
    """Return the place (2,) in a direction, turned away from the edge of the terrain."""
    around = mind.around
    low, high = mind.at - around.low - EDGE, around.high - EDGE - mind.at
    # As walls that push the more the nearer they are.
    wall = 1.0 / np.maximum(low, 0.3) - 1.0 / np.maximum(high, 0.3)
    walls = np.where(np.minimum(low, high) < WALLS, 1.6 * wall, 0.0)
    push = push / max(math.hypot(push[0], push[1]), 1e-6)
    into = float(push @ walls) < 0.0
    if into and bool((np.minimum(low, high) < 0.5 * WALLS).any()):
        # Along the wall, not to and fro in front of it.
        push = push + 0.8 * np.array([-push[1], push[0]])
    way = push + walls
    result: Array = mind.at + far * way / max(math.hypot(way[0], way[1]), 1e-6)
    return result


class RunAway:
    """Flee from somebody."""

    def __init__(self, words: Flee, mind: Mind) -> None:
        self.words, self.threat = words, mind.number(words.flee)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        near = 1.0 - mind.away(self.threat) / SAFE
        fear = max(near, 0.0) * (0.7 + 0.6 * mind.traits.anxiety)
        mind.attention.fears[self.threat] = max(mind.attention.fears[self.threat], 0.8 * fear)
        return min(1.3 * fear, 1.0) + self.words.urge if fear > 0.0 else 0.0

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        threat = mind.place(self.threat) + 0.4 * mind.velocity(self.threat)
        near = max(1.0 - mind.away(self.threat) / SAFE, 0.0)
        pace = mind.stroll + (mind.pace - mind.stroll) * min(2.0 * near, 1.0)
        return steer(mind, refuge(mind, mind.at - threat, FLIGHT), pace=pace)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


class KeepOff:
    """Keep away from everybody."""

    def __init__(self, words: Shyness, mind: Mind) -> None:
        self.words = words
        self.others = mind.around.people.copy()
        self.others[mind.me] = False

    def _close(self, mind: Mind) -> Array:
        """Return (C,) how much too near each of the others is, from 0 to 1."""
        reach = mind.memory.away / max(self.words.keep_off, 1e-6)
        too: Array = np.where(self.others, np.clip(1.0 - reach, 0.0, 1.0), 0.0)
        return too

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        too = self._close(mind)
        mind.attention.fears[:] = np.maximum(mind.attention.fears, 0.5 * too)
        most = float(too.max())
        # Who has begun goes on until there is some room.
        least = 0.02 if mind.doing == "keep_off" else 0.25
        return 0.35 + GAZED * mind.traits.anxiety * most + self.words.urge if most > least else 0.0

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        too = self._close(mind)
        off = mind.at - mind.memory.places[:, [0, 2]]
        away = np.maximum(mind.memory.away, 0.1)[:, None]
        push = (too[:, None] * off / away).sum(axis=0)
        nearest = int(too.argmax())
        if math.hypot(push[0], push[1]) < 0.05:
            return Motor(facing=mind.heading_to(mind.place(nearest)), target=nearest)
        place = refuge(mind, push, 1.2)
        return steer(mind, place, pace=mind.stroll)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


class HoldStill:
    """Freeze in the face of somebody."""

    def __init__(self, words: Freeze, mind: Mind) -> None:
        self.words, self.threat = words, mind.number(words.freeze)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if not mind.memory.in_view[self.threat]:
            return 0.0
        near = max(1.0 - mind.away(self.threat) / (0.6 * SAFE), 0.0)
        if mind.doing != "freeze" and near < 0.2:
            return 0.0
        return near * (0.6 + 0.8 * mind.traits.anxiety) + self.words.urge

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        return Motor(frozen=True, target=self.threat)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
