"""Movement behaviours."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.potential_field import (
    EDGE,
    has_room,
    leads_free,
    steer,
)
from pipeline.simulation.characters.behaviours.registry import MotorCommand, implements
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Approach, Flee, Freeze, Shyness, SitDown, Urge, Wander

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind


@implements(Approach)
class GoTo:
    """Go to somebody or something."""

    def __init__(self, words: Approach, mind: Mind) -> None:
        self.words = words
        self.target = mind.number(words.approach)
        self.arrived = False

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        return 0.45 + self.words.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        words, place = self.words, mind.place(self.target)
        near = mind.surroundings.radius[self.target] + mind.slim + words.distance
        if words.from_deg is not None:
            angle = math.radians(words.from_deg)
            place = place + near * np.array([math.cos(angle), -math.sin(angle)])
            near = 0.0
        return steer(mind, place, near, target=self.target, touching=words.distance < 0.3)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


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
    surroundings = mind.surroundings
    low, high = mind.at - surroundings.low - EDGE, surroundings.high - EDGE - mind.at
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


@implements(Flee)
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

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        threat = mind.place(self.threat) + 0.4 * mind.velocity(self.threat)
        near = max(1.0 - mind.away(self.threat) / SAFE, 0.0)
        pace = mind.stroll + (mind.pace - mind.stroll) * min(2.0 * near, 1.0)
        return steer(mind, refuge(mind, mind.at - threat, FLIGHT), pace=pace)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


@implements(Shyness)
class KeepOff:
    """Keep away from everybody."""

    def __init__(self, words: Shyness, mind: Mind) -> None:
        self.words = words
        self.others = mind.surroundings.people.copy()
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

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        too = self._close(mind)
        off = mind.at - mind.memory.places[:, [0, 2]]
        away = np.maximum(mind.memory.away, 0.1)[:, None]
        push = (too[:, None] * off / away).sum(axis=0)
        nearest = int(too.argmax())
        if math.hypot(push[0], push[1]) < 0.05:
            return MotorCommand(facing=mind.heading_to(mind.place(nearest)), target=nearest)
        place = refuge(mind, push, 1.2)
        return steer(mind, place, pace=mind.stroll)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


@implements(Freeze)
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

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        return MotorCommand(frozen=True, target=self.threat)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


WITHDRAWAL_TIME = 0.8
"""How long it goes on [s]."""

STEPS_BACK = 1.4
"""How far away the place is that it goes to [m]."""

ASIDE = tuple(math.radians(k) for k in (0.0, 35.0, -35.0, 70.0, -70.0))
"""By how much it steps back aside from straight away, where something stands there."""

FAST = 0.55
"""How fast, as a part of √(g l)."""

URGENT = 2.0
"""Its activation: nothing else comes before it."""


@implements(Urge)
class Withdraw:
    """Step back from pain; decided when it begins, and not changed after."""

    def __init__(self, config: Urge, mind: Mind) -> None:
        self.struck = -math.inf
        self.told = MotorCommand()

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        return URGENT if mind.now - mind.struck[0] < WITHDRAWAL_TIME else 0.0

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        since, by = mind.struck
        if since != self.struck:
            self.struck, self.told = since, self._away(mind, by)
        return self.told

    def _away(self, mind: Mind, by: int) -> MotorCommand:
        heading = float(mind.controller.record.heading)
        to = mind.place(by) - mind.at if by >= 0 else np.array([0.0, 0.0])
        size = math.hypot(to[0], to[1])
        if size < 1e-6:
            to, size = np.array([math.cos(heading), -math.sin(heading)]), 1.0
        away = math.atan2(-to[1], -to[0])
        goals = [self._place(mind, away + turn) for turn in ASIDE]
        free = [goal for goal in goals if leads_free(mind, goal)]
        goal = free[0] if free else goals[0]
        return MotorCommand(
            goal=(float(goal[0]), float(goal[1])),
            pace=FAST * mind.root,
            facing=math.atan2(-to[1], to[0]),
            target=by,
        )

    @staticmethod
    def _place(mind: Mind, way: float) -> Array:
        surroundings = mind.surroundings
        goal = mind.at + STEPS_BACK * np.array([math.cos(way), math.sin(way)])
        result: Array = np.clip(goal, surroundings.low + 0.5, surroundings.high - 0.5)
        return result

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


STANDS = (0.8, 3.0)
"""How long somebody stands between two strolls [s]."""

THERE = 0.4
"""How near a place is near enough [m]."""

CHOICES = 6
"""How many places it thinks of at most, until nothing stands where it would go to."""

GIVES_UP = 12.0
"""After so long it goes elsewhere [s]."""


@implements(Wander)
class Stroll:
    """Go from place to place."""

    def __init__(self, words: Wander, mind: Mind) -> None:
        self.words = words
        self.home = mind.surroundings.places[mind.me, [0, 2]].copy()
        self.goal = self.home.copy()
        self.stands, self.until = 0.0, 0.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        return 0.2 + 0.2 * mind.traits.curiosity + self.words.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        to = self.goal - mind.at
        if math.hypot(to[0], to[1]) < THERE + 0.1 or mind.now > self.until:
            if self.stands == 0.0:
                low, high = STANDS
                self.stands = mind.now + low + (high - low) * float(mind.rng.random())
            if mind.now < self.stands:
                return MotorCommand()
            self._choose(mind)
        return steer(mind, self.goal, THERE, pace=mind.stroll + 0.5 * (mind.pace - mind.stroll))

    def _choose(self, mind: Mind) -> None:
        surroundings = mind.surroundings
        for _ in range(CHOICES):
            angle = 2.0 * math.pi * float(mind.rng.random())
            reach = self.words.wander * math.sqrt(float(mind.rng.random()))
            self.goal = self.home + reach * np.array([math.cos(angle), math.sin(angle)])
            self.goal = np.clip(self.goal, surroundings.low + 1.0, surroundings.high - 1.0)
            if has_room(mind, self.goal):
                break
        self.stands, self.until = 0.0, mind.now + GIVES_UP

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.stands, self.until = 0.0, 0.0


@implements(SitDown)
class SitAWhile:
    """Sit down; another behaviour that is chosen gets it up."""

    def __init__(self, words: SitDown, mind: Mind) -> None:
        self.words = words
        self.idle = mind.now

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.doing not in ("", "rest"):
            self.idle = mind.now
        return 0.12 + self.words.urge if mind.now - self.idle >= self.words.rest else 0.0

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        return MotorCommand(sits=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
