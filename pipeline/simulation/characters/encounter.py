"""Encounter: two people who come to each other, and the pace of the last steps between them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.spatial import Array

COMING_TIME = 0.12  # over which the speed of a partner is averaged [s]
CLOSING_RATE = 1.2  # speed of the last steps, by the distance from touching [1/s]
SLOWEST_FROUDE = 0.07  # of these steps, in √(g l); the knee of a faster one strikes the partner
LEAST_APPROACH = 0.3  # of both together, below which one walks the whole way [m/s]


@dataclass
class Encounter:
    """Two who come to each other, as one of them sees it.

    Two who each slow down before the place of the other meet at full speed: they slow down before
    the place where they meet.

    Attributes:
        coming: speed at which the partner comes nearer [m/s].
        leaving: speed at which it gets away [m/s].
        seen: place of the partner (3,) at the step before [m].
    """

    coming: float = 0.0
    leaving: float = 0.0
    seen: Array | None = None

    def share_of_way(
        self, controller: PersonController, partner: Array, touching: float, dt: float
    ) -> float:
        """Return how much of the way the partner comes itself [m].

        Args:
            controller: of the person.
            partner: (3,) where the partner is [m].
            touching: distance at which the way ends [m].
            dt: time since the last call [s].
        """
        ahead = controller.direction_to(partner)
        moved = np.zeros(3) if self.seen is None else partner - self.seen
        self.seen = partner.copy()
        share = min(dt / COMING_TIME, 1.0)
        away = float(moved @ ahead) / dt
        self.coming += share * (max(-away, 0.0) - self.coming)
        self.leaving += share * (max(away, 0.0) - self.leaving)
        own = math.hypot(*controller.record.velocity)
        left = max(controller.ground_distance(partner) - touching, 0.0)
        return left * self.coming / max(self.coming + own, LEAST_APPROACH)


def closing_pace(controller: PersonController, left: float, rate: float = CLOSING_RATE) -> float:
    """Return the pace of the last steps to a person [m/s].

    Args:
        controller: of the person.
        left: distance from touching [m].
        rate: at which the distance closes [1/s].
    """
    slowest = SLOWEST_FROUDE * math.sqrt(GRAVITY * float(controller.record.hip_height))
    return max(rate * left, slowest)
