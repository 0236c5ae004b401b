"""Object behaviours."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.behaviours.potential_field import EDGE, steer
from pipeline.simulation.characters.behaviours.registry import MotorCommand, implements
from pipeline.simulation.characters.contact_tasks import Grab
from pipeline.simulation.spatial import Array
from pipeline.spec.behaviour import Carry, Play, Push

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind


PLAY_ACTIVATION, PLAY_CURIOSITY = 0.25, 0.5
"""Activation of play for one who is not curious, and what curiosity adds."""

FORGOTTEN = 0.7
"""What is left of that for a ball that was not seen for long; it is looked for where it was."""

FORESEES = 0.35
"""How far ahead of a ball that rolls somebody runs [s]."""

KICK_APPROACH_DISTANCE, KICK_SPEED = 0.9, 0.8
"""How near a ball one slows down [m], and the speed it is kicked with, in strolls."""

ROLLS = 8.0
"""How far a ball rolls that was kicked: nearer to the edge of the ground it is kicked back, for
over the edge nobody runs after it [m]."""

BEHIND = 0.55
"""How far behind it one goes who has to come round it [m]."""

ALIGNED = math.cos(math.radians(40.0))
"""How well somebody has to stand behind it."""


@implements(Play)
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
        draw = PLAY_ACTIVATION + PLAY_CURIOSITY * mind.traits.curiosity
        focus = 0.1 if mind.attention.focus == self.ball else 0.0
        return (draw + focus) * min(liked / 0.8, 1.0) * known + self.words.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        at = mind.place(self.ball)
        ball = at + FORESEES * mind.velocity(self.ball)
        to = ball - mind.at
        size = max(math.hypot(to[0], to[1]), 1e-6)
        aim = self._aim(mind, ball, to / size)
        if float(aim @ to) > ALIGNED * size:
            near = size < KICK_APPROACH_DISTANCE
            pace = KICK_SPEED * mind.stroll if near else mind.pace
            place = ball + (0.8 if near else 0.0) * aim
            return steer(mind, place, pace=pace, target=self.ball, touching=True)
        place = ball - BEHIND * aim
        if size < 1.2 and float(aim @ to) < 0.0:
            # Round it, not over it.
            across = np.array([-aim[1], aim[0]])
            place = place + BEHIND * across * (-1.0 if across @ to > 0.0 else 1.0)
        return steer(mind, place, pace=mind.pace, target=self.ball, touching=True)

    def _in_reach(self, mind: Mind) -> bool:
        ball, surroundings = mind.place(self.ball), mind.surroundings
        return bool(
            (ball > surroundings.low + EDGE).all() and (ball < surroundings.high - EDGE).all()
        )

    def _aim(self, mind: Mind, ball: Array, ahead: Array) -> Array:
        """Return the direction to kick the ball in: on, or back."""
        back = self.home - ball
        far = math.hypot(back[0], back[1])
        surroundings = mind.surroundings
        inside = (ball > surroundings.low + ROLLS).all() and (
            ball < surroundings.high - ROLLS
        ).all()
        if (far > self.words.within or not inside) and far > 1e-6:
            result: Array = back / far
            return result
        return ahead

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


CARRY_ACTIVATION, CARRY_CURIOSITY = 0.4, 0.4
"""Activation for one who is not curious, and what curiosity adds."""

AT_HAND = 0.5
"""From this gap on it is taken [m]."""

GRAB_PATIENCE, DISTRACTED = 5.0, 15.0
"""How long somebody tries to take it, and does something else after that in vain [s]."""

LEFT_HAND = 0


@implements(Carry)
class CarryAlong:
    """Carry something."""

    def __init__(self, words: Carry, mind: Mind) -> None:
        self.words, self.thing = words, mind.number(words.carry)
        self.grab: Grab | None = None
        self.began = self.until = -1.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.controller.held(LEFT_HAND) >= 0 or mind.now < self.until:
            return 0.0
        return CARRY_ACTIVATION + CARRY_CURIOSITY * mind.traits.curiosity + self.words.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        if self.grab is None and mind.gap(self.thing) < AT_HAND:
            self.grab, self.began = Grab((LEFT_HAND,), self.thing), mind.now
        if self.grab is None:
            place = mind.place(self.thing)
            return steer(mind, place, 0.3, target=self.thing, touching=True)
        if mind.now - self.began > GRAB_PATIENCE:
            self.until = mind.now + DISTRACTED
        return MotorCommand(task=self.grab, pace=mind.stroll, target=self.thing, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.grab = None


PUSH_ACTIVATION, PUSH_CURIOSITY = 0.2, 0.35
"""Activation for one who is not curious, and what curiosity adds."""

PUSH_TIME, BORED = 7.0, 14.0
"""How long it is pushed, and left alone after [s]."""

PUSH_GAP = 0.12
"""Gap to its rim in which it is pushed [m]."""

RIM_LEAD_ANGLE = 0.55
"""How far ahead along the rim one runs [rad]."""


@implements(Push)
class PushRound:
    """Push something round."""

    def __init__(self, words: Push, mind: Mind) -> None:
        self.words, self.thing = words, mind.number(words.push)
        self.began, self.until = math.inf, -1.0

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if mind.now < self.until:
            return 0.0
        return PUSH_ACTIVATION + PUSH_CURIOSITY * mind.traits.curiosity + self.words.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        place = mind.place(self.thing)
        gap = mind.gap(self.thing)
        if gap > 6.0 * PUSH_GAP:
            near = float(mind.surroundings.radius[self.thing]) + mind.slim + 2.0 * PUSH_GAP
            return steer(mind, place, near, target=self.thing, touching=True)
        self.began = min(self.began, mind.now)
        if mind.now - self.began > PUSH_TIME:
            self.began, self.until = math.inf, mind.now + BORED
        to = mind.at - place
        angle = math.atan2(to[1], to[0]) + RIM_LEAD_ANGLE
        reach = float(mind.surroundings.radius[self.thing]) + PUSH_GAP
        goal = place + reach * np.array([math.cos(angle), math.sin(angle)])
        return MotorCommand(
            goal=(float(goal[0]), float(goal[1])),
            pace=mind.stroll,
            target=self.thing,
            touching=True,
            reaching=True,
        )

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.began = math.inf
