"""Rest detector: finds members that have moved and come to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.members import Members, MemberState
from pipeline.simulation.spatial import Array


@dataclass(frozen=True, slots=True)
class RestLimits:
    """When a member counts as moved and as at rest.

    Attributes:
        moved: distance from where it last rested at which it has moved, in its largest extent;
            less is the settling of a thing on the ground.
        most_moved: see `moved`; enough for a thing of any size [m].
        resting: speed below which it rests [m/s].
        rest_time: for which it has to rest [s].
    """

    moved: float = 0.2
    most_moved: float = 0.1
    resting: float = 0.03
    rest_time: float = 0.25


LIMITS = RestLimits()


class RestDetector:
    """Tests whether members come to rest, row by row.

    Args:
        members: of all troupes.
        row_time: from row to row [s].
    """

    def __init__(self, members: Members, row_time: float) -> None:
        self._members = members
        self._rest_rows = max(round(LIMITS.rest_time / row_time), 1)
        self._rested: dict[str, int] = {}
        self._last_places: dict[str, Array] = {}

    def come_to_rest(self, names: Sequence[str]) -> bool:
        """Returns whether one of some members has moved and all of them rest, after a new row.

        It is true in one row: then they have to move again.
        """
        states = {name: self._members.state(name) for name in names}
        resting = [self._rests(name, state) for name, state in states.items()]
        moved = [name for name, state in states.items() if self._has_moved(name, state)]
        if not (moved and all(resting)):
            return False
        self._last_places.update((name, states[name].centre) for name in moved)
        return True

    def _rests(self, name: str, state: MemberState) -> bool:
        """Returns whether a member has rested for long enough; what is gone rests."""
        slow = float(np.linalg.norm(state.v)) < LIMITS.resting
        self._rested[name] = self._rested.get(name, 0) + 1 if slow else 0
        return self._rested[name] >= self._rest_rows or not state.is_present

    def _has_moved(self, name: str, state: MemberState) -> bool:
        last = self._last_places.setdefault(name, state.centre)
        distance = min(LIMITS.moved * float((state.high - state.low).max()), LIMITS.most_moved)
        return state.is_present and float(np.linalg.norm(state.centre - last)) > distance
