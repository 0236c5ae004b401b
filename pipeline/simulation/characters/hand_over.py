"""Hand-over: a holder holds a thing out to another person, and lets go once it is taken.

A person that is told to take a thing asks its holder for it. A holder that follows an order keeps
it, and so does a mind that declines; the person that asks in vain gives up. A holder that gives it
leaves off what it does of its own will while the other is near.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController

ASKING_RANGE = 3.0  # from which a thing is held out, in arm lengths of the holder
ASKING_TIME = 5.0  # for which one asks whose partner is busy [s]
FACING = math.radians(40.0)  # of the holder, within which it holds the thing out
LEAST_OUT, HELD_OUT = 0.35, 0.7  # ahead of the shoulder, in arm lengths
TAKER_ROOM = 0.6  # between the thing and the taker, in arm lengths of the taker
HELD_OUT_HEIGHT = 0.62  # at most, in heights of the smaller of the two


@dataclass(frozen=True, eq=False)
class HandOver:
    """A thing that goes from hand to hand.

    Attributes:
        giver: holds it.
        taker: goes to it.
        thing: its name.
    """

    giver: PersonController
    taker: PersonController
    thing: str

    def hold_out(self) -> None:
        """Turn the giver to the taker and hold the thing out, when the taker comes near."""
        giver, taker = self.giver, self.taker
        place = taker.waist()
        if not self.is_near:
            return
        if not giver.record.stepping and float(giver.record.sit_blend) == 0.0:
            giver.face_to(place)
        hands = giver.hands_holding(self.thing)
        # Both hands have it before the chest; one would drag it through the body in turning.
        if len(hands) == 2 or not giver.is_facing(FACING):
            return
        height = HELD_OUT_HEIGHT * min(float(giver.record.height), float(taker.record.height))
        room = giver.ground_distance(place) - TAKER_ROOM * taker.arm
        out = min(max(room, LEAST_OUT * giver.arm), HELD_OUT * giver.arm)
        for k in hands:
            shoulder, ahead = giver.shoulder(k), giver.direction_to(place)
            goal = shoulder + out * ahead
            goal[1] = min(float(shoulder[1]), float(giver.record.floor) + height)
            giver.put_hand(k, np.asarray(goal))

    @property
    def is_near(self) -> bool:
        """Whether the taker has come so near that the giver turns to it."""
        giver = self.giver
        return giver.ground_distance(self.taker.waist()) < ASKING_RANGE * giver.arm

    @property
    def is_taken(self) -> bool:
        """Whether the taker has it."""
        return bool(self.taker.hands_holding(self.thing))


def holder_of(
    thing: str, taker: PersonController, people: list[PersonController]
) -> PersonController | None:
    """Return another person that holds a thing, None without any."""
    held = (one for one in people if one is not taker and one.hands_holding(thing))
    return next(held, None)
