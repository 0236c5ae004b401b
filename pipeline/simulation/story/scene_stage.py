"""Scene stage: the state of a simulation that the conditions of beats read."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pipeline.simulation.event_monitor import are_near
from pipeline.simulation.members import Members
from pipeline.simulation.troupe import Troupe


class SceneStage:
    """Where members are and what people feel.

    Args:
        members: of all troupes.
        troupes: all of them.
        last_row: writes all rows so far, and returns the number of the last.
    """

    def __init__(
        self, members: Members, troupes: Sequence[Troupe], last_row: Callable[[], int]
    ) -> None:
        self._members, self._troupes, self._last_row = members, troupes, last_row

    def is_near(self, one: str, other: str, distance: float) -> bool:
        """See `Stage`."""
        self._members.update(self._last_row())
        # In this order whatever the author's is, for the same result.
        first, second = (self._members.state(name) for name in sorted((one, other)))
        return are_near(first, second, distance)

    def feeling(self, who: str, feeling: str) -> float:
        """See `Stage`."""
        for troupe in self._troupes:
            if who in (feelings := troupe.feelings()):
                return feelings[who].get(feeling, 0.0)
        return 0.0
