"""Leisure: stroll about, and sit down where nothing is more pressing, and get up again.

Source: Horswill 2008, "High-level Control" (sit down, stand up).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.approach import has_room, steer
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.spec.behaviour import SitDown, Wander

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

STANDS = (0.8, 3.0)
"""How long somebody stands between two strolls [s]."""

THERE = 0.4
"""How near a place is near enough [m]."""

CHOICES = 6
"""How many places it thinks of at most, until nothing stands where it would go to."""

GIVES_UP = 12.0
"""After so long it goes elsewhere [s]."""


class Stroll:
    """Go from place to place."""

    def __init__(self, words: Wander, mind: Mind) -> None:
        self.words = words
        self.home = mind.around.places[mind.me, [0, 2]].copy()
        self.goal = self.home.copy()
        self.stands, self.until = 0.0, 0.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        return 0.2 + 0.2 * mind.traits.curiosity + self.words.urge

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        to = self.goal - mind.at
        if math.hypot(to[0], to[1]) < THERE + 0.1 or mind.now > self.until:
            if self.stands == 0.0:
                low, high = STANDS
                self.stands = mind.now + low + (high - low) * float(mind.rng.random())
            if mind.now < self.stands:
                return Motor()
            self._choose(mind)
        return steer(mind, self.goal, THERE, pace=mind.stroll + 0.5 * (mind.pace - mind.stroll))

    def _choose(self, mind: Mind) -> None:
        around = mind.around
        for _ in range(CHOICES):
            angle = 2.0 * math.pi * float(mind.rng.random())
            reach = self.words.wander * math.sqrt(float(mind.rng.random()))
            self.goal = self.home + reach * np.array([math.cos(angle), math.sin(angle)])
            self.goal = np.clip(self.goal, around.low + 1.0, around.high - 1.0)
            if has_room(mind, self.goal):
                break
        self.stands, self.until = 0.0, mind.now + GIVES_UP

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.stands, self.until = 0.0, 0.0


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

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        return Motor(sits=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
