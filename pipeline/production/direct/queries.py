"""Queries: the state of a simulation as plain values."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from pipeline.simulation.signals import SIGNAL_KINDS
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene
from pipeline.spec.name_references import CAUSES


def finite_number(value: float) -> float | None:
    """Return a number for JSON, None if it is not finite."""
    return float(value) if math.isfinite(value) else None


def finite_numbers(values: Iterable[float]) -> list[float | None]:
    """Return numbers for JSON."""
    return [finite_number(value) for value in values]


State = dict[str, object]


class StateQueries:
    """Queries of a scene and of the present state of its simulation."""

    def __init__(self, scene: Scene, simulation: Simulation) -> None:
        self.scene = scene
        self.simulation = simulation
        nodes = simulation.recorder.nodes
        self.names = frozenset([m.name for m in scene.cast] + [node.performer for node in nodes])
        self._first: dict[str, int] = {}
        for i, node in enumerate(nodes):
            self._first.setdefault(node.performer, i)

    def state(self, topics: Collection[str], who: Collection[str]) -> State:
        """Return the state by topic, of some performers or of all."""
        row = self.simulation.last_row()
        return {topic: TOPICS[topic](self, row, frozenset(who) or self.names) for topic in topics}

    def time(self, row: int = 0, who: Collection[str] = ()) -> State:
        """Return step, frame and time of the simulation."""
        del row, who
        clock, step = self.simulation.world.clock, self.simulation.step_number
        return {
            "step": step,
            "frame": min(step // clock.steps + 1, clock.frames),
            "time": float(clock.time_of(step)),
            "steps_a_frame": clock.steps,
            "frames": clock.frames,
            "duration": float(clock.time_of(clock.last_step)),
            "finished": self.simulation.finished,
        }

    def performers(self, row: int, who: Collection[str]) -> State:
        """Return type and name of the cast."""
        del row
        return {
            member.name: {"is": type(member).__name__.lower(), "called": member.kind_name}
            for member in self.scene.cast
            if member.name in who
        }

    def places(self, row: int, who: Collection[str]) -> State:
        """Return the positions of the performers' first nodes [m]."""
        positions = self.simulation.recorder.positions[row]
        return {
            name: finite_numbers(positions[node])
            for name, node in self._first.items()
            if name in who
        }

    def poses(self, row: int, who: Collection[str]) -> State:
        """Return positions [m] and rotations wxyz of all nodes by name."""
        recorder = self.simulation.recorder
        p, q, alive = (x[row] for x in (recorder.positions, recorder.quaternions, recorder.alive))
        return {
            node.name: {"position": finite_numbers(p[i]), "rotation": finite_numbers(q[i])}
            for i, node in enumerate(recorder.nodes)
            if node.performer in who and alive[i]
        }

    def channels(self, row: int, who: Collection[str]) -> State:
        """Return the values of the channels by name."""
        recorder = self.simulation.recorder
        values = recorder.values[row]
        return {
            channel.name: finite_number(values[i])
            for i, channel in enumerate(recorder.channels)
            if channel.name.partition(".")[0] in who
        }

    def notes(self, row: int, who: Collection[str]) -> list[State]:
        """Return the notes so far."""
        del row
        return [
            {"kind": note.kind, "step": note.step, "part": note.part, "text": note.text}
            for note in self.simulation.recorder.notes
            if note.part.partition(".")[0] in who
        ]


TOPICS: Mapping[str, Callable[[StateQueries, int, Collection[str]], object]] = {
    "time": StateQueries.time,
    "performers": StateQueries.performers,
    "places": StateQueries.places,
    "poses": StateQueries.poses,
    "channels": StateQueries.channels,
    "notes": StateQueries.notes,
}
"""The method of each `requests.Topic`."""


# --- Notifications: events of a simulation since the last call, as plain values ---

NOTE_KIND, ORDER_KIND = "note", "told"

EVENT_KINDS = tuple(dict.fromkeys((*SIGNAL_KINDS, *CAUSES, NOTE_KIND, ORDER_KIND)))
"""Kinds of events: signals, sounds, notes, and orders that were given."""

Notification = dict[str, object]


class NotificationQueue:
    """Events of a simulation that were not returned yet."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._sounds = self._orders = 0
        self._notes = set[tuple[str, str]]()

    def since_last_call(self) -> list[Notification]:
        """Return the events since the last call; call it after every step."""
        return [*self._signals(), *self._new_sounds(), *self._new_notes(), *self._new_orders()]

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
        orders = self._simulation.recorder.told
        new, self._orders = orders[self._orders :], len(orders)
        for order in new:
            moment = self._moment(order.step)
            yield {"kind": ORDER_KIND, "who": order.who, "other": "", **moment, "text": order.text}

    def _moment(self, step: int, fraction: float = 0.0) -> Notification:
        clock = self._simulation.world.clock
        return {
            "step": step,
            "frame": clock.frame_of(step, fraction),
            "time": float(clock.time_of(step, fraction)),
        }
