"""Touching: when a hand comes to touch the body, the other hand or a drum."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation, SolidContact
from pipeline.simulation.spatial import Array

AGAIN = 0.09
"""How long a hand has to be clear of a solid to feel it again [s]."""

TOGETHER = 0.03
"""What a hand touches so soon after something else is felt as one [s]."""

LEAST = 0.003
"""Least speed of approach that is felt [m/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class HandStrike:
    """A hand has touched something.

    Attributes:
        time: when, of the dancer's own clock [s].
        hand: its solid.
        other: the solid it touched.
        place: (3,) [m].
        normal: (3,) out of what was touched.
        speed: of approach [m/s].
    """

    time: float
    hand: str
    other: str
    place: Array
    normal: Array
    speed: float


class HandContacts:
    """What the hands of a torso touch."""

    def __init__(self, moving: LinkageSimulation) -> None:
        self.moving = moving
        self._now: set[tuple[str, str]] = set()
        self._left: dict[tuple[str, str], float] = {}
        self._felt: dict[str, float] = {}

    def look(self, now: float, step: float, since: float) -> list[HandStrike]:
        """Return what hands have begun to touch.

        Args:
            now: the time at the end of the last step [s].
            step: its duration [s].
            since: when this was last asked [s].
        """
        if not self.moving.has_changed:
            return []
        then, before, found = now - step, self._now, list[HandStrike]()
        self._now = set()
        for touch in self.moving.touches():
            strike = self._strike(touch, then, since, before)
            if strike is not None:
                found.append(strike)
        for pair in before - self._now:
            self._left[pair] = then
        return found

    def _strike(
        self, touch: SolidContact, then: float, since: float, before: set[tuple[str, str]]
    ) -> HandStrike | None:
        hand, other, normal = touch.one, touch.other, -touch.normal
        if not hand.startswith("hand"):
            hand, other, normal = other, hand, touch.normal
        if not hand.startswith("hand") or touch.depth < 0.0:
            return None
        pair = hand, other
        self._now.add(pair)
        quiet = pair not in before and then - self._left.get(pair, -math.inf) > AGAIN
        quiet = quiet and then - self._felt.get(hand, -math.inf) > TOGETHER
        if not quiet or touch.speed < LEAST:
            return None
        self._felt[hand] = then
        # It touched when it was less deep, at the speed it came with.
        time = max(then - touch.depth / touch.speed, since)
        return HandStrike(time, hand, other, touch.place, normal, touch.speed)
