"""Fall detector: finds members that fall: off their feet, on their side, over an edge, or down."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.members import Members, MemberState
from pipeline.simulation.terrain import Ground


@dataclass(frozen=True, slots=True)
class FallLimits:
    """When a member counts as fallen.

    Attributes:
        upright: fraction of its height above the ground at the start below which a member that
            stands by itself has fallen.
        toppled: fraction of its height at the start below which a thing lies on its side.
        sink: distance that a thing sinks within `sink_time` when it falls, in its heights and at
            least [m].
        least_sink: see `sink` [m].
        sink_time: [s].
    """

    upright: float = 0.5
    toppled: float = 0.6
    sink: float = 0.5
    least_sink: float = 0.2
    sink_time: float = 1.0


LIMITS = FallLimits()


class FallDetector:
    """Tests whether members have fallen, row by row.

    Args:
        members: of all troupes.
        ground: the terrain.
        standing: names of members that stand by themselves.
        row_time: from row to row [s].
    """

    def __init__(
        self, members: Members, ground: Ground, standing: Collection[str], row_time: float
    ) -> None:
        self._members, self._ground, self._standing = members, ground, standing
        self._sink_rows = max(round(LIMITS.sink_time / row_time), 1)
        self._heights: dict[str, deque[float]] = {}
        self._start_heights: dict[str, float] = {}

    def has_fallen(self, name: str) -> bool:
        """Returns whether a member has fallen, after a new row."""
        state = self._members.state(name)
        if name in self._standing:
            x, y, z = state.centre
            above = float(y - self._ground.height(np.array(x), np.array(z)))
            return above < LIMITS.upright * self._start_heights.setdefault(name, above)
        height = float(state.high[1] - state.low[1])
        lies = height < LIMITS.toppled * self._start_heights.setdefault(name, height)
        return lies or self._sinks(name, state, height)

    def _sinks(self, name: str, state: MemberState, height: float) -> bool:
        """Returns whether a thing went down fast."""
        y = float(state.centre[1])
        heights = self._heights.setdefault(name, deque(maxlen=self._sink_rows))
        heights.append(y)
        return max(heights) - y > max(LIMITS.sink * height, LIMITS.least_sink)
