"""Push: go to a merry-go-round and run along its rim, hands ahead, until it turns.

Source: Horswill 2008, figure 1.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.approach import steer
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.spec.behaviour import Push

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

LEAST, DRAWN = 0.2, 0.35
"""Activation for one who is not curious, and what curiosity adds."""

LASTS, BORED = 7.0, 14.0
"""How long it is pushed, and left alone after [s]."""

CLOSE = 0.12
"""Gap to its rim in which it is pushed [m]."""

AHEAD = 0.55
"""How far ahead along the rim one runs [rad]."""


class PushRound:
    """Push something round."""

    def __init__(self, words: Push, mind: Mind) -> None:
        self.words, self.thing = words, mind.number(words.push)
        self.began, self.until = math.inf, -1.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.now < self.until:
            return 0.0
        return LEAST + DRAWN * mind.traits.curiosity + self.words.urge

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        place = mind.place(self.thing)
        gap = mind.gap(self.thing)
        if gap > 6.0 * CLOSE:
            near = float(mind.around.radius[self.thing]) + mind.slim + 2.0 * CLOSE
            return steer(mind, place, near, target=self.thing, touching=True)
        self.began = min(self.began, mind.now)
        if mind.now - self.began > LASTS:
            self.began, self.until = math.inf, mind.now + BORED
        to = mind.at - place
        angle = math.atan2(to[1], to[0]) + AHEAD
        reach = float(mind.around.radius[self.thing]) + CLOSE
        goal = place + reach * np.array([math.cos(angle), math.sin(angle)])
        return Motor(
            goal=(float(goal[0]), float(goal[1])),
            pace=mind.stroll,
            target=self.thing,
            touching=True,
            reaching=True,
        )

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.began = math.inf
