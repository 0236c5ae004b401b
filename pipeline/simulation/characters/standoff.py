"""Standoff: room between a person and a low thing, so that it can bow and both hands get there.

A thing between or at the feet is out of reach: bent knees are between it and the hands. As one
does who finds a ball there, the person rises, steps off without turning, for turning feet would
kick it away, and only then faces it and bows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import SWINGING
from pipeline.simulation.spatial import Array

BOWED_RANGE = 0.88  # of hands before the middle of a person that bows, in arm lengths
LEAST_RANGE = 0.76  # nearer than which knees are in the way, in arm lengths
CLEARED_RANGE = 0.84  # at which a step off is far enough, in arm lengths
FARTHER_AGAIN = 0.08  # at every further try, in arm lengths
FARTHER = 1.0  # by which the goal of a step off is beyond, in arm lengths: nobody crawls to it
RISEN_BOW = 0.8  # tangent of the trunk's lean from which feet step
FRONT = math.radians(50.0)  # angle to things that a person keeps facing as it steps off
BOWING_TOLERANCE = math.radians(35.0)  # of the turn to a low thing, before a person bows
UNDERFOOT = 0.15  # distance of things right between the feet, in arm lengths
STUCK_TIME, STUCK_TRIES = 1.5, 2  # of hands that come no nearer, which steps may mend [s]
MOST_TRIES = 4  # after which stepping off is in vain
LONGEST_STEP = 3.0  # time after which a person that gets nowhere bows where it is [s]


@dataclass
class Standoff:
    """A person's distance to the low thing that it takes.

    Attributes:
        tries: how often it has stepped off.
        time: since it steps off [s].
        is_stepping: whether it steps off.
    """

    tries: int = 0
    time: float = 0.0
    is_stepping: bool = False

    def is_kept(
        self,
        controller: PersonController,
        spot: Array,
        soon: Array,
        dt: float,
        stuck: float = 0.0,
    ) -> bool:
        """Step off from a thing that is too near; tell whether there is room to bow.

        Args:
            controller: of the person.
            spot: (3,) between the hands that will hold the thing [m].
            soon: (3,) where that will be once the person is down [m].
            dt: the step [s].
            stuck: time for which hands come no nearer although there should be room [s].
        """
        person, distance = controller.record, controller.ground_distance(soon)
        if not self.is_stepping:
            if self.tries >= MOST_TRIES:
                return True
            is_stuck = stuck > STUCK_TIME and self.tries < STUCK_TRIES
            if not is_stuck and distance >= LEAST_RANGE * controller.arm:
                return True
            self.is_stepping, self.time, self.tries = True, 0.0, self.tries + 1
        self.time += dt
        for k in range(2):
            if not controller.is_holding(k):
                person.arm_mode[k] = SWINGING
        enough = CLEARED_RANGE + FARTHER_AGAIN * (self.tries - 1)
        if self.time > LONGEST_STEP:
            controller.stop()
            self.is_stepping = False
        elif person.bow > RISEN_BOW:
            person.has_facing, person.facing = True, person.heading
        elif distance > enough * controller.arm:
            controller.stop()
            self.is_stepping = bool(person.stepping)
        else:
            self._step(controller, spot, distance, enough)
        return not self.is_stepping

    def _step(
        self, controller: PersonController, spot: Array, distance: float, enough: float
    ) -> None:
        """Go away from the spot; only a thing in front is faced meanwhile."""
        person, ahead = controller.record, controller.ahead
        is_under = controller.ground_distance(spot) < UNDERFOOT * controller.arm
        to_spot = ahead if is_under else controller.direction_to(spot)
        back = (enough + FARTHER) * controller.arm - distance
        heading = float(person.heading)
        if np.dot(to_spot, ahead) > math.cos(FRONT):
            heading = math.atan2(-to_spot[2], to_spot[0])
        controller.go(person.at[0] - back * to_spot[0], person.at[1] - back * to_spot[2])
        person.has_facing, person.facing = True, heading
