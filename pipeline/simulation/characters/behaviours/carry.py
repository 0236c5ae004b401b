"""Carry: fetch something, and have it in hand while doing other things.

Source: Horswill 2008, figure 1 and "Limb control" (grab).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.simulation.characters.behaviours.approach import steer
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.simulation.characters.errands import Grab
from pipeline.spec.behaviour import Carry

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

LEAST, DRAWN = 0.4, 0.4
"""Activation for one who is not curious, and what curiosity adds."""

AT_HAND = 0.5
"""From this gap on it is taken [m]."""

PATIENCE, DISTRACTED = 5.0, 15.0
"""How long somebody tries to take it, and does something else after that in vain [s]."""

LEFT = 0


class CarryAlong:
    """Carry something."""

    def __init__(self, words: Carry, mind: Mind) -> None:
        self.words, self.thing = words, mind.number(words.carry)
        self.grab: Grab | None = None
        self.began = self.until = -1.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.actor.held(LEFT) >= 0 or mind.now < self.until:
            return 0.0
        return LEAST + DRAWN * mind.traits.curiosity + self.words.urge

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        if self.grab is None and mind.gap(self.thing) < AT_HAND:
            self.grab, self.began = Grab((LEFT,), self.thing), mind.now
        if self.grab is None:
            place = mind.place(self.thing)
            return steer(mind, place, 0.3, target=self.thing, touching=True)
        if mind.now - self.began > PATIENCE:
            self.until = mind.now + DISTRACTED
        return Motor(errand=self.grab, pace=mind.stroll, target=self.thing, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.grab = None
