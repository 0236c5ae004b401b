"""Notification queue: events of a simulation since the last call, as plain values."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.production.direct.state_queries import finite_number, finite_numbers
from pipeline.simulation.signals import SIGNAL_KINDS
from pipeline.simulation.simulate import Simulation
from pipeline.spec.name_references import CAUSES

NOTE_KIND, ORDER_KIND, OUTCOME_KIND = "note", "told", "ended"

EVENT_KINDS = tuple(dict.fromkeys((*SIGNAL_KINDS, *CAUSES, NOTE_KIND, ORDER_KIND, OUTCOME_KIND)))
"""Kinds of events: signals, sounds, notes, orders that were given, and orders that ended."""

Notification = dict[str, object]


class NotificationQueue:
    """Events of a simulation that were not returned yet."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._sounds = self._orders = self._ended = 0
        self._notes = set[tuple[str, str]]()

    def since_last_call(self) -> list[Notification]:
        """Return the events since the last call; call it after every step."""
        return [
            *(*self._signals(), *self._new_sounds(), *self._new_notes()),
            *(*self._new_orders(), *self._new_outcomes()),
        ]

    def _signals(self) -> Iterator[Notification]:
        at = self._moment(self._simulation.step_number)
        for signal in self._simulation.signals:
            yield {"kind": signal.kind, "who": signal.who, "other": signal.other, **at}

    def _new_sounds(self) -> Iterator[Notification]:
        events = self._simulation.recorder.events
        new, self._sounds = events[self._sounds :], len(events)
        # Others are reported as signals.
        for event in new:
            if event.cause not in SIGNAL_KINDS:
                yield {
                    "kind": event.cause,
                    "who": event.who,
                    "other": event.other,
                    **self._moment(event.step, event.fraction),
                    "part": event.part,
                    "place": finite_numbers(event.place),
                    "strength": finite_number(event.strength),
                }

    def _new_notes(self) -> Iterator[Notification]:
        for note in self._simulation.recorder.notes:
            if (key := (note.kind, note.part)) not in self._notes:
                self._notes.add(key)
                who, moment = note.part.partition(".")[0], self._moment(note.step)
                text = {"part": note.part, "text": f"{note.kind}: {note.text}"}
                yield {"kind": NOTE_KIND, "who": who, "other": "", **moment, **text}

    def _new_orders(self) -> Iterator[Notification]:
        orders = self._simulation.order_log.records
        new, self._orders = orders[self._orders :], len(orders)
        for order in new:
            moment = self._moment(order.step)
            yield {"kind": ORDER_KIND, "who": order.who, "other": "", **moment, "text": order.text}

    def _new_outcomes(self) -> Iterator[Notification]:
        orders = self._simulation.order_log.ended
        new, self._ended = orders[self._ended :], len(orders)
        for order in new:
            facts = {"text": order.text, "outcome": order.outcome, "reason": order.reason}
            yield {
                "kind": OUTCOME_KIND,
                "who": order.who,
                "other": "",
                **self._moment(order.end),
                **facts,
            }

    def _moment(self, step: int, fraction: float = 0.0) -> Notification:
        clock = self._simulation.world.clock
        return {
            "step": step,
            "frame": clock.frame_of(step, fraction),
            "time": float(clock.time_of(step, fraction)),
        }
