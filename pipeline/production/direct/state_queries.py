"""State queries: the present state of a simulation as plain values."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping

from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene


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
"""The method of each `request_params.Topic`."""
