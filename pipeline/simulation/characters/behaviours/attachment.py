"""Attachment: run to who cares for somebody, and hug them until soothed; and hug back.

Source: Horswill 2008, "Hugging" and "Example application"; Bowlby 1969. Who runs into the arms
    of another at full speed hurts it there, and so turns a sentimental scene into slapstick:
    here it slows down before, unless the scene asks for that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.simulation.characters.actor import Actor
from pipeline.simulation.characters.behaviours.approach import steer
from pipeline.simulation.characters.behaviours.motor import Motor
from pipeline.simulation.characters.errands import CLOSES, Hug
from pipeline.spec.behaviour import Attachment, Comfort

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

OPEN, BACK = 0.7, 0.45
"""How long arms stay open after a hug [s], and how far one steps back from it [m]."""

CLOSE, UPRIGHT = 0.2, 0.8
"""From this gap on somebody is embraced [m], no lower than this part of an arm under the own
shoulders."""

PARTED = 0.12
"""So far hands have to part again that were joined [m]."""

RESTS = 0.5
"""How long arms are given to close before anybody lets go again [s]."""


@dataclass
class Loosen:
    """Open the arms around somebody and step back, before anything else: no arm is torn out.

    Attributes:
        hug: that ends.
        back: how far to step back [m].
        time: since the arms are open [s].
    """

    hug: Hug
    back: float = 0.0
    time: float = 0.0

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        if self.hug.loosen(actor, dt):
            if self.time == 0.0 and self.back > 0.0:
                other = actor.stage.pelvis(self.hug.owner)
                x, z = actor.me.at[0] - other[0], actor.me.at[1] - other[2]
                share = self.back / max(math.hypot(x, z), 0.1)
                actor.go(actor.me.at[0] + share * x, actor.me.at[1] + share * z)
                actor.me.faces, actor.me.facing = True, math.atan2(z, -x)
            self.time += dt
        return self.time > OPEN


@dataclass
class Embrace:
    """Put both hands on the back of one who has come, without a step and without bowing.

    Attributes:
        owner: whom.
        size: how high it stands [m].
        opens: whether the hands come off again, after.
        time: since they do, or since it began [s].
    """

    owner: int
    size: float
    opens: bool = False
    time: float = 0.0

    def go_on(self, actor: Actor, dt: float) -> bool:
        """See `Errand`."""
        me = actor.me
        if self.time == 0.0:
            actor.stop()
            me.faces = False
        actor.embrace(self.owner)
        self.time += dt
        other = actor.stage.middle(self.owner)
        ahead = np.array([other[0] - me.at[0], other[2] - me.at[1]])
        ahead /= max(math.hypot(ahead[0], ahead[1]), 1e-6)
        share = min(self.time / CLOSES, 1.0)
        wide = self.size * (0.2 - 0.14 * (1.0 - share if self.opens else share))
        standing = float(me.floor + me.hip_height + me.belly + me.chest)
        high = max(float(other[1]) - 0.03 * self.size, standing - UPRIGHT * actor.arm)
        for k in range(2):
            side = wide if k == 1 else -wide
            x = other[0] + 0.11 * self.size * ahead[0] - side * ahead[1]
            z = other[2] + 0.11 * self.size * ahead[1] + side * ahead[0]
            actor.put_hand(k, np.array([x, high, z]))
        return self.time > CLOSES


class SafeBase:
    """Run back to a caregiver."""

    def __init__(self, words: Attachment, mind: Mind) -> None:
        self.words, self.target = words, mind.number(words.attachment)
        self.hug: Hug | None = None
        self.loosen: Loosen | None = None
        self.size = mind.around.stage.size(self.target)

    def activation(self, mind: Mind) -> float:
        """See `Behaviour`."""
        done = self.loosen is not None and self.loosen.time > OPEN
        wants = mind.anxiety
        if mind.doing == "attachment" and not done:
            wants = max(wants, RESOLVED)
        return wants + self.words.urge

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        if self.hug is None and mind.gap(self.target) < IN_ARMS:
            self.hug = Hug(self.target, self.size)
        if self.hug is not None and self.hug.touched > RESTS and mind.anxiety < SOOTHED:
            self.loosen = self.loosen or Loosen(self.hug, BACK)
        if self.loosen is not None:
            return Motor(errand=self.loosen, pace=GENTLE * mind.stroll, target=self.target)
        if self.hug is not None:
            pace = mind.pace if mind.slapstick else GENTLE * mind.stroll
            return Motor(errand=self.hug, pace=pace, target=self.target, touching=True)
        place = mind.place(self.target)
        if mind.slapstick:
            to = place - mind.at
            place = place + to * (BEYOND / max(math.hypot(to[0], to[1]), 1e-6))
        near = 0.0 if mind.slapstick else 0.5 * IN_ARMS
        return steer(mind, place, near, target=self.target, touching=True)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self.hug = self.loosen = None


class HugBack:
    """Turn to one who comes to be hugged, and close the arms around it."""

    def __init__(self, words: Comfort, mind: Mind) -> None:
        self.words, self.ward = words, mind.number(words.comfort)
        self.embrace: Embrace | None = None
        self.joined = math.inf
        self.size = mind.around.stage.size(self.ward)

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

    def motor(self, mind: Mind) -> Motor:
        """See `Behaviour`."""
        embrace = self.embrace
        if embrace is not None and not embrace.opens and self._is_let_go(mind):
            embrace.opens, embrace.time = True, 0.0
        if embrace is not None and embrace.opens and embrace.time > CLOSES + OPEN:
            self._forget()
        if self.embrace is None and self._arrives(mind) and mind.gap(self.ward) < CLOSE:
            self.embrace = Embrace(self.ward, self.size)
        if self.embrace is not None:
            return Motor(errand=self.embrace, target=self.ward, touching=True)
        if mind.gap(self.ward) < IN_ARMS:
            # No step any more: there are toes.
            return Motor(target=self.ward, touching=True)
        return Motor(facing=mind.heading_to(mind.place(self.ward)), target=self.ward)

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""
        self._forget()

    def _forget(self) -> None:
        self.embrace, self.joined = None, math.inf
