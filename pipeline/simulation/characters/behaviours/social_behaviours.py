"""Social behaviours."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from pipeline.simulation.characters.behaviours.potential_field import steer
from pipeline.simulation.characters.behaviours.registry import MotorCommand, implements
from pipeline.simulation.characters.contact_tasks import (
    BACK,
    CLOSE,
    CLOSES,
    OPEN,
    Embrace,
    Grapple,
    Hug,
    Loosen,
)
from pipeline.spec.behaviour import Attachment, Comfort, Fight

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind


RESOLVED, SOOTHED = 0.85, 0.1
"""Activation of one who has decided to go back, and the anxiety at which it lets go."""

IN_ARMS = 0.75
"""From this gap on arms do the rest [m]."""

GENTLE = 0.5
"""How fast the last steps into somebody's arms are, in strolls."""

BEYOND = 3.0
"""How far behind the other one aims who does not slow down [m]."""

PARTED = 0.12
"""So far hands have to part again that were joined [m]."""

RESTS = 0.5
"""How long arms are given to close before anybody lets go again [s]."""


@implements(Attachment)
class SafeBase:
    """Run back to a caregiver."""

    def __init__(self, words: Attachment, mind: Mind) -> None:
        self.words, self.target = words, mind.number(words.attachment)
        self.hug: Hug | None = None
        self.loosen: Loosen | None = None
        self.size = mind.surroundings.view.size(self.target)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        done = self.loosen is not None and self.loosen.time > OPEN
        wants = mind.anxiety
        if mind.doing == "attachment" and not done:
            wants = max(wants, RESOLVED)
        return wants + self.words.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        if self.hug is None and mind.gap(self.target) < IN_ARMS:
            self.hug = Hug(self.target, self.size)
        if self.hug is not None and self.hug.touched > RESTS and mind.anxiety < SOOTHED:
            self.loosen = self.loosen or Loosen(self.hug, BACK)
        if self.loosen is not None:
            return MotorCommand(task=self.loosen, pace=GENTLE * mind.stroll, target=self.target)
        if self.hug is not None:
            pace = mind.pace if mind.slapstick else GENTLE * mind.stroll
            return MotorCommand(task=self.hug, pace=pace, target=self.target, touching=True)
        place = mind.place(self.target)
        if mind.slapstick:
            to = place - mind.at
            place = place + to * (BEYOND / max(math.hypot(to[0], to[1]), 1e-6))
        near = 0.0 if mind.slapstick else 0.5 * IN_ARMS
        return steer(mind, place, near, target=self.target, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.hug = self.loosen = None


@implements(Comfort)
class HugBack:
    """Turn to one who comes to be hugged, and close the arms around it."""

    def __init__(self, words: Comfort, mind: Mind) -> None:
        self.words, self.ward = words, mind.number(words.comfort)
        self.embrace: Embrace | None = None
        self.joined = math.inf
        self.size = mind.surroundings.view.size(self.ward)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        if self.embrace is not None or self._arrives(mind):
            return RESOLVED + self.words.urge
        near = mind.away(self.ward) < 3.0 and self._comes(mind)
        return 0.5 + self.words.urge if near else 0.0

    def _arrives(self, mind: Mind) -> bool:
        """Tell whether the other one is about to put its arms around this one, or has."""
        return mind.opens_arms(self.ward) and mind.gap(self.ward) < 1.2 * IN_ARMS

    def _is_let_go(self, mind: Mind) -> bool:
        """Tell whether the other one opens its arms again, as is felt, or is gone."""
        apart = mind.hands_apart(self.ward)
        self.joined = min(self.joined, apart)
        return apart > self.joined + PARTED or not mind.opens_arms(self.ward)

    def _comes(self, mind: Mind) -> bool:
        to, v = mind.at - mind.place(self.ward), mind.velocity(self.ward)
        return bool(to @ v > 0.7 * math.hypot(to[0], to[1]) * max(math.hypot(v[0], v[1]), 0.4))

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        embrace = self.embrace
        if embrace is not None and not embrace.opens and self._is_let_go(mind):
            embrace.opens, embrace.time = True, 0.0
        if embrace is not None and embrace.opens and embrace.time > CLOSES + OPEN:
            self._forget()
        if self.embrace is None and self._arrives(mind) and mind.gap(self.ward) < CLOSE:
            self.embrace = Embrace(self.ward, self.size)
        if self.embrace is not None:
            return MotorCommand(task=self.embrace, target=self.ward, touching=True)
        if mind.gap(self.ward) < IN_ARMS:
            # No step any more: there are toes.
            return MotorCommand(target=self.ward, touching=True)
        return MotorCommand(facing=mind.heading_to(mind.place(self.ward)), target=self.ward)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self._forget()

    def _forget(self) -> None:
        self.embrace, self.joined = None, math.inf


NEAR = 3.0
"""From how near a rival provokes somebody [m]."""

ROUND, PAUSE = 2.2, 2.5
"""How long it shoves, and keeps its distance after, before the next round [s]."""

REACH = 1.1
"""From this gap on it shoves, in arms."""

STAND_OFF = 1.1
"""How far apart two who fight stand between rounds [m]."""


@implements(Fight)
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
        return heat - 0.5 * float(mind.attention.fears[self.rival]) + self.words.urge

    def motor(self, mind: Mind) -> MotorCommand:
        """See `Behaviour`."""
        place = mind.place(self.rival)
        if mind.now < self.until:
            near = STAND_OFF + mind.slim + float(mind.surroundings.radius[self.rival])
            if mind.away(self.rival) > near:
                return steer(mind, place, near, target=self.rival, pace=mind.stroll)
            return MotorCommand(facing=mind.heading_to(place), target=self.rival)
        if self.grapple is None and mind.gap(self.rival) < REACH * mind.controller.arm:
            self.grapple, self.began = Grapple(self.rival), mind.now
        if self.grapple is None:
            return steer(mind, place, target=self.rival, touching=True)
        if mind.now - self.began > ROUND:
            self.grapple = None
            self.until = mind.now + PAUSE * (0.7 + 0.6 * float(mind.rng.random()))
            return MotorCommand(facing=mind.heading_to(place), target=self.rival)
        pace = 0.5 * (mind.stroll + mind.pace)
        return MotorCommand(task=self.grapple, pace=pace, target=self.rival, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.grapple = None
