"""Script: turns timed and conditional instructions into the orders of a step.

An instruction is given once: at the first step at or after its time, or in the step after the
event that it waits for. Of several that wait for the same event, those to one performer are given
one after the other, each time that it happens.

Source: Sims 1987, 3.2.4.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from pipeline.simulation.clock import Clock
from pipeline.spec.script import Do, Instruction, Wait, When

Orders = Mapping[str, Sequence[Do]]
"""Orders of a step by performer."""


class Event(NamedTuple):
    """Something that instructions wait for.

    Attributes:
        kind: one of `pipeline.spec.events.EVENTS`.
        names: members that it happens to; in alphabetical order for a pair without direction.
        distance: that counts as near [m].
        act: the order that fails, a key of `VERBS`; "" for any.
    """

    kind: str
    names: tuple[str, ...]
    distance: float = 0.0
    act: str = ""


def event_of(when: When) -> Event:
    """Returns the event of a condition of the script."""
    value = getattr(when, when.event)
    if when.event in ("touch", "near"):
        distance = when.within if when.event == "near" else 0.0
        return Event(when.event, tuple(sorted(value)), distance)
    names = (value,) if isinstance(value, str) else value
    return Event(when.event, names, act=when.act or "")


PerformerOrder = tuple[str, Do]
"""Performer and order."""


class Script:
    """Pending instructions of a scene, and those from outside.

    In one step the scene's timed ones come first, then those from outside, those of beats, `walk`
    after a `wait`, and those that waited for an event. So instructions from outside may be written
    into the scene at the times at which they were given, with the same result.

    Attributes:
        told: instructions from outside that were given: step, performer, and order.
        happened: events that have happened.
    """

    def __init__(self, instructions: Sequence[Instruction], clock: Clock) -> None:
        self.clock = clock
        self.told: list[tuple[int, str, Do]] = []
        self._timed: dict[int, list[PerformerOrder]] = {}
        self._outside: dict[int, list[PerformerOrder]] = {}
        self._resumed: dict[int, list[PerformerOrder]] = {}
        self.happened: set[Event] = set()
        self._waiting: list[Instruction] = []
        self._late: list[Instruction] = []
        self._waiting_outside: list[Instruction] = []
        self._beats: dict[int, list[Instruction]] = {}
        self._waiting_in_beat: list[Instruction] = []
        # Instructions of a beat that begins with this step wait from the next one on.
        self._new_in_beat: list[Instruction] = []
        for one in instructions:
            if one.at is None:
                self._waiting.append(one)
            elif clock.step_from(one.at) < clock.last_step:
                _schedule(self._timed, clock.step_from(one.at), one)
            else:
                self._late.append(one)

    @property
    def due_from_outside(self) -> int:
        """Number of pending instructions from outside."""
        return sum(map(len, self._outside.values())) + len(self._waiting_outside)

    def tell(self, instruction: Instruction, step: int) -> None:
        """Adds an instruction from outside, before `step` is taken."""
        if instruction.at is None:
            self._waiting_outside.append(instruction)
        else:
            _schedule(self._outside, max(self.clock.step_from(instruction.at), step), instruction)

    def add(self, instructions: Iterable[Instruction], step: int) -> None:
        """Adds instructions of a beat, before `step` is taken; their times count from it."""
        for one in instructions:
            if one.when is not None:
                self._new_in_beat.append(one)
            else:
                due = step + self.clock.step_from(one.at or 0.0)
                self._beats.setdefault(due, []).append(one)

    def is_pending(self, instructions: Iterable[Instruction]) -> bool:
        """Returns whether any instruction of a beat is not given yet."""
        waiting = (*self._waiting_in_beat, *self._new_in_beat)
        pending = {id(one) for several in (*self._beats.values(), waiting) for one in several}
        return any(id(one) in pending for one in instructions)

    def withdraw(self, instructions: Iterable[Instruction]) -> None:
        """Removes the instructions of a beat that are not given yet."""
        gone = {id(one) for one in instructions}
        for waiting in (*self._beats.values(), self._waiting_in_beat, self._new_in_beat):
            waiting[:] = [one for one in waiting if id(one) not in gone]

    @property
    def awaited(self) -> set[Event]:
        """Events that pending instructions wait for."""
        waiting = (*self._waiting, *self._waiting_outside)
        waiting += (*self._waiting_in_beat, *self._new_in_beat)
        return {event_of(one.when) for one in waiting if one.when is not None}

    @property
    def never_given(self) -> Sequence[Instruction]:
        """Instructions of the scene that still wait, for an event or for a time."""
        return (*self._late, *self._waiting)

    def orders(self, step: int, events: Collection[Event]) -> Orders:
        """Returns the orders of a step.

        Args:
            step: the step about to be taken.
            events: that have just happened.
        """
        self.happened.update(events)
        outside = self._outside.pop(step, []) + _take_triggered(self._waiting_outside, events)
        self.told.extend((step, who, do) for who, do in outside)
        due = self._timed.pop(step, []) + outside
        due += [(one.who, one.do) for one in self._beats.pop(step, [])]
        due += _take_triggered(self._waiting_in_beat, events)
        self._waiting_in_beat += self._new_in_beat
        self._new_in_beat = []
        due += self._resumed.pop(step, []) + _take_triggered(self._waiting, events)
        given: dict[str, list[Do]] = {}
        for who, do in due:
            given.setdefault(who, []).append(do)
            if isinstance(do, Wait):
                on = step + max(self.clock.step_from(do.wait), 1)
                self._resumed.setdefault(on, []).append((who, "walk"))
        return given


def _schedule(steps: dict[int, list[PerformerOrder]], step: int, instruction: Instruction) -> None:
    steps.setdefault(step, []).append((instruction.who, instruction.do))


def _take_triggered(waiting: list[Instruction], events: Collection[Event]) -> list[PerformerOrder]:
    """Removes and returns the instructions that wait for `events`, one per performer and event."""
    if not events or not waiting:
        return []
    given: dict[tuple[str, Event | None], Do] = {}
    left = []
    for one in waiting:
        event = event_of(one.when) if one.when is not None else None
        if event in events and (one.who, event) not in given:
            given[one.who, event] = one.do
        else:
            left.append(one)
    waiting[:] = left
    return [(who, do) for (who, _), do in given.items()]
