"""Play: run after a ball and kick it.

Whoever has kicked it too far from where it began comes round it, and kicks it back.

Source: Horswill 2008, "Example application".
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.approach import EDGE, steer
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Play

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

LEAST, DRAWN = 0.25, 0.5
"""Activation of play for one who is not curious, and what curiosity adds."""

FORGOTTEN = 0.7
"""What is left of that for a ball that was not seen for long; it is looked for where it was."""

FORESEES = 0.35
"""How far ahead of a ball that rolls somebody runs [s]."""

NEAR, GENTLE = 0.9, 0.8
"""How near a ball one slows down [m], and the speed it is kicked with, in strolls."""

ROLLS = 8.0
"""How far a ball rolls that was kicked: nearer to the edge of the ground it is kicked back, for
over the edge nobody runs after it [m]."""

BEHIND = 0.55
"""How far behind it one goes who has to come round it [m]."""

ALIGNED = math.cos(math.radians(40.0))
"""How well somebody has to stand behind it."""


class PlayBall:
    """Play with a ball."""

    def __init__(self, words: Play, mind: Mind) -> None:
        self.words, self.ball = words, mind.number(words.play)
        self.home = mind.place(self.ball).copy()

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        liked = max(float(mind.attention.valence[self.ball]), 0.0)
        known = max(float(mind.memory.fresh(mind.now)[self.ball]), FORGOTTEN)
        if not self._in_reach(mind):
            return 0.0
        draw = LEAST + DRAWN * mind.traits.curiosity
        focus = 0.1 if mind.attention.focus == self.ball else 0.0
        return (draw + focus) * min(liked / 0.8, 1.0) * known + self.words.urge

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        at = mind.place(self.ball)
        ball = at + FORESEES * mind.velocity(self.ball)
        to = ball - mind.at
        size = max(math.hypot(to[0], to[1]), 1e-6)
        aim = self._aim(mind, ball, to / size)
        if float(aim @ to) > ALIGNED * size:
            near = size < NEAR
            pace = GENTLE * mind.stroll if near else mind.pace
            place = ball + (0.8 if near else 0.0) * aim
            return steer(mind, place, pace=pace, target=self.ball, touching=True)
        place = ball - BEHIND * aim
        if size < 1.2 and float(aim @ to) < 0.0:
            # Round it, not over it.
            across = np.array([-aim[1], aim[0]])
            place = place + BEHIND * across * (-1.0 if across @ to > 0.0 else 1.0)
        return steer(mind, place, pace=mind.pace, target=self.ball, touching=True)

    def _in_reach(self, mind: Mind) -> bool:
        ball, around = mind.place(self.ball), mind.around
        return bool((ball > around.low + EDGE).all() and (ball < around.high - EDGE).all())

    def _aim(self, mind: Mind, ball: Array, ahead: Array) -> Array:
        """Return the direction to kick the ball in: on, or back."""
        back = self.home - ball
        far = math.hypot(back[0], back[1])
        around = mind.around
        inside = (ball > around.low + ROLLS).all() and (ball < around.high - ROLLS).all()
        if (far > self.words.within or not inside) and far > 1e-6:
            result: Array = back / far
            return result
        return ahead

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
