"""Event monitor: finds the events that instructions of the script wait for.

Some are facts of a troupe (arrived, hug, failed, touches of characters). The others are conditions
on where members are, and happen when a condition begins to hold. They are tested only while an
instruction waits for them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np

from pipeline.simulation.clock import Clock
from pipeline.simulation.convex_distance import box_distance, convex_distance
from pipeline.simulation.fall_detector import FallDetector
from pipeline.simulation.members import Members, MemberState
from pipeline.simulation.rest_detector import RestDetector
from pipeline.simulation.script import Event
from pipeline.simulation.take import Contact
from pipeline.simulation.terrain import Ground
from pipeline.simulation.troupe import Facts
from pipeline.spec.verbs import key_of_order

TOUCH_DISTANCE = 0.004
"""Distance between solids at which they touch [m]."""

CONDITIONS = ("touch", "near", "fell", "at_rest")
"""Events that are conditions on where members are."""


def reported_events(facts: Facts) -> set[Event]:
    """Returns the events that troupes themselves report."""
    return {
        *(Event("arrived", (name,)) for name in facts.arrived),
        *(Event("touch", (min(pair), max(pair))) for pair in facts.touched),
        *(Event("hug", (s.who, s.other)) for s in facts.signals if s.kind == "hug"),
        *(Event("served", (s.who,)) for s in facts.signals if s.kind == "served"),
        *_failures(facts),
    }


def _failures(facts: Facts) -> Iterator[Event]:
    """Yields the failures of orders, each as one of its kind of order and as one of any kind."""
    for outcome in facts.outcomes:
        if outcome.reason:
            for act in ("", key_of_order(outcome.order) or ""):
                yield Event("failed", (outcome.who,), act=act)


class EventMonitor:
    """Tests the conditions that instructions wait for.

    Args:
        members: of all troupes.
        clock: of the scene.
        ground: the terrain.
        owners: performer of each part, by the name of the part.
        standing: names of members that stand by themselves.
        bodies_of: names of the bodies of each member that is many.
    """

    def __init__(
        self,
        members: Members,
        clock: Clock,
        ground: Ground,
        owners: Mapping[str, str],
        standing: Collection[str],
        bodies_of: Mapping[str, Sequence[str]],
    ) -> None:
        self._members, self._owners, self._bodies_of = members, owners, bodies_of
        row_time = clock.dt * (clock.steps // clock.samples)
        self._falls = FallDetector(members, ground, standing, row_time)
        self._rests = RestDetector(members, row_time)
        self._held: set[Event] = set()
        self._fallen: dict[str, set[str]] = {}

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
        began = {event for event in holding if event not in self._held or self._recurs(event)}
        self._held = holding
        return began

    def _holds(self, event: Event, touched: Collection[frozenset[str]]) -> bool:
        if event.kind not in CONDITIONS:
            return False
        name = event.names[0]
        if event.kind == "fell":
            return self._another_fell(name) if name in self._bodies_of else self._fell(name)
        if event.kind == "at_rest":
            return self._rests.come_to_rest(self._bodies_of.get(name, (name,)))
        one, other = (self._members.state(name) for name in event.names)
        if event.kind == "near":
            return are_near(one, other, event.distance)
        return frozenset(event.names) in touched or are_near(one, other, TOUCH_DISTANCE)

    def _recurs(self, event: Event) -> bool:
        """Returns whether an event may happen again in the next row: bodies of many fall apart."""
        return event.kind == "fell" and event.names[0] in self._bodies_of

    def _fell(self, name: str) -> bool:
        return self._falls.has_fallen(name)

    def _another_fell(self, name: str) -> bool:
        """Returns whether one of many bodies fell that had not before."""
        before = self._fallen.setdefault(name, set())
        fell = {body for body in self._bodies_of[name] if self._fell(body)} - before
        before |= fell
        return bool(fell)


def are_near(one: MemberState, other: MemberState, distance: float) -> bool:
    """Returns whether the surfaces of two members are within a distance [m]."""
    boxes = [np.vstack([member.low, member.high, member.loose]) for member in (one, other)]
    if box_distance(*boxes) > distance or not (one.is_present and other.is_present):
        return False
    pairs = ((a, b) for a in one.shapes for b in other.shapes if box_distance(a, b) <= distance)
    return any(convex_distance(a, b) <= distance for a, b in pairs)
