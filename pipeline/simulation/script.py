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


Event = str | frozenset[str]
"""Who has arrived, or who touch one another."""


def _event(instruction: Instruction) -> Event:
    """Return what an instruction waits for."""
    when = instruction.when
    if when is None:
        return ""
    return when.arrived or frozenset(when.touch or ())


class Script:
    """The instructions of a scene that are not given yet."""

    def __init__(self, instructions: Sequence[Instruction], clock: Clock) -> None:
        self.clock = clock
        self._timed: dict[int, list[tuple[str, Do]]] = {}
        self._waiting: list[Instruction] = []
        for one in instructions:
            if one.at is None:
                self._waiting.append(one)
            else:
                self._at(clock.step_from(one.at), one.who, one.do)

    def orders(
        self, step: int, arrived: Collection[str], touched: Collection[tuple[str, str]] = ()
    ) -> Orders:
        """Return what is to be done from `step` on.

        Args:
            step: that is about to be taken.
            arrived: who has just come to the end of its way.
            touched: pairs who have just begun to touch one another.
        """
        due = self._timed.pop(step, [])
        events = {*arrived, *(frozenset(pair) for pair in touched)}
        due += self._happened(events) if events else []
        given: dict[str, list[Do]] = {}
        for who, do in due:
            given.setdefault(who, []).append(do)
            if isinstance(do, Wait):
                self._at(step + max(self.clock.step_from(do.wait), 1), who, "walk")
        return given

    def _happened(self, events: Collection[Event]) -> list[tuple[str, Do]]:
        """Return what waited for these events, the first for each performer and event."""
        given: dict[tuple[str, Event], Do] = {}
        left = []
        for one in self._waiting:
            event = _event(one)
            if event in events and (one.who, event) not in given:
                given[one.who, event] = one.do
            else:
                left.append(one)
        self._waiting = left
        return [(who, do) for (who, _), do in given.items()]

    def _at(self, step: int, who: str, do: Do) -> None:
        self._timed.setdefault(step, []).append((who, do))
