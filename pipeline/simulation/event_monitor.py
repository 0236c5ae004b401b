"""Event monitor: finds the events that instructions of the script wait for.

Some are facts of a troupe (arrived, hug, touches of characters). The others are conditions on
where members are, and happen when a condition begins to hold. They are tested only while an
instruction waits for them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.simulation.clock import Clock
from pipeline.simulation.convex_distance import box_distance, convex_distance
from pipeline.simulation.members import Members, MemberState
from pipeline.simulation.script import Event
from pipeline.simulation.take import Contact
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import Facts


@dataclass(frozen=True, slots=True)
class EventLimits:
    """When members count as touching, fallen and at rest.

    Attributes:
        touch: distance between solids at which they touch [m].
        upright: fraction of its height at the start below which a standing member has fallen.
        sink: distance that a thing sinks within `sink_time` when it falls, in its heights and at
            least [m].
        least_sink: see `sink` [m].
        sink_time: [s].
        moving: speed above which a member moves [m/s].
        resting: speed below which it rests [m/s].
        rest_time: for which it has to rest [s].
    """

    touch: float = 0.004
    upright: float = 0.5
    sink: float = 0.5
    least_sink: float = 0.2
    sink_time: float = 1.0
    moving: float = 0.1
    resting: float = 0.03
    rest_time: float = 0.25


LIMITS = EventLimits()

CONDITIONS = ("touch", "near", "fell", "at_rest")
"""Events that are conditions on where members are."""


def reported_events(facts: Facts) -> set[Event]:
    """Returns the events that troupes themselves report."""
    return {
        *(Event("arrived", (name,)) for name in facts.arrived),
        *(Event("touch", (min(pair), max(pair))) for pair in facts.touched),
        *(Event("hug", (s.who, s.other)) for s in facts.signals if s.kind == "hug"),
    }


class EventMonitor:
    """Tests the conditions that instructions wait for.

    Args:
        members: of all troupes.
        clock: of the scene.
        ground: the terrain.
        owners: performer of each part, by the name of the part.
        standing: names of members that stand by themselves.
    """

    def __init__(
        self,
        members: Members,
        clock: Clock,
        ground: Ground,
        owners: Mapping[str, str],
        standing: Collection[str],
    ) -> None:
        self._members, self._ground = members, ground
        self._owners, self._standing = owners, standing
        row = clock.dt * (clock.steps // clock.samples)
        self._sink_rows = max(round(LIMITS.sink_time / row), 1)
        self._rest_rows = max(round(LIMITS.rest_time / row), 1)
        self._held: set[Event] = set()
        self._heights: dict[str, deque[float]] = {}
        self._start_heights: dict[str, float] = {}
        self._moved: set[str] = set()
        self._rested: dict[str, int] = {}

    def needs_members(self, awaited: Iterable[Event]) -> bool:
        """Returns whether any awaited event depends on where members are."""
        return any(event.kind in CONDITIONS for event in awaited)

    def events(self, awaited: Iterable[Event], contacts: Iterable[Contact]) -> set[Event]:
        """Returns the awaited conditions that begin to hold, after a new row."""
        touched = {
            frozenset((contact.performer, self._owners.get(contact.other, contact.other)))
            for contact in contacts
        }
        holding = {event for event in awaited if self._holds(event, touched)}
        began = holding - self._held
        self._held = holding
        return began

    def _holds(self, event: Event, touched: Collection[frozenset[str]]) -> bool:
        if event.kind == "fell":
            return self._has_fallen(event.names[0])
        if event.kind == "at_rest":
            return self._has_come_to_rest(event.names[0])
        if event.kind not in CONDITIONS:
            return False
        one, other = (self._members.state(name) for name in event.names)
        if event.kind == "near":
            return are_near(one, other, event.distance)
        return frozenset(event.names) in touched or are_near(one, other, LIMITS.touch)

    def _has_fallen(self, name: str) -> bool:
        state = self._members.state(name)
        x, y, z = state.centre
        if name in self._standing:
            above = float(y - self._ground.height(np.array(x), np.array(z)))
            start = self._start_heights.setdefault(name, above)
            return above < LIMITS.upright * start
        heights = self._heights.setdefault(name, deque(maxlen=self._sink_rows))
        heights.append(float(y))
        height = float(state.high[1] - state.low[1])
        return max(heights) - float(y) > max(LIMITS.sink * height, LIMITS.least_sink)

    def _has_come_to_rest(self, name: str) -> bool:
        speed = float(np.linalg.norm(self._members.state(name).v))
        if speed > LIMITS.moving:
            self._moved.add(name)
        self._rested[name] = self._rested.get(name, 0) + 1 if speed < LIMITS.resting else 0
        return name in self._moved and self._rested[name] >= self._rest_rows


def are_near(one: MemberState, other: MemberState, distance: float) -> bool:
    """Returns whether the surfaces of two members are within a distance [m]."""
    gaps = np.maximum(np.maximum(other.low - one.high, one.low - other.high), 0.0)
    if float(np.linalg.norm(gaps)) > distance or not (one.is_present and other.is_present):
        return False
    pairs = (
        (a, b)
        for a in one.solids or (one.centre[None],)
        for b in other.solids or (other.centre[None],)
        if box_distance(a, b) <= distance
    )
    return any(convex_distance(a, b) <= distance for a, b in pairs)
