"""News: what has happened since it was last asked for, as messages tell it."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.production.direct.numbers import number, numbers
from pipeline.simulation.signals import SIGNAL_KINDS
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Note, SoundEvent
from pipeline.spec.name_references import CAUSES

NOTE, TOLD = "note", "told"

ALL_KINDS = tuple(dict.fromkeys((*SIGNAL_KINDS, *CAUSES, NOTE, TOLD)))
"""What is told of: happenings, sounds, notes to the author, and instructions when given."""

Item = dict[str, object]


class News:
    """What one simulation has to tell after each step."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._sounds = self._told = 0
        self._notes = set[tuple[str, str]]()

    def since(self) -> list[Item]:
        """Return what has happened since the last call; to be called after every step."""
        return [*self._happenings(), *self._new_sounds(), *self._new_notes(), *self._new_orders()]

    def _happenings(self) -> Iterator[Item]:
        at = self._moment(self._simulation.step_number)
        for one in self._simulation.signals:
            yield {"kind": one.kind, "who": one.who, "other": one.other, **at}

    def _new_sounds(self) -> Iterator[Item]:
        events = self._simulation.recorder.events
        new, self._sounds = events[self._sounds :], len(events)
        # Of what is a happening too that is told.
        return (self._sound(event) for event in new if event.cause not in SIGNAL_KINDS)

    def _sound(self, event: SoundEvent) -> Item:
        return {
            "kind": event.cause,
            "who": event.who,
            "other": event.other,
            **self._moment(event.step, event.fraction),
            "part": event.part,
            "place": numbers(event.place),
            "strength": number(event.strength),
        }

    def _new_notes(self) -> Iterator[Item]:
        for note in self._simulation.recorder.notes:
            if (of := (note.kind, note.part)) not in self._notes:
                self._notes.add(of)
                yield self._note(note)

    def _note(self, note: Note) -> Item:
        who = note.part.partition(".")[0]
        words = {"part": note.part, "text": f"{note.kind}: {note.text}"}
        return {"kind": NOTE, "who": who, "other": "", **self._moment(note.step), **words}

    def _new_orders(self) -> Iterator[Item]:
        told = self._simulation.recorder.orders
        new, self._told = told[self._told :], len(told)
        for one in new:
            moment = self._moment(one.step)
            yield {"kind": TOLD, "who": one.who, "other": "", **moment, "text": one.text}

    def _moment(self, step: int, fraction: float = 0.0) -> Item:
        clock = self._simulation.world.clock
        return {
            "step": step,
            "frame": clock.frame_of(step, fraction),
            "time": float(clock.time_of(step, fraction)),
        }
