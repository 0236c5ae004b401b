"""Attachment: run to who cares for somebody, and hug them until soothed; and hug back.

Source: Horswill 2008, "Hugging" and "Example application"; Bowlby 1969. Who runs into the arms
    of another at full speed hurts it there, and so turns a sentimental scene into slapstick:
    here it slows down before, unless the scene asks for that.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from pipeline.simulation.characters.behaviours.approach import steer
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.simulation.characters.errands import Hug
from pipeline.spec.behaviour import Attachment, Comfort

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

RESOLVED, SOOTHED = 0.85, 0.1
"""Activation of one who has decided to go back, and the anxiety at which it lets go."""

IN_ARMS = 0.75
"""From this gap on arms do the rest [m]."""

BEYOND = 3.0
"""How far behind the other one aims who does not slow down [m]."""

RESTS = 0.5
"""How long arms are given to close before anybody lets go again [s]."""


class SafeBase:
    """Run back to a caregiver."""

    def __init__(self, words: Attachment, mind: Mind) -> None:
        self.words, self.target = words, mind.number(words.attachment)
        self.hug: Hug | None = None
        self.size = mind.around.stage.size(self.target)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        wants = mind.anxiety
        if mind.doing == "attachment":
            held = self.hug is not None and self.hug.touched > RESTS
            if not held or mind.anxiety > SOOTHED:
                wants = max(wants, RESOLVED)
        return wants + self.words.urge

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        if self.hug is None and mind.gap(self.target) < IN_ARMS:
            self.hug = Hug(self.target, self.size)
        if self.hug is not None:
            return Motor(errand=self.hug, pace=mind.pace, target=self.target, touching=True)
        place = mind.place(self.target)
        if mind.slapstick:
            to = place - mind.at
            place = place + to * (BEYOND / max(math.hypot(to[0], to[1]), 1e-6))
        near = 0.0 if mind.slapstick else 0.5 * IN_ARMS
        return steer(mind, place, near, target=self.target, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.hug = None


class HugBack:
    """Turn to one who comes to be hugged, and close the arms around it."""

    def __init__(self, words: Comfort, mind: Mind) -> None:
        self.words, self.ward = words, mind.number(words.comfort)
        self.hug: Hug | None = None
        self.size = mind.around.stage.size(self.ward)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        coming = mind.opens_arms(self.ward) and mind.gap(self.ward) < 1.2 * IN_ARMS
        if coming:
            return 0.8 + self.words.urge
        near = mind.away(self.ward) < 3.0 and self._comes(mind)
        return 0.5 + self.words.urge if near else 0.0

    def _comes(self, mind: Mind) -> bool:
        to, v = mind.at - mind.place(self.ward), mind.velocity(self.ward)
        return bool(to @ v > 0.7 * math.hypot(to[0], to[1]) * max(math.hypot(v[0], v[1]), 0.4))

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        if mind.gap(self.ward) < 0.35 and mind.opens_arms(self.ward):
            self.hug = self.hug or Hug(self.ward, self.size)
            return Motor(errand=self.hug, target=self.ward, touching=True)
        self.hug = None
        return Motor(facing=mind.heading_to(mind.place(self.ward)), target=self.ward)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.hug = None
