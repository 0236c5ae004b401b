"""Fight: go for somebody and shove, step back, and go for it again while angry.

Source: Horswill 2008, "Grappling" and "Example application".
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.simulation.characters.behaviours.approach import steer
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.simulation.characters.errands import Grapple
from pipeline.spec.behaviour import Fight

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

NEAR = 3.0
"""From how near a rival provokes somebody [m]."""

ROUND, PAUSE = 2.2, 2.5
"""How long it shoves, and keeps its distance after, before the next round [s]."""

REACH = 1.1
"""From this gap on it shoves, in arms."""

STAND_OFF = 1.1
"""How far apart two who fight stand between rounds [m]."""


class FightIt:
    """Fight with somebody."""

    def __init__(self, words: Fight, mind: Mind) -> None:
        self.words, self.rival = words, mind.number(words.fight)
        self.grapple: Grapple | None = None
        self.began, self.until = 0.0, 0.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        near = max(1.0 - mind.away(self.rival) / NEAR, 0.0)
        heat = mind.traits.aggression * (0.35 + 0.65 * near) + mind.anger
        return heat - 0.5 * mind.attention.fears[self.rival] + self.words.urge

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        place = mind.place(self.rival)
        if mind.now < self.until:
            near = STAND_OFF + mind.slim + float(mind.around.radius[self.rival])
            if mind.away(self.rival) > near:
                return steer(mind, place, near, target=self.rival, pace=mind.stroll)
            return Motor(facing=mind.heading_to(place), target=self.rival)
        if self.grapple is None and mind.gap(self.rival) < REACH * mind.actor.arm:
            self.grapple, self.began = Grapple(self.rival), mind.now
        if self.grapple is None:
            return steer(mind, place, target=self.rival, touching=True)
        if mind.now - self.began > ROUND:
            self.grapple = None
            self.until = mind.now + PAUSE * (0.7 + 0.6 * float(mind.rng.random()))
            return Motor(facing=mind.heading_to(place), target=self.rival)
        pace = 0.5 * (mind.stroll + mind.pace)
        return Motor(errand=self.grapple, pace=pace, target=self.rival, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.grapple = None
