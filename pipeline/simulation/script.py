"""Script: from timed and conditional instructions to the orders of a step.

An instruction is given once: at the first step at or after its time, or in the step after
what it waits for has happened. Of several that wait for the same, those to one performer are
given one after the other, each time that it happens.

Source: Sims 1987, 3.2.4.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from pipeline.simulation.clock import Clock
from pipeline.spec.script import Do, Instruction, Wait

Orders = Mapping[str, Sequence[Do]]
"""What each performer is to do now, by its name."""


Event = str | frozenset[str] | tuple[str, str]
"""Who has arrived, who touch one another, or who hugs whom."""


def _event(instruction: Instruction) -> Event:
    """Return what an instruction waits for."""
    when = instruction.when
    if when is None:
        return ""
    return when.arrived or when.hug or frozenset(when.touch or ())


Given = tuple[str, Do]
"""To whom, and what."""


class Script:
    """The instructions of a scene that are not given yet, and those from outside.

    In one step the scene's timed ones go first, then those from outside, then `walk` after a
    `wait`, then what has waited for something to happen. So those from outside may be written
    into the scene, at the times at which they were given, and it goes the same way.

    Attributes:
        told: from outside, given so far: the step, who, and what.
    """

    def __init__(self, instructions: Sequence[Instruction], clock: Clock) -> None:
        self.clock = clock
        self.told: list[tuple[int, str, Do]] = []
        self._timed: dict[int, list[Given]] = {}
        self._outside: dict[int, list[Given]] = {}
        self._resumed: dict[int, list[Given]] = {}
        self._waiting: list[Instruction] = []
        self._waiting_outside: list[Instruction] = []
        for one in instructions:
            if one.at is None:
                self._waiting.append(one)
            else:
                _at(self._timed, clock.step_from(one.at), one)

    @property
    def due_from_outside(self) -> int:
        """Number of instructions from outside that are not given yet."""
        return sum(map(len, self._outside.values())) + len(self._waiting_outside)

    def tell(self, instruction: Instruction, step: int) -> None:
        """Take in an instruction from outside, before `step` is taken."""
        if instruction.at is None:
            self._waiting_outside.append(instruction)
        else:
            _at(self._outside, max(self.clock.step_from(instruction.at), step), instruction)

    def orders(
        self,
        step: int,
        arrived: Collection[str],
        touched: Collection[tuple[str, str]] = (),
        hugged: Collection[tuple[str, str]] = (),
    ) -> Orders:
        """Return what is to be done from `step` on.

        Args:
            step: that is about to be taken.
            arrived: who has just come to the end of its way.
            touched: pairs who have just begun to touch one another.
            hugged: who has just closed its arms around whom.
        """
        events: set[Event] = {*arrived, *(frozenset(pair) for pair in touched), *hugged}
        outside = self._outside.pop(step, []) + _happened(self._waiting_outside, events)
        self.told.extend((step, who, do) for who, do in outside)
        due = self._timed.pop(step, []) + outside
        due += self._resumed.pop(step, []) + _happened(self._waiting, events)
        given: dict[str, list[Do]] = {}
        for who, do in due:
            given.setdefault(who, []).append(do)
            if isinstance(do, Wait):
                on = step + max(self.clock.step_from(do.wait), 1)
                self._resumed.setdefault(on, []).append((who, "walk"))
        return given


def _at(steps: dict[int, list[Given]], step: int, instruction: Instruction) -> None:
    steps.setdefault(step, []).append((instruction.who, instruction.do))


def _happened(waiting: list[Instruction], events: Collection[Event]) -> list[Given]:
    """Take from `waiting` what waited for these events, the first for each performer and event."""
    if not events or not waiting:
        return []
    given: dict[tuple[str, Event], Do] = {}
    left = []
    for one in waiting:
        event = _event(one)
        if event in events and (one.who, event) not in given:
            given[one.who, event] = one.do
        else:
            left.append(one)
    waiting[:] = left
    return [(who, do) for (who, _), do in given.items()]
