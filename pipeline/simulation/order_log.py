"""Order log: what became of every order of the script.

An order that has an end is done, given up with a reason, replaced by another order, or cut off by
the end of the film.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from pipeline.simulation.order_outcome import Outcome
from pipeline.simulation.script import Orders, Script, event_of
from pipeline.simulation.take import NEVER_GIVEN, OrderRecord
from pipeline.simulation.troupe import Facts
from pipeline.spec.events import EVENTS
from pipeline.spec.script import Do, When, order_text
from pipeline.spec.verbs import GROUP, HOPPER, VERBS, WALKER, key_of_order

JUMPS = ("hop_over", "jump")
"""Orders of one jump, after which a creature goes on with what it did before."""

QUEUED: Mapping[str, tuple[str, ...]] = {WALKER: JUMPS, HOPPER: (*JUMPS, "turn_deg")}
"""Orders that replace no other, by kind of performer: they are carried out after it."""


@dataclass(eq=False)
class _Open:
    """An order that is not finished.

    Attributes:
        order: the object that the troupe was given.
        number: of its record.
    """

    order: Do
    number: int


class OrderLog:
    """The orders given so far, and their outcomes.

    Args:
        performers: kind of each performer by its name, a key of `PERFORMERS`.

    Attributes:
        records: of all orders, in the order of time.
        ended: of those that ended, in that order.
    """

    def __init__(self, performers: Mapping[str, str] = MappingProxyType({})) -> None:
        self._performers = performers
        self.records: list[OrderRecord] = []
        self.ended: list[OrderRecord] = []
        self._open: dict[str, list[_Open]] = {}
        self._replaced: dict[str, list[_Open]] = {}

    def give(self, step: int, orders: Orders) -> None:
        """Records the orders of a step."""
        for who, given in orders.items():
            for order in given:
                self._give(step, who, order)

    def is_open(self, who: str, order: Do) -> bool:
        """Returns whether an order, the object that was given, has not ended."""
        return any(last.order is order for last in self._open.get(who, ()))

    def _give(self, step: int, who: str, order: Do) -> None:
        key = key_of_order(order) or ""
        verb, performer = VERBS[key], self._performers.get(who)
        # Groups never arrive.
        if not verb.ends or performer == GROUP:
            outcome = "done" if verb.is_aside else "begun"
        else:
            outcome = ""
        if not verb.is_aside and key not in QUEUED.get(performer or "", ()):
            for last in self._open.pop(who, ()):
                self._close(last.number, step, "replaced")
                self._replaced.setdefault(who, []).append(last)
        self.records.append(
            OrderRecord(who, order_text(order), step, -1 if not outcome else step, outcome)
        )
        if not outcome:
            self._open.setdefault(who, []).append(_Open(order, len(self.records) - 1))

    def end(self, step: int, facts: Facts) -> None:
        """Records the ends of orders in a step."""
        for outcome in facts.outcomes:
            self._end(step, outcome)
        for who in facts.arrived:
            waiting = list[_Open]()
            for last in self._open.pop(who, ()):
                if self._performers.get(who) == WALKER and key_of_order(last.order) in JUMPS:
                    # It arrives beside what it is to jump over.
                    waiting.append(last)
                else:
                    self._close(last.number, step, "done")
            if waiting:
                self._open[who] = waiting

    def _end(self, step: int, outcome: Outcome) -> None:
        end = "given up" if outcome.reason else "done"
        # A jump that was under way is made although another order has replaced it.
        for orders in (self._open.get(outcome.who, []), self._replaced.get(outcome.who, [])):
            found = next((last for last in orders if last.order is outcome.order), None)
            if found is not None:
                orders.remove(found)
                self._close(found.number, step, end, outcome.reason)
                return
        if outcome.reason:
            text = order_text(outcome.order)
            self.records.append(OrderRecord(outcome.who, text, step, step, end, outcome.reason))

    def finish(self, step: int, script: Script) -> None:
        """Records orders that the film's end cuts off, and those that were never given.

        Args:
            step: the last one.
            script: with the instructions that were never given.
        """
        for orders in self._open.values():
            for last in orders:
                self._close(last.number, step, "cut off")
        self._open.clear()
        # What is due after the end is known, and told, before the simulation.
        for one in script.never_given:
            if one.when is not None:
                text = order_text(one.do)
                again = event_of(one.when) in script.happened
                reason = _awaited_text(one.when) + (" again" if again else "")
                record = OrderRecord(one.who, text, step, step, NEVER_GIVEN, reason)
                self.records.append(record)

    def _close(self, number: int, step: int, outcome: str, reason: str = "") -> None:
        record = self.records[number]
        self.records[number] = ended = OrderRecord(
            record.who, record.text, record.step, step, outcome, reason
        )
        self.ended.append(ended)


def _awaited_text(when: When) -> str:
    """Returns that an event never happened."""
    key = when.event
    value = getattr(when, key)
    names: Iterable[str] = [value] if isinstance(value, str) else value
    act = f" to {when.act}" if when.act else ""
    return EVENTS[key].never.format(names=" and ".join(names), within=when.within, act=act)
