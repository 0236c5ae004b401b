"""Hand contacts: when a hand touches the body, the other hand or a drum."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation, SolidContact
from pipeline.simulation.spatial import Array

RELEASE_TIME = 0.09
"""Time without contact after which a hand may strike the same solid again [s]."""

MERGE_TIME = 0.03
"""Contacts of one hand within this time count as one strike [s]."""

SPEED_THRESHOLD = 0.003
"""Approach speed below which a contact is no strike [m/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class HandStrike:
    """A hand strikes a solid.

    Attributes:
        time: time on the dancer's clock [s].
        hand: solid of the hand.
        other: solid that is struck.
        place: (3,) contact point [m].
        normal: (3,) outward normal of `other`.
        speed: approach speed [m/s].
    """

    time: float
    hand: str
    other: str
    place: Array
    normal: Array
    speed: float


class HandContacts:
    """Strikes of a torso's hands."""

    def __init__(self, moving: LinkageSimulation) -> None:
        self.moving = moving
        self._touching: set[tuple[str, str]] = set()
        self._released: dict[tuple[str, str], float] = {}
        self._last_strike: dict[str, float] = {}

    def update(self, now: float, step: float, since: float) -> list[HandStrike]:
        """Returns the strikes since the last call.

        Args:
            now: time at the end of the last step [s].
            step: duration of the step [s].
            since: time of the last call [s].
        """
        if not self.moving.has_changed:
            return []
        then, before, found = now - step, self._touching, list[HandStrike]()
        self._touching = set()
        for touch in self.moving.touches():
            strike = self._strike(touch, then, since, before)
            if strike is not None:
                found.append(strike)
        for pair in before - self._touching:
            self._released[pair] = then
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
        self._touching.add(pair)
        quiet = pair not in before and then - self._released.get(pair, -math.inf) > RELEASE_TIME
        quiet = quiet and then - self._last_strike.get(hand, -math.inf) > MERGE_TIME
        if not quiet or touch.speed < SPEED_THRESHOLD:
            return None
        self._last_strike[hand] = then
        # Extrapolate back from the penetration depth at the approach speed.
        time = max(then - touch.depth / touch.speed, since)
        return HandStrike(time, hand, other, touch.place, normal, touch.speed)
